#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Copies frames with motion blur, in which Blender leaves Vector zero, and gives them the vectors of the
same frames without blur: what estimated motion is measured against.

    scripts/splice_vectors.py BLURRED SHARP OUT

All three are folders of noisy.####.exr as scripts/blender_shots.py writes them; BLURRED and SHARP are the
same shot with --blur above 0 and --blur 0. Needs NumPy.
"""
import argparse
import pathlib
import sys

import picture_files  # beside this file


def main():
    parser = argparse.ArgumentParser(prog="splice_vectors.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("blurred", "sharp", "out"):
        parser.add_argument(name, type=pathlib.Path)
    options = parser.parse_args()
    frames = sorted(options.blurred.glob("noisy.*.exr"))
    if not frames:
        sys.exit(f"splice_vectors.py: {options.blurred} has no noisy.####.exr")
    options.out.mkdir(parents=True, exist_ok=True)
    for path in frames:
        planes, sharp = picture_files.read_exr(path), picture_files.read_exr(options.sharp / path.name)
        vectors = {name: plane for name, plane in sharp.items() if ".Vector." in name}
        if not vectors or any(plane.shape != planes[name].shape for name, plane in vectors.items()):
            sys.exit(f"splice_vectors.py: {options.sharp / path.name} has no Vector of the size of {path}")
        picture_files.write_exr(options.out / path.name, {**planes, **vectors}, picture_files.read_texts(path))


main()
