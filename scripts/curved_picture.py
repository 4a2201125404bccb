#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Makes docs/images/curved.png: curved mirrors and glass in Blender's frames of one sample, without and
with Denoising Data. Needs blender and NumPy.

  scripts/curved_picture.py [--program build/apps/stillray/stillray] [--work FOLDER]

FOLDER keeps the frames of the shot, which take some minutes to render, for the next time.
"""
import argparse
import pathlib
import subprocess
import tempfile

import numpy as np

from picture_files import read_exr, write_png
from stage_pictures import enlarge, montage

ROOT = pathlib.Path(__file__).resolve().parent.parent
FRAME = 15
CROP = (122, 104, 190, 104)  # x, y, width, height


def render(folder):
    if not (folder / f"reference.{FRAME:04d}.exr").exists():
        subprocess.run(["blender", "-b", "--factory-startup", "-P", str(ROOT / "scripts/blender_shots.py"), "--",
                        "--shot", "curved", "--samples", "1", "--size", "384x216", "--frames", str(FRAME), "--judged",
                        str(FRAME), "--reference", "512", "--filter-width", "0.01", "--out", str(folder)],
                       check=True, stdout=subprocess.DEVNULL)


def picture(path):
    """Bytes for display: x / (1 + x), gamma 2.2."""
    layers = read_exr(path)
    prefix = next(name[:-1] for name in layers if name.endswith("Combined.R"))
    light = np.stack([layers[prefix + c] for c in "RGB"], axis=-1).astype(np.float32)
    light = np.maximum(light, 0)
    return (255 * (light / (1 + light)) ** (1 / 2.2) + 0.5).astype(np.uint8)


def denoise(program, folder, out, *options):
    subprocess.run([program, "denoise", str(folder / "noisy.####.exr"), "-o", str(out), "--window", "past", *options],
                   check=True, stdout=subprocess.DEVNULL)
    return picture(out / f"noisy.{FRAME:04d}.exr")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/apps/stillray/stillray"))
    parser.add_argument("--work", type=pathlib.Path, help="folder for the frames")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.work or pathlib.Path(temporary) / "curved"
        render(folder)
        out = pathlib.Path(temporary)
        panels = [picture(folder / f"noisy.{FRAME:04d}.exr"),
                  denoise(arguments.program, folder, out / "without", "--aov", "seen_depth=none"),
                  denoise(arguments.program, folder, out / "with"),
                  picture(folder / f"reference.{FRAME:04d}.exr")]
    panels = [enlarge(panel, 3, *CROP) for panel in panels]
    write_png(ROOT / "docs/images/curved.png", montage(panels, 2))


if __name__ == "__main__":
    main()
