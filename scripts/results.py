#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Measures the presets on scenes and writes docs/results.md.

    scripts/results.py [--scene NAME=PATH ...] [--work out/results] [--only cornell,lights]

Converged references are rendered first, which takes many minutes a scene. What is finished is kept in
the work folder: remove it to render again. Then every preset renders the frames up to the references,
and stillray compare sets the last ones against them.
"""
import argparse
import pathlib
import subprocess
import sys

from measured import ROOT, compare, named, run, specks, table, value  # beside this file

BUILTIN = ["cornell", "spheres", "lights", "mirrors", "thin"]
# Row, folder, options.
RUNS = [
    ("`default`", "default", ["--preset", "default", "--aov", "temporal"]),
    ("`best`", "best", ["--preset", "best"]),
    ("`default`, each frame alone", "alone", ["--preset", "default", "--set", "temporal=off"]),
    ("`svgf`", "svgf", ["--preset", "svgf"]),
    ("`temporal`", "temporal-plain", ["--preset", "temporal"]),
    ("`temporal`, antialiased", "temporal", ["--preset", "temporal", "--set", "antialias=taa"]),
    ("`eaw`", "eaw", ["--preset", "eaw"]),
]
FRAMES = (40, 41)
FIRST_FRAMES = [1, 2, 4, 8]
SIZE = "384x216"
REFERENCE_SPP = 512
# Elsewhere only reflections change.
MOVING_LIGHT = ["cornell", "lights"]


def regions(values):
    return "{brightness_lowest:.2f} to {brightness_highest:.2f}".format(**values)


# Title, cell.
MEASURES = [("FLIP", value("flip", "{:.4f}")), ("SSIM", value("ssim", "{:.4f}")),
            ("relMSE", value("rel_mse", "{:.4f}")), ("PSNR, dB", value("psnr", "{:.2f}")),
            ("brightness", value("brightness", "{:.4f}")), ("regions", regions),
            ("specks", specks), ("worst 1 %", value("worst_share", "{:.2f}")),
            ("temporal error", value("temporal_error", "{:.5f}")),
            ("light change", value("light_change", "{:.2f}"))]
# Of single frames.
FRAME_MEASURES = [m for m in MEASURES if m[0] not in ("temporal error", "light change")]


def render_reference(stillray, name, scene, work, first, last):
    folder = work / f"{name}-reference-{first}"
    if not (folder / "render.json").exists():
        run(stillray, "render", scene, "-o", folder, "--size", SIZE, "--frames", f"{first}-{last}",
            "--reference", REFERENCE_SPP, "--format", "exr,png", "--seed", 1000, "--resume")
    return folder


def measure(stillray, test, reference, picture, first, last):
    return compare(stillray, test / f"{picture}.####.exr", reference / "reference.####.exr",
                   test / f"{picture}-{first}.json", "--frames", f"{first}-{last}")


def measure_scene(stillray, name, scene, work):
    """The rows of both tables: of all presets, and of the first frames of `default`."""
    reference = render_reference(stillray, name, scene, work, *FRAMES)
    rows = []
    first_rows = []
    for row, suffix, options in RUNS:
        folder = work / f"{name}-{suffix}"
        run(stillray, "render", scene, "-o", folder, "--size", SIZE, "--frames", f"1-{FRAMES[1]}",
            "--format", "exr,png", "--save-inputs", "--aov", "motion,depth", "--resume",
            *options)
        if suffix == "default":
            rows.append(("noisy", measure(stillray, folder, reference, "noisy", *FRAMES)))
            for frame in FIRST_FRAMES:
                known = render_reference(stillray, name, scene, work, frame, frame)
                values = measure(stillray, folder, known, "denoised", frame, frame)
                first_rows.append((f"`default`, frame {frame}", values))
        rows.append((row, measure(stillray, folder, reference, "denoised", *FRAMES)))
    for _, values in rows:
        if name not in MOVING_LIGHT:
            values.pop("light_change", None)
    return rows, first_rows


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stillray", default=ROOT / "build/apps/stillray/stillray")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/results")
    parser.add_argument("--scene", action="append", default=[], metavar="NAME=PATH")
    parser.add_argument("--only", help="names of the scenes to measure; default: all")
    parser.add_argument("--references-only", action="store_true")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/results.md")
    arguments = parser.parse_args()

    scenes = [(name, f"builtin:{name}") for name in BUILTIN]
    scenes += named(arguments.scene)
    if arguments.only:
        by_name = dict(scenes)
        scenes = [(name, by_name[name]) for name in arguments.only.split(",")]
    arguments.work.mkdir(parents=True, exist_ok=True)

    sections = []
    for name, scene in scenes:
        if arguments.references_only:
            for first, last in [FRAMES] + [(frame, frame) for frame in FIRST_FRAMES]:
                render_reference(arguments.stillray, name, scene, arguments.work, first, last)
            continue
        rows, first_rows = measure_scene(arguments.stillray, name, scene, arguments.work)
        sections.append(f"## {name}\n\n{table(rows, MEASURES)}\n\n"
                        f"{table(first_rows, FRAME_MEASURES)}\n")
    if sections:
        intro = (ROOT / "scripts/results_intro.md").read_text()
        arguments.output.write_text(intro + "\n" + "\n".join(sections))
        print(f"wrote {arguments.output}")


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, ValueError) as error:
        sys.exit(f"error: {error}")
