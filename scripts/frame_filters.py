#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Filters of OpenCV that denoise each frame alone, for scripts/comparison.py.

    scripts/frame_filters.py bilateral SETTINGS INPUT OUTPUT FRAMES
    scripts/frame_filters.py nlm SETTINGS INPUT OUTPUT FRAMES

INPUT is a folder of noisy.####.exr as `stillray render --save-inputs` writes them; OUTPUT gets
denoised.####.exr for FRAMES, a list such as 8,16,24. SETTINGS is a JSON object. The last line of
output holds the processor time per frame. Needs NumPy and OpenCV (Debian: python3-opencv).
"""
import argparse
import json
import pathlib
import sys
import time

import numpy as np

import picture_files  # beside this file

# Of the denoiser too: docs/denoiser.md, demodulate.
ALBEDO_FLOOR = 0.01
# Light that is filtered together, and the albedo that it is divided by.
LIGHT = [(("direct_diffuse", "indirect_diffuse"), "albedo"),
         (("direct_specular", "indirect_specular"), "specular_albedo"),
         (("direct_transmission", "indirect_transmission"), "transmission_albedo")]
# The values that are tried, and the first ones.
GRIDS = {
    "bilateral": {"sigma_space": [0.7, 1, 1.5, 2, 3, 4, 6, 8],
                  "sigma_guide": [0.05, 0.1, 0.2, 0.4, 0.8, 1.6], "albedo_weight": [0, 0.5, 1],
                  "depth_weight": [0, 0.5, 1, 2, 4, 8], "curve": ["linear", "log"]},
    "nlm": {"strength": [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64], "template": [1, 3, 5, 7],
            "search": [5, 7, 11, 21]},
}
FIRST = {
    "bilateral": {"sigma_space": 4, "sigma_guide": 0.2, "albedo_weight": 0.5, "depth_weight": 2,
                  "curve": "linear"},
    "nlm": {"strength": 0.08, "template": 5, "search": 21},
}
FAR = 10.0  # a guide's distance of pixels without a surface


def layer_or(planes, name, other):
    found = picture_files.layer(planes, name)
    return other if found is None else found


def split_light(planes):
    """The picture as [(light, albedo)] and what is not filtered: emission and background."""
    colour = picture_files.layer(planes, "")
    black, white = np.zeros_like(colour), np.ones_like(colour)
    kept = layer_or(planes, "emission", black) + layer_or(planes, "background", black)
    parts = []
    for names, albedo in LIGHT:
        layers = [picture_files.layer(planes, name) for name in names]
        layers = [found for found in layers if found is not None]
        if layers:
            parts.append((sum(layers), layer_or(planes, albedo, white)))
    if not parts:
        parts = [(np.maximum(colour - kept, 0), layer_or(planes, "albedo", white))]
    return parts, kept


def guide(planes, settings):
    """Three channels, all that OpenCV takes: the normal, with albedo and the logarithm of depth added,
    so that a difference of each is a distance.
    """
    colour = picture_files.layer(planes, "")
    normal = picture_files.layer(planes, "normal", "XYZ")
    if normal is None:
        normal = np.zeros_like(colour)
    joint = normal + settings["albedo_weight"] * layer_or(planes, "albedo", np.zeros_like(colour))
    if "depth.Z" in planes:
        depth = planes["depth.Z"].astype(np.float32)
        surface = (depth > 0) & (depth < 1e9)
        joint += settings["depth_weight"] * np.log(np.where(surface, depth, 1))[..., None]
        joint[~surface] = FAR
    return np.ascontiguousarray(joint, np.float32)


def bilateral(planes, settings, cv):
    """Joint bilateral filter of light divided by albedo."""
    joint = guide(planes, settings)
    sigma = settings["sigma_space"]
    there, back = (np.log1p, np.expm1) if settings["curve"] == "log" else (np.array, np.array)
    parts, out = split_light(planes)
    for light, albedo in parts:
        divisor = np.maximum(albedo, ALBEDO_FLOOR)
        source = np.ascontiguousarray(there(np.maximum(light, 0) / divisor), np.float32)
        smooth = cv.ximgproc.jointBilateralFilter(joint, source, int(4 * sigma) + 1,
                                                  settings["sigma_guide"], sigma)
        out = out + back(smooth) * divisor
    return out


def nlm(planes, settings, cv):
    """Non-local means of the whole picture, which gets no guides, under x / (1 + x)."""
    colour = np.maximum(picture_files.layer(planes, ""), 0)
    steps = 65535
    coded = np.rint(colour / (1 + colour) * (steps - 1)).astype(np.uint16)
    smooth = cv.fastNlMeansDenoising(coded, [settings["strength"] * steps], None,
                                     settings["template"], settings["search"], cv.NORM_L1)
    curved = smooth.astype(np.float32) / steps
    return curved / (1 - curved)


FILTERS = {"bilateral": bilateral, "nlm": nlm}


def psnr(test, reference):
    """As docs/metrics.md has it."""
    test, reference = np.maximum(test, 0), np.maximum(reference, 0)
    error = np.mean((test / (1 + test) - reference / (1 + reference)) ** 2, dtype=np.float64)
    return -10 * np.log10(max(error, 1e-30))


def tune(first, grids, quality):
    """The settings with the highest quality(settings): one setting after the other, until none of them
    gets better.
    """
    best, best_quality = dict(first), quality(first)
    improved = True
    while improved:
        improved = False
        for name, values in grids.items():
            for value in values:
                if value == best[name]:
                    continue
                found = quality({**best, name: value})
                if found > best_quality:
                    best, best_quality, improved = {**best, name: value}, found, True
    return best


def tune_filter(name, frames, cv):
    """\\param frames  (planes of a noisy frame, reference (height, width, 3))"""
    return tune(FIRST[name], GRIDS[name], lambda settings: np.mean(
        [psnr(FILTERS[name](planes, settings, cv), reference) for planes, reference in frames]))


def opencv():
    """The module cv2 with the joint bilateral filter, on one thread, or None."""
    try:
        import cv2  # pylint: disable=import-outside-toplevel
    except ImportError:
        return None
    if not hasattr(cv2, "ximgproc"):
        return None
    cv2.setNumThreads(1)
    return cv2


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("filter", choices=list(FILTERS))
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("input", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("frames")
    arguments = parser.parse_args()
    cv = opencv()
    if cv is None:
        sys.exit("error: OpenCV with ximgproc is missing, expected Debian's python3-opencv")
    arguments.output.mkdir(parents=True, exist_ok=True)
    times = []
    for frame in arguments.frames.split(","):
        planes = picture_files.read_exr(arguments.input / f"noisy.{int(frame):04d}.exr")
        start = time.process_time()
        picture = FILTERS[arguments.filter](planes, arguments.settings, cv)
        times.append(1000 * (time.process_time() - start))
        picture_files.write_exr(arguments.output / f"denoised.{int(frame):04d}.exr",
                                {c: picture[..., i].astype(np.float32) for i, c in enumerate("RGB")})
    print(json.dumps({"ms_per_frame": sum(times) / len(times)}))


if __name__ == "__main__":
    main()
