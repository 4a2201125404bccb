#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Makes the pictures of docs/denoiser.md, what every stage of the denoiser writes, and docs/inputs.md.

    scripts/stage_pictures.py [--work out/stages] [--only stage_atrous,stage_guides]

Renders built-in scenes, which takes a few minutes. What is finished is kept in the work folder:
remove it to render again. Needs NumPy.
"""
import argparse
import pathlib
import subprocess

import numpy as np

from picture_files import read_exr, read_png, write_png

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZE = "240x135"
FRAME = 40
GAP = 4
# Black over violet, red and orange to pale yellow, as the heat maps of stillray compare.
HEAT = np.array([(0, 0, 4), (66, 10, 104), (147, 38, 103), (221, 81, 58), (252, 165, 10),
                 (252, 255, 164)], float)
AOVS = ("temporal,atrous1,atrous2,atrous3,atrous4,atrous5,aliased,disocclusion,noisy,accumulated,"
        "filtered,variance,filtered_variance,history,limit,ratio,moment_variance")


class Run:
    """Frames of one scene with one set of options."""

    def __init__(self, arguments, name, scene, *options, last=FRAME, first=1, size=SIZE):
        self.folder = arguments.work / name
        self.command = [str(arguments.program), "render", f"builtin:{scene}", "-o",
                        str(self.folder), "--size", size, "--frames", f"{first}-{last}", "--format",
                        "exr,png", "--save-inputs", "--aov", AOVS, *options]
        self.done = False

    def render(self):
        if not self.done and not (self.folder / "render.json").exists():
            print("+", *self.command, flush=True)
            subprocess.run(self.command, check=True, stdout=subprocess.DEVNULL)
        self.done = True

    def png(self, name, frame=FRAME):
        self.render()
        return read_png(self.folder / f"{name}.{frame:04}.png")

    def layer(self, layer, frame=FRAME, file="denoised"):
        """(height, width, channels) as float64; NaN and infinity stay."""
        self.render()
        planes = read_exr(self.folder / f"{file}.{frame:04}.exr")
        letters = [c for c in ("RGB" if f"{layer}.R" in planes else "XYZ") if f"{layer}.{c}" in planes]
        return np.stack([planes[f"{layer}.{c}"].astype(float) for c in letters], axis=2)


def grey(values):
    return np.repeat((np.clip(values[..., :1], 0, 1) * 255 + 0.5).astype(np.uint8), 3, axis=2)


def heat(values, low, high, log=False):
    """One channel in the colours of a heat map, in 24 steps, which keeps the files small."""
    v = values[..., 0]
    if log:
        v, low, high = np.log(np.maximum(v, 1e-30)), np.log(low), np.log(high)
    steps = np.rint(np.clip((v - low) / (high - low), 0, 1) * 24) / 24
    at = steps * (len(HEAT) - 1)
    index = np.minimum(at.astype(int), len(HEAT) - 2)
    part = (at - index)[..., None]
    return (HEAT[index] * (1 - part) + HEAT[index + 1] * part + 0.5).astype(np.uint8)


def light(values, scale=1.0):
    """Scene-linear light, clipped and coded as sRGB."""
    v = np.clip(values * scale, 0, 1)
    coded = np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055)
    return (coded * 255 + 0.5).astype(np.uint8)


def coarse(picture):
    """Four bits per channel: not seen in noise, and half of a file that hardly compresses."""
    return ((picture.astype(int) + 8) // 17 * 17).clip(0, 255).astype(np.uint8)


def directions(motion, longest):
    """Motion vectors: the hue is the direction, the saturation the length."""
    x, y = motion[..., 0], motion[..., 1]
    strength = np.clip(np.hypot(x, y) / longest, 0, 1)[..., None]
    turn = np.arctan2(-y, x)[..., None] + np.array([0, -2, 2]) * np.pi / 3
    return ((1 - strength + strength * (0.5 + 0.5 * np.cos(turn))) * 255).astype(np.uint8)


def numbered(ids):
    """A colour of its own for every id."""
    n = ids[..., :1].astype(np.uint64)
    mixed = (n * np.array([2654435761, 2246822519, 3266489917], np.uint64)) >> np.uint64(13)
    return np.where(n == 0, 0, 64 + mixed % np.uint64(192)).astype(np.uint8)


def enlarge(picture, factor, x, y, width, height):
    part = picture[y:y + height, x:x + width]
    return part.repeat(factor, axis=0).repeat(factor, axis=1)


def montage(panels, columns):
    height, width, _ = panels[0].shape
    rows = (len(panels) + columns - 1) // columns
    sheet = np.full((rows * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3), 255, np.uint8)
    for i, panel in enumerate(panels):
        y, x = i // columns * (height + GAP), i % columns * (width + GAP)
        sheet[y:y + height, x:x + width] = panel
    return sheet


def figures(arguments):
    """Name of each picture, its columns, and how to make its panels."""
    lights = Run(arguments, "lights", "lights")
    fast = Run(arguments, "fast", "lights", "--fps", "6", last=8)
    stays = Run(arguments, "no-limit", "lights", "--fps", "6", "--set", "limit_history=off", last=8)
    edges = Run(arguments, "edges", "cornell", last=16, size="480x270")
    clamp = Run(arguments, "clamp", "lights", "--set", "firefly=clamp", first=FRAME)
    off = Run(arguments, "firefly-off", "lights", first=FRAME)
    presets = [Run(arguments, p, "lights", "--preset", p) for p in ("svgf", "eaw", "temporal")]
    curves = [Run(arguments, c, "lights", "--tonemap", c, "--spp", "64", "--exposure", "1",
                  first=FRAME) for c in ("linear", "reinhard", "filmic", "aces")]

    def noisy(layer):
        return lights.layer(layer, file="noisy")

    def misled(name, *mapping):
        options = [word for layer in mapping for word in ("--aov", layer)]
        picture = denoised(arguments, fast, f"misled-{name}", 8, "--set", "antialias=off", *options)
        return enlarge(picture, 2, 0, 35, 120, 90)

    def crop(picture):
        return enlarge(picture, 3, 100, 20, 80, 60)

    return {
        "stage_input": (3, lambda: [
            coarse(lights.png("noisy")), coarse(light(noisy("direct_diffuse"))),
            coarse(light(noisy("indirect_diffuse"), 3))]),
        "stage_guides": (3, lambda: [
            (noisy("normal") * 127.5 + 127.5).astype(np.uint8),
            grey(1.5 / noisy_depth(lights)), directions(noisy("motion"), 1),
            light(noisy("albedo")), light(noisy("specular_albedo")), numbered(noisy("id"))]),
        "stage_demodulate": (3, lambda: [
            coarse(light(noisy("direct_diffuse"))), light(noisy("albedo")),
            coarse(light(lights.layer("noisy.direct"), 0.4))]),
        "stage_fireflies": (2, lambda: [
            enlarge(coarse(light(run.layer("noisy.indirect"), 0.4)), 4, 20, 30, 80, 45)
            for run in (off, clamp)]),
        "stage_reproject": (3, lambda: [
            fast.png("denoised", 8),
            np.maximum(fast.png("denoised", 8) // 3, (fast.layer("disocclusion", 8) * [255, 160, 0])
                       .astype(np.uint8)),
            heat(fast.layer("history.specular", 8), 0, 8)]),
        "stage_limit_history": (2, lambda: [
            enlarge(picture, 2, 128, 15, 112, 90) for picture in (
                grey(0.5 + 0.5 * np.log2(np.maximum(fast.layer("ratio.direct", 8), 1e-6))),
                heat(fast.layer("limit.direct", 8), 0, 8),
                light(fast.layer("filtered.direct", 8), 0.6),
                light(stays.layer("filtered.direct", 8), 0.6))]),
        "stage_accumulate": (3, lambda: [
            coarse(light(lights.layer("noisy.indirect"), 0.8)),
            coarse(light(lights.layer("accumulated.indirect"), 0.8)),
            heat(lights.layer("history.indirect"), 0, 40)]),
        "stage_merge_future": (2, lambda: [
            enlarge(denoised(arguments, lights, f"window-{window}", 1, "--frames", "1-16",
                             "--window", window), 3, 100, 40, 110, 60)
            for window in ("past", "both")]),
        "stage_variance": (3, lambda: [
            heat(lights.layer("moment_variance.direct"), 1e-4, 10, True),
            heat(lights.layer("variance.direct"), 1e-4, 10, True),
            heat(lights.layer("variance.direct", 2), 1e-4, 10, True)]),
        "stage_atrous": (3, lambda: [
            crop(lights.png(name)) for name in
            ("temporal", "atrous1", "atrous2", "atrous3", "atrous4", "atrous5")]),
        "stage_filtered_variance": (2, lambda: [
            heat(lights.layer(f"{name}.direct"), 1e-6, 1, True)
            for name in ("variance", "filtered_variance")]),
        "stage_remodulate": (3, lambda: [
            light(lights.layer("filtered.direct"), 0.4), light(lights.layer("filtered.indirect"), 0.8),
            light(lights.layer("filtered.specular"), 0.4)]),
        "stage_antialias": (2, lambda: [
            enlarge(edges.png(name, 16), 5, 262, 138, 72, 45) for name in ("aliased", "denoised")]),
        "stage_tonemap": (4, lambda: [
            enlarge(run.png("denoised"), 1, 40, 35, 175, 100) for run in curves]),
        "inputs": (3, lambda: [
            misled("right"), misled("still", "motion=none"),
            misled("albedo", "albedo=none", "specular_albedo=none")]),
        "presets": (4, lambda: [
            enlarge(run.png("denoised"), 1, 40, 15, 175, 120) for run in [lights, *presets]]),
    }


def noisy_depth(run):
    planes = read_exr(run.folder / f"noisy.{FRAME:04}.exr")
    return planes["depth.Z"].astype(float)[..., None]


def denoised(arguments, run, name, frame, *options):
    """A frame of a rendered sequence, read back and denoised with these options, as light."""
    run.render()
    folder = arguments.work / name
    path = folder / f"noisy.{frame:04}.exr"
    if not path.exists():
        command = [str(arguments.program), "denoise", str(run.folder / "noisy.####.exr"), "-o",
                   f"{folder}/", "--window", "past", *options]
        print("+", *command, flush=True)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    planes = read_exr(path)
    return light(np.stack([planes[c].astype(float) for c in "RGB"], axis=2), 0.7)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", type=pathlib.Path,
                        default=ROOT / "build/apps/stillray/stillray")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/stages")
    parser.add_argument("--images", type=pathlib.Path, default=ROOT / "docs/images")
    parser.add_argument("--only", default="", help="names of pictures, with commas")
    arguments = parser.parse_args()
    wanted = [name for name in arguments.only.split(",") if name]
    table = figures(arguments)
    unknown = [name for name in wanted if name not in table]
    if unknown:
        parser.error(f"unknown picture '{unknown[0]}'; pictures are: {', '.join(table)}")
    total = 0
    for name in wanted or table:
        columns, panels = table[name]
        path = arguments.images / f"{name}.png"
        write_png(path, montage(panels(), columns))
        total += path.stat().st_size
        print(f"{path}: {path.stat().st_size // 1024} KB", flush=True)
    print(f"{total // 1024} KB")


if __name__ == "__main__":
    main()
