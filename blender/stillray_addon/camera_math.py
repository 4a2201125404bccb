# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Matrices of cameras and their file, without bpy. The format is described in docs/cameras.md.

Matrices are sequences of four rows.
"""
import json
import math
import os

VERSION = 1


def without_scale(matrix):
    """Axes of unit length, as Cycles takes cameras: a scaled parent does not scale the picture."""
    rows = [list(row) for row in matrix]
    for column in range(3):
        length = math.sqrt(sum(rows[r][column] ** 2 for r in range(3)))
        if length > 0:
            for r in range(3):
                rows[r][column] /= length
    return rows


def inverse(matrix):
    """Of any invertible 4x4 matrix, by Gauss-Jordan elimination with pivoting."""
    rows = [list(map(float, row)) + [float(i == j) for j in range(4)]
            for i, row in enumerate(matrix)]
    for i in range(4):
        pivot = max(range(i, 4), key=lambda r: abs(rows[r][i]))
        if rows[pivot][i] == 0:
            raise ValueError("the matrix of a camera is singular")
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for r in range(4):
            if r != i:
                rows[r] = [v - rows[r][i] * w for v, w in zip(rows[r], rows[i])]
    return [row[4:] for row in rows]


def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def world_to_camera(camera_to_world):
    return inverse(without_scale(camera_to_world))


def cropped(projection, border):
    """The projection of a part of the picture: min x, min y, max x, max y in 0 to 1, y up."""
    x0, y0, x1, y1 = border
    scale_x, scale_y = 1 / (x1 - x0), 1 / (y1 - y0)
    crop = [[scale_x, 0, 0, scale_x * (1 - x0 - x1)], [0, scale_y, 0, scale_y * (1 - y0 - y1)],
            [0, 0, 1, 0], [0, 0, 0, 1]]
    return multiply(crop, projection)


def flat(matrix):
    return [float(v) + 0.0 for row in matrix for v in row]


def border_pixels(border, width, height):
    """The border that Blender renders with Crop to Render Region: whole pixels. Corners are rounded
    as Blender's pipeline does, by cutting the fraction off."""
    x0, y0 = int(border[0] * width), int(border[1] * height)
    x1, y1 = int(border[2] * width), int(border[3] * height)
    return (x0 / width, y0 / height, x1 / width, y1 / height), x1 - x0, y1 - y0


def marker_camera(markers, frame, default):
    """The camera that Blender uses: that of the last marker with a camera at or before the frame,
    else of the first one after it. markers: [(frame, camera)]."""
    bound = sorted((m for m in markers if m[1] is not None), key=lambda m: m[0])
    if not bound:
        return default
    before = [m for m in bound if m[0] <= frame]
    return before[-1][1] if before else bound[0][1]


def read(file):
    """The document in a file; None if there is none that can be used."""
    try:
        with open(file, encoding="utf-8") as stream:
            document = json.load(stream)
        good = document["version"] == VERSION and all("frame" in f for f in document["frames"])
        return document if good else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def write(file, width, height, records):
    """Adds records to the file, by frame; those of another size of picture are dropped."""
    old = read(file)
    frames = {}
    if old is not None and (old.get("width"), old.get("height")) == (width, height):
        frames = {record["frame"]: record for record in old["frames"]}
    frames.update({record["frame"]: record for record in records})
    lines = ",\n".join("  " + json.dumps(frames[n]) for n in sorted(frames))
    text = (f'{{"version": {VERSION}, "width": {width}, "height": {height}, "frames": [\n'
            f"{lines}\n]}}\n")
    temporary = f"{file}.{os.getpid()}.tmp"
    with open(temporary, "w", encoding="utf-8") as stream:
        stream.write(text)
    os.replace(temporary, file)


_CLOCK_SECONDS = 2.0  # resolution of the times of files, on FAT


def can_be_used(file, names, frames):
    """True if the file has a projection for each of the frames, and none was rendered after it was
    written: on a render farm without the add-on, cameras may have changed since."""
    document = read(file)
    usable = {f["frame"] for f in document["frames"] if f.get("projection")} if document else set()
    if not set(frames) <= usable:
        return False
    newest = max(os.path.getmtime(names.file(frame)) for frame in frames)
    return os.path.getmtime(file) + _CLOCK_SECONDS >= newest
