# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Shots of scripts/blender_shots.py, small, rendered and denoised: light that is random at first hits
has much less noise afterwards, and the same mean.

    shots_test.py ROOT PROGRAM
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT, PROGRAM = pathlib.Path(sys.argv[1]), sys.argv[2]
BLENDER = shutil.which("blender")
if BLENDER is None:
    print("skipped: Blender is not installed")
    sys.exit(77)

import numpy as np  # noqa: E402

sys.path.insert(0, str(ROOT / "scripts"))
import picture_files  # noqa: E402

FRAMES = 4
SHOTS = [("smoke", []), ("cloud", ["--transparent"])]


def run(*command):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}")


def planes(path):
    found = picture_files.read_exr(path)
    return {c: found[f"ViewLayer.Combined.{c}"].astype(np.float64) for c in "RGBA"}


def roughness(plane):
    """Mean square of what a pixel differs from the mean of its four neighbours."""
    inner = plane[1:-1, 1:-1]
    around = (plane[:-2, 1:-1] + plane[2:, 1:-1] + plane[1:-1, :-2] + plane[1:-1, 2:]) / 4
    return float(((inner - around) ** 2).mean())


def check(shot, options, folder):
    run(BLENDER, "-b", "--factory-startup", "--python-exit-code", 1, "-P", ROOT / "scripts/blender_shots.py",
        "--", "--shot", shot, "--samples", 2, "--size", "96x54", "--frames", FRAMES, "--judged", "",
        "--out", folder, *options)
    alpha = "denoise" if options else "keep"
    run(PROGRAM, "denoise", folder / "noisy.####.exr", "-o", folder / "clean.####.exr", "--alpha", alpha)
    noisy, clean = (planes(folder / f"{name}.{FRAMES:04d}.exr") for name in ("noisy", "clean"))
    for channel in "GA" if options else "G":
        before, after = (roughness(picture[channel]) for picture in (noisy, clean))
        means = noisy[channel].mean(), clean[channel].mean()
        print(f"{shot} {channel}: roughness {before:.5f} -> {after:.5f}, mean {means[0]:.4f} -> {means[1]:.4f}")
        if not after < 0.25 * before:
            sys.exit(f"{shot}: {channel} keeps its noise")
        if not abs(means[1] - means[0]) < 0.03 * means[0]:
            sys.exit(f"{shot}: the mean of {channel} changes")


with tempfile.TemporaryDirectory() as work:
    for name, more in SHOTS:
        check(name, more, pathlib.Path(work) / name)
