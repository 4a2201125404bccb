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
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILTIN = ["cornell", "spheres", "lights"]
# Row, folder, options.
RUNS = [
    ("`default`", "default", ["--preset", "default", "--aov", "temporal"]),
    ("`svgf`", "svgf", ["--preset", "svgf"]),
    ("`temporal`", "temporal-plain", ["--preset", "temporal"]),
    ("`temporal`, antialiased", "temporal", ["--preset", "temporal", "--set", "antialias=taa"]),
    ("`eaw`", "eaw", ["--preset", "eaw"]),
]
FRAMES = (40, 41)
SIZE = "640x360"
REFERENCE_SPP = 1024
# Where noise falls slowly and full references would take most of an hour.
REFERENCE_SPP_OF = {"lights": 512}
SIZE_OF = {"lights": "320x180"}
MEASURES = [("flip", "FLIP", "{:.4f}"), ("ssim", "SSIM", "{:.4f}"), ("rel_mse", "relMSE", "{:.4f}"),
            ("psnr", "PSNR, dB", "{:.2f}"), ("brightness", "brightness", "{:.4f}"),
            ("temporal_error", "temporal error", "{:.5f}")]


def run(*command):
    print("+", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)


def render_reference(stillray, name, scene, folder):
    if (folder / "render.json").exists():
        return
    run(stillray, "render", scene, "-o", folder, "--size", SIZE_OF.get(name, SIZE), "--frames",
        f"{FRAMES[0]}-{FRAMES[1]}", "--reference", REFERENCE_SPP_OF.get(name, REFERENCE_SPP), "--format", "exr,png", "--seed", 1000, "--resume")


def measure(stillray, test, reference, report):
    run(stillray, "compare", test / "{}.####.exr".format(report), reference / "reference.####.exr",
        "--frames", f"{FRAMES[0]}-{FRAMES[1]}", "--json", test / f"{report}.json")
    return json.loads((test / f"{report}.json").read_text())["mean"]


def measure_scene(stillray, name, scene, work):
    reference = work / f"{name}-reference"
    render_reference(stillray, name, scene, reference)
    rows = []
    for row, suffix, options in RUNS:
        folder = work / f"{name}-{suffix}"
        run(stillray, "render", scene, "-o", folder, "--size", SIZE_OF.get(name, SIZE), "--frames", f"1-{FRAMES[1]}",
            "--format", "exr,png", "--save-inputs", "--aov", "motion,depth", "--resume",
            *options)
        if suffix == "default":
            rows.append(("noisy", measure(stillray, folder, reference, "noisy")))
        rows.append((row, measure(stillray, folder, reference, "denoised")))
    return rows


def table(rows):
    lines = ["| | " + " | ".join(title for _, title, _ in MEASURES) + " |",
             "|---|" + "---|" * len(MEASURES)]
    for name, values in rows:
        cells = []
        for key, _, form in MEASURES:
            value = values.get(key)
            cells.append("-" if value is None else form.format(value))
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


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
    scenes += [tuple(text.split("=", 1)) for text in arguments.scene]
    if arguments.only:
        by_name = dict(scenes)
        scenes = [(name, by_name[name]) for name in arguments.only.split(",")]
    arguments.work.mkdir(parents=True, exist_ok=True)

    sections = []
    for name, scene in scenes:
        if arguments.references_only:
            render_reference(arguments.stillray, name, scene, arguments.work / f"{name}-reference")
            continue
        rows = measure_scene(arguments.stillray, name, scene, arguments.work)
        sections.append(f"## {name}\n\n{table(rows)}\n")
    if sections:
        intro = (ROOT / "scripts/results_intro.md").read_text()
        arguments.output.write_text(intro + "\n" + "\n".join(sections))
        print(f"wrote {arguments.output}")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"error: {error}")
