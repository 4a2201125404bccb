#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Renders a still view with far less than one path per pixel and writes docs/progressive.md.

    scripts/progressive.py [--scene NAME=PATH ...] [--size 1366x690] [--spp 1/128]

Raw next to filtered at some frames, against a converged reference, which takes many minutes a scene
at the full size. What is finished is kept in the work folder: remove it to render again. Needs NumPy.
"""
import argparse
import pathlib
import shlex
import subprocess
import sys

import numpy as np

import picture_files  # beside this file
from measured import ROOT, compare, named, run

BUILTIN = ["cornell"]
FRAMES = [5, 20, 88, 190]
CROP = (288, 192)  # of the pictures in the documentation, pixels
MARGIN = 4
# Pictures of noise hardly shrink: the lowest bits of their values are left out.
KEPT_BITS = 0xf8


def still(arguments, scene, folder, *options):
    """Frames of the view that the scene's first frame shows, as display pictures."""
    run(arguments.stillray, "render", scene, "-o", folder, "--size", arguments.size, "--still",
        "--no-jitter", "--format", "png", "--resume", *options)


def sparse(arguments, scene, folder, preset, guides):
    """The frames asked for; the others are removed once all are there."""
    still(arguments, scene, folder, "--frames", f"1-{max(FRAMES)}", "--spp", arguments.spp,
          "--guides", guides, "--preset", preset,
          # The publication's, which also averages a view without jitter.
          *([] if preset == "temporal" else ["--set", "antialias=taa"]))
    for picture in folder.glob("*.png"):
        if int(picture.name.split(".")[1]) not in FRAMES:
            picture.unlink()
    return folder


def measure(arguments, test, reference):
    return compare(arguments.stillray, test, reference, test.with_suffix(".json"))


def picture(folder, frame):
    return folder / f"denoised.{frame:04d}.png"


def table(rows):
    """\\param rows  name of a column to a list of measures, one per frame"""
    lines = ["| frame | " + " | ".join(f"{name}, FLIP | SSIM" for name in rows) + " |",
             "|---|" + "---|---|" * len(rows)]
    for i, frame in enumerate(FRAMES):
        cells = [f"{values[i]['flip']:.4f} | {values[i]['ssim']:.4f}" for values in rows.values()]
        lines.append(f"| {frame} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def verdict(rows):
    """Says whether the filtered picture at frame 20 is better than the raw one at frame 190."""
    raw = rows["raw"][FRAMES.index(190)]
    lines = []
    for name, values in rows.items():
        if name == "raw":
            continue
        value = values[FRAMES.index(20)]
        words = ["lower" if value["flip"] < raw["flip"] else "**not lower**",
                 "higher" if value["ssim"] > raw["ssim"] else "**not higher**"]
        lines.append(f"{name} at frame 20 against raw at frame 190: FLIP {words[0]}, SSIM {words[1]}.")
    return "\n".join(lines)


def shrink(image, width, height):
    """Nearest pixels: enough to show what the view is."""
    y = (np.arange(height) + 0.5) * image.shape[0] / height
    x = (np.arange(width) + 0.5) * image.shape[1] / width
    return image[y.astype(int)][:, x.astype(int)]


def contact_sheet(folders, reference, path):
    """Above raw, below filtered, from left to right the frames; at the end the view and its middle
    as they should be.

    \\param folders  two: of raw and of filtered pictures
    """
    full = picture_files.read_png(reference)
    height, width = (min(have, want) for have, want in zip(full.shape, CROP[::-1]))
    top, left = (full.shape[0] - height) // 2, (full.shape[1] - width) // 2

    def crop(image):
        return image[top:top + height, left:left + width]

    columns = [[crop(picture_files.read_png(picture(folder, frame))) for folder in folders]
               for frame in FRAMES]
    columns.append([shrink(full, width, height), crop(full)])
    sheet = np.full((2 * height + MARGIN, len(columns) * (width + MARGIN) - MARGIN, 3), 255,
                    np.uint8)
    for i, column in enumerate(columns):
        for j, cell in enumerate(column):
            y, x = j * (height + MARGIN), i * (width + MARGIN)
            sheet[y:y + height, x:x + width] = cell & KEPT_BITS
    picture_files.write_png(path, sheet)


def measure_scene(arguments, name, scene):
    work = arguments.work / f"{name}-{arguments.size}"
    reference = work / "reference/reference.0001.png"
    if not reference.exists():
        still(arguments, scene, reference.parent, "--frames", "1", "--preset", "temporal",
              "--reference", arguments.reference, "--seed", "1000")
    # All guides, so that plain accumulation never loses what it has; the paths are the same.
    tag = arguments.spp.replace("/", "-")
    folders = {"raw": sparse(arguments, scene, work / f"raw-{tag}", "temporal", "full")}
    for preset in arguments.presets.split(","):
        folders[f"`{preset}`"] = sparse(arguments, scene, work / f"{preset}-{tag}-{arguments.guides}",
                                        preset, arguments.guides)
    rows = {column: [measure(arguments, picture(folder, frame), reference) for frame in FRAMES]
            for column, folder in folders.items()}
    first = arguments.presets.split(",")[0]
    image = arguments.images / f"progressive_{name}.png"
    contact_sheet([folders["raw"], folders[f"`{first}`"]], reference, image)
    alt = f"Frames {', '.join(map(str, FRAMES))} raw and filtered"
    text = (f"## {name}\n\n![{alt}](images/{image.name})\n\n*Above raw, below `{first}`, the middle of "
            f"the picture in its own pixels: frames {', '.join(map(str, FRAMES))}; at the end the whole "
            f"view, and the reference of {arguments.reference} paths per pixel.*\n\n")
    return text + table(rows) + "\n\n" + verdict(rows) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stillray", default=ROOT / "build/apps/stillray/stillray")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/progressive")
    parser.add_argument("--scene", action="append", default=[], metavar="NAME=PATH")
    parser.add_argument("--size", default="1366x690")
    parser.add_argument("--spp", default="1/128")
    parser.add_argument("--guides", default="sparse", choices=["full", "sparse"])
    parser.add_argument("--presets", default="default",
                        help="list of filters to compare; the first is shown")
    parser.add_argument("--reference", default="1024", help="paths per pixel of the references")
    parser.add_argument("--images", type=pathlib.Path, default=ROOT / "docs/images")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/progressive.md")
    arguments = parser.parse_args()

    scenes = [(name, f"builtin:{name}") for name in BUILTIN]
    scenes += named(arguments.scene)
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.images.mkdir(parents=True, exist_ok=True)
    sections = [measure_scene(arguments, name, scene) for name, scene in scenes]
    options = [f"--scene {name}={pathlib.Path(path).name}" for name, path in scenes[len(BUILTIN):]]
    options += [f"--presets {shlex.quote(arguments.presets)}", f"--reference {arguments.reference}"]
    made_by = (f"Made by\n\n    scripts/progressive.py {' '.join(options)}\n\n"
               f"{arguments.size}, {arguments.spp} path per pixel and frame, {arguments.guides} guides.\n")
    intro = (ROOT / "scripts/progressive_intro.md").read_text()
    arguments.output.write_text(intro + "\n" + made_by + "\n" + "\n".join(sections))
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, ValueError) as error:
        sys.exit(f"error: {error}")
