# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Shots of scripts/blender_shots.py, small, rendered and denoised: light that is random at first hits
has much less noise afterwards, and the same mean. With motion blur Vector is zero, and can be that of the
same shot without it.

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


def vectors(folder):
    found = picture_files.read_exr(folder / "noisy.0002.exr")
    return np.stack([found[f"ViewLayer.Vector.{c}"] for c in "XYZW"]), found["ViewLayer.Combined.G"]


def check_vectors(work):
    folders = {name: work / name for name in ("blurred", "sharp", "fast", "spliced")}
    for name, options in (("blurred", ["--blur", 0.5]), ("sharp", ["--blur", 0]), ("fast", ["--speed", 2])):
        run(BLENDER, "-b", "--factory-startup", "--python-exit-code", 1, "-P", ROOT / "scripts/blender_shots.py",
            "--", "--shot", "room", "--samples", 1, "--size", "96x54", "--frames", 2, "--judged", "",
            "--filter-width", 0.01, "--out", folders[name], *options)
    run(sys.executable, ROOT / "scripts/splice_vectors.py", *(folders[n] for n in ("blurred", "sharp", "spliced")))
    blurred, sharp, fast, spliced = (vectors(folders[n]) for n in ("blurred", "sharp", "fast", "spliced"))
    speeds = [float(np.hypot(*found[0][:2]).max()) for found in (sharp, fast)]
    print(f"longest vectors: {speeds[0]:.2f}, twice as fast {speeds[1]:.2f}")
    if blurred[0].any() or not 1.8 * speeds[0] < speeds[1] < 2.2 * speeds[0]:
        sys.exit("vectors are not those of --blur and --speed")
    if (spliced[0] != sharp[0]).any() or (spliced[1] != blurred[1]).any():
        sys.exit("splice_vectors.py: expected the vectors of the sharp frame and the light of the blurred one")
    texts = [picture_files.read_texts(folders[n] / "noisy.0002.exr") for n in ("blurred", "spliced")]
    if texts[0] != texts[1] or texts[0].get("cycles.ViewLayer.samples") != "1":
        sys.exit(f"splice_vectors.py: text attributes {texts[1]}, expected {texts[0]}")


with tempfile.TemporaryDirectory() as work:
    check_vectors(pathlib.Path(work))
    for name, more in SHOTS:
        check(name, more, pathlib.Path(work) / name)
