#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Repeats the experiments of the papers with the published filters and writes docs/papers.md.

    scripts/papers.py [--size 320x180] [--frames 16] [--reference 512]

Noisy frames and references are rendered once per scene and kept in the work folder, as is every
measure: remove it to start again.
"""
import argparse
import dataclasses
import json
import pathlib
import subprocess
import sys
import typing

from measured import ROOT, compare, run

SCENES = ["cornell", "lights", "spheres", "colonnade"]
MEASURED_FRAMES = 2
# Frames of files are not antialiased unless it is asked for.
ANTIALIASED = ["--set", "antialias=taa"]
SVGF = ["--preset", "svgf"]
ONE_SIGNAL = SVGF + ["--set", "signals=single"]
STEPS = "1,2,4,8,16"
BACKWARDS = "16,8,4,2,1"


def settings(*assignments):
    return [part for text in assignments for part in ("--set", text)]


def levels(count):
    """The first levels of a filter, small steps first; feedback needs the first one."""
    if count == 0:
        return settings("wavelet=off", "feedback=0")
    return settings("steps=" + ",".join(STEPS.split(",")[:count]))


@dataclasses.dataclass
class Series:
    """A table: rows of settings on all scenes."""
    title: str
    claim: str
    rows: dict[str, list[str]]  # name to options of stillray denoise
    holds: typing.Callable[[dict], bool]  # of the measures of each row on one scene
    verdict: str
    temporal: bool = False


def better(name, other, key="flip"):
    return lambda rows: rows[name][key] < rows[other][key]


SERIES = [
    Series(
        "Levels of the wavelet",
        "Each level improves diffuse surfaces; glossy ones are blurred too far (CUDA EAW and SVGF). "
        "More levels are smoother and less sharp (Faust).",
        {str(n): SVGF + levels(n) for n in range(6)},
        lambda rows: all(rows[str(n + 1)]["flip"] < rows[str(n)]["flip"] for n in range(3)),
        "each of the first three levels lowers FLIP"),
    Series(
        "Filters by kind of surface",
        "Both filters are good at diffuse surfaces and weak at glossy ones; SVGF is better than EAW, and EAW "
        "better than the wavelet without edge-stopping weights (CUDA EAW and SVGF).",
        {"`naive`": ["--preset", "eaw", "--set", "wavelet=naive"],
         "`eaw`, sigma_normal 0.02": ["--preset", "eaw", "--set", "eaw_sigma_n=0.1414"],
         "`eaw`, sigma_normal 0.2": ["--preset", "eaw", "--set", "eaw_sigma_n=0.4472"],
         "`svgf`": SVGF,
         "`default`": ["--preset", "default"]},
        lambda rows: (rows["`svgf`"]["flip"] < rows["`eaw`, sigma_normal 0.02"]["flip"]
                      < rows["`naive`"]["flip"]),
        "FLIP falls from naive to EAW to SVGF", temporal=True),
    Series(
        "Weight of a new frame",
        "A small alpha is smoother, but leaves ghosts of what moves; a large one follows motion, but is noisier "
        "(Faust).",
        {alpha: ONE_SIGNAL + settings(f"alpha_min={alpha}", f"alpha_moments={alpha}")
         for alpha in ("0.01", "0.1", "0.2", "0.4")},
        lambda rows: (rows["0.01"]["temporal_error"] < rows["0.4"]["temporal_error"]
                      and rows["0.01"]["flip"] > min(rows["0.1"]["flip"], rows["0.2"]["flip"])),
        "0.01 flickers less than 0.4, but its FLIP is above the best of 0.1 and 0.2", temporal=True),
    Series(
        "Level that becomes history",
        "History from the last level has less noise and less detail than from the first (Faust).",
        {str(n): ONE_SIGNAL + settings(f"feedback={n}") for n in (0, 1, 2, 3, 5)},
        lambda rows: (rows["5"]["temporal_error"] < rows["1"]["temporal_error"]
                      and rows["5"]["flip"] > rows["1"]["flip"]),
        "level 5 flickers less than level 1 and has the higher FLIP", temporal=True),
    Series(
        "Order of the levels",
        "Large steps first remove the artefacts of earlier passes, and variance still steers the filter (PSVGF).",
        {"small first, history from the first": SVGF,
         "small first, no feedback": SVGF + settings("feedback=0"),
         "large first, history from the last": SVGF + settings(f"steps={BACKWARDS}", "feedback=5"),
         "large first, no feedback": SVGF + settings(f"steps={BACKWARDS}", "feedback=0")},
        better("large first, no feedback", "small first, no feedback"),
        "without feedback, large steps first have the lower FLIP", temporal=True),
    Series(
        "Variance",
        "Without the luminance weight that variance scales, sharp and distant shadows are blurred (PSVGF, "
        "figure 8). Smoothing the variance makes the weight reliable (SVGF, PSVGF figure 5).",
        {"no luminance weight": SVGF + settings("sigma_l=1000"),
         "variance as it is": SVGF + settings("prefilter_variance=off"),
         "smoothed once": SVGF + settings("prefilter_variance=once"),
         "smoothed before every level": SVGF},
        lambda rows: (rows["smoothed before every level"]["flip"] < rows["no luminance weight"]["flip"]
                      and rows["smoothed before every level"]["flip"]
                      < rows["variance as it is"]["flip"]),
        "the weight, with smoothed variance, has the lowest FLIP of all three"),
    Series(
        "Division by albedo",
        "Light that is not divided by albedo loses its textures in the filter (CUDA SVGF).",
        {"divided": ONE_SIGNAL, "not divided": ONE_SIGNAL + settings("demodulate=off")},
        better("divided", "not divided"), "division lowers FLIP"),
    Series(
        "Temporal antialiasing",
        "It follows the filter and makes the picture stable (SVGF, CUDA SVGF).",
        {"none": SVGF + settings("antialias=off"),
         "of linear light": SVGF,
         "of linear light, by splines": SVGF + settings("taa_filter=spline"),
         "as if after the tone curve": SVGF + settings("taa_tonemapped=on")},
        lambda rows: rows["of linear light"]["temporal_error"] < rows["none"]["temporal_error"],
        "it lowers the temporal error", temporal=True),
]


class Measurements:
    def __init__(self, arguments):
        self.arguments = arguments
        last = arguments.frames
        self.measured = f"{last - MEASURED_FRAMES + 1}-{last}"

    def render(self, scene):
        """The noisy frames and the references of a scene, in its folder."""
        folder = self.arguments.work / f"{scene}-{self.arguments.size}"
        if not (folder / "ready").exists():
            run(self.arguments.stillray, "render", f"builtin:{scene}", "-o", folder, "--size",
                self.arguments.size, "--frames", f"1-{self.arguments.frames}", "--preset", "svgf",
                "--sampler", "sobol", "--light-candidates", "1", "--format", "exr", "--save-inputs")
            run(self.arguments.stillray, "render", f"builtin:{scene}", "-o", folder, "--size",
                self.arguments.size, "--frames", self.measured, "--preset", "svgf", "--format", "exr",
                "--reference", self.arguments.reference, "--seed", "1000")
            (folder / "ready").touch()
        return folder

    def measure(self, scene, options):
        """The measures of one row on one scene."""
        folder = self.render(scene)
        tag = "_".join(option for option in options if option not in ("--set", "--preset"))
        report = folder / f"{tag.replace('=', '-').replace(',', '-')}.json"
        if not report.exists():
            clean = folder / "clean"
            run(self.arguments.stillray, "denoise", folder / "noisy.####.exr", "-o", clean / "clean.####.exr",
                "--no-check", "--window", "past", *ANTIALIASED, *options)
            compare(self.arguments.stillray, clean / "clean.####.exr", folder / "reference.####.exr", report,
                    "--frames", self.measured)
        return json.loads(report.read_text())["mean"]


def table(series, rows):
    """\\param rows  name to scene to measures"""
    scenes = [f"`{scene}`" for scene in SCENES]
    titles = scenes + ([f"{scene}, temporal" for scene in scenes] if series.temporal else [])
    lines = ["| | " + " | ".join(titles) + " |", "|---|" + "---|" * len(titles)]
    for name, values in rows.items():
        cells = [f"{values[scene]['psnr']:.2f}, {values[scene]['flip']:.4f}" for scene in SCENES]
        if series.temporal:
            cells += [f"{1e3 * values[scene]['temporal_error']:.1f}" for scene in SCENES]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def section(series, measurements):
    rows = {name: {scene: measurements.measure(scene, options) for scene in SCENES}
            for name, options in series.rows.items()}
    holds = [scene for scene in SCENES
             if series.holds({name: values[scene] for name, values in rows.items()})]
    best = [f"*{title}*: " + ", ".join(f"`{scene}` {choose(rows, key=lambda name: rows[name][scene][key])}"
                                       for scene in SCENES) + "."
            for title, choose, key in (("Highest PSNR", max, "psnr"), ("Lowest FLIP", min, "flip"))]
    where = ("on all scenes" if len(holds) == len(SCENES) else
             "on " + ", ".join(f"`{scene}`" for scene in holds) + " only" if holds else "on none of the scenes")
    return (f"## {series.title}\n\n*Claim*: {series.claim}\n\n{table(series, rows)}\n\n"
            f"*Here*: {series.verdict}: {where}.\n\n" + "\n".join(best) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stillray", default=ROOT / "build/apps/stillray/stillray")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/papers")
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--frames", type=int, default=16, help="length of the sequences; the last two are measured")
    parser.add_argument("--reference", default="512", help="paths per pixel of the references")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/papers.md")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    measurements = Measurements(arguments)
    sections = [section(series, measurements) for series in SERIES]
    made_by = (f"Made by\n\n    scripts/papers.py --size {arguments.size} --frames {arguments.frames} "
               f"--reference {arguments.reference}\n\n{arguments.size}, 1 sample per pixel, the means of frames "
               f"{measurements.measured}.\n")
    intro = (ROOT / "scripts/papers_intro.md").read_text()
    arguments.output.write_text(intro + "\n" + made_by + "\n" + "\n".join(sections))
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, ValueError) as error:
        sys.exit(f"error: {error}")
