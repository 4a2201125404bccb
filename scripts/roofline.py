#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Draws how near the wavelet comes to the limits of a machine, from what `stillray bench` measured.

    stillray bench --json bench.json
    scripts/roofline.py bench.json docs/images/roofline.svg

Two limits: how fast memory brings the planes, and how fast the processor multiplies and adds. Each
point is the wavelet of one preset and kernel, by its work per byte. Needs nothing but Python.
"""
import argparse
import json
import math
import pathlib
import sys

TAP_WORK = 15.5          # multiply-adds of one tap for one signal
GUIDE_BYTES = 24         # normal, depth, its slope: read once per level
SIGNAL_BYTES = 32        # light and variance read and written
STOP_BYTES = 4           # read as well where prefilter_variance is a stage of its own
WIDTH, HEIGHT = 760, 440
LEFT, RIGHT, TOP, BOTTOM = 70, 250, 40, 50
COLOURS = {"svgf, one signal": "#1b6ca8", "svgf": "#3aa655", "psvgf": "#c77700", "default": "#a8323e"}


def points(size):
    """(name, kernel, threads, multiply-adds per byte, multiply-adds per second) of every filter."""
    found = []
    for subject in size["filter"]["subjects"]:
        if subject["scalar"] or "atrous1" not in subject["stages"]:
            continue
        taps = 8 if subject["kernel"] == "3x3" else 24
        pixels, levels = size["filter"]["pixels"], subject["levels"]
        work = taps * TAP_WORK * pixels * levels * subject["signals"]
        per_signal = SIGNAL_BYTES + (STOP_BYTES if "prefilter_variance" in subject["stages"] else 0)
        moved = (GUIDE_BYTES + per_signal * subject["signals"]) * pixels * levels
        seconds = subject["wavelet"]["min_ms"] / 1e3
        found.append((subject["name"], subject["kernel"], subject["threads"], work / moved,
                      work / seconds))
    return found


def draw(bench, size):
    threads = bench["threads"]
    peak = size["filter"]["multiply_adds_per_second_and_thread"] * threads
    copy = size["filter"]["copy"]
    bandwidth = copy["bytes_per_pixel"] * size["filter"]["pixels"] / (copy["min_ms"] / 1e3)
    marks = points(size)
    lowest_x, highest_x = 0.5, 16.0
    lowest_y, highest_y = 10 ** math.floor(math.log10(min(m[4] for m in marks))), peak * 2

    def place_x(value):
        share = math.log(value / lowest_x) / math.log(highest_x / lowest_x)
        return LEFT + share * (WIDTH - LEFT - RIGHT)

    def place_y(value):
        share = math.log(value / lowest_y) / math.log(highest_y / lowest_y)
        return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
           f'font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']

    def line(x0, y0, x1, y1, style):
        out.append(f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" {style}/>')

    def text(x, y, words, extra=""):
        out.append(f'<text x="{x:.1f}" y="{y:.1f}" {extra}>{words}</text>')

    thin = 'stroke="#dddddd"'
    for x in (0.5, 1, 2, 4, 8, 16):
        line(place_x(x), TOP, place_x(x), HEIGHT - BOTTOM, thin)
        text(place_x(x), HEIGHT - BOTTOM + 18, f"{x:g}", 'text-anchor="middle"')
    for exponent in range(int(math.log10(lowest_y)), int(math.log10(highest_y)) + 1):
        y = 10.0 ** exponent
        line(LEFT, place_y(y), WIDTH - RIGHT, place_y(y), thin)
        text(LEFT - 8, place_y(y) + 4, f"{y / 1e9:g}", 'text-anchor="end"')
    text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 12, "multiply-adds per byte", 'text-anchor="middle"')
    text(14, TOP - 16, f"thousand million multiply-adds per second, {size['width']}x{size['height']}")

    ridge = peak / bandwidth
    thick = 'stroke="#333333" stroke-width="2" fill="none"'
    line(place_x(lowest_x), place_y(lowest_x * bandwidth), place_x(ridge), place_y(peak), thick)
    line(place_x(ridge), place_y(peak), place_x(highest_x), place_y(peak), thick)
    text(place_x(highest_x) - 4, place_y(peak) - 6, f"arithmetic, {threads} threads",
         'text-anchor="end"')
    text(place_x(lowest_x) + 6, place_y(lowest_x * bandwidth) - 8, "memory")

    for i, (name, kernel, used, x, y) in enumerate(marks):
        colour = COLOURS.get(name, "#555555")
        fill = colour if used == threads else "white"
        row = TOP + 10 + 22 * i
        for at_x, at_y in ((place_x(x), place_y(y)), (WIDTH - RIGHT + 24, row)):
            shape = (f'<circle cx="{at_x:.1f}" cy="{at_y:.1f}" r="5"' if kernel == "3x3" else
                     f'<rect x="{at_x - 5:.1f}" y="{at_y - 5:.1f}" width="10" height="10"')
            out.append(f'{shape} fill="{fill}" stroke="{colour}" stroke-width="1.5"/>')
        text(WIDTH - RIGHT + 38, row + 4, f"{name} {kernel}, {used} thread{'s' if used > 1 else ''}")
    out.append("</svg>")
    return "\n".join(out) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bench", type=pathlib.Path, help="JSON of `stillray bench`")
    parser.add_argument("picture", type=pathlib.Path, help="SVG to write")
    arguments = parser.parse_args()
    try:
        bench = json.loads(arguments.bench.read_text())
        picture = draw(bench, bench["sizes"][0])
    except (OSError, ValueError, KeyError, IndexError) as error:
        sys.exit(f"error: {arguments.bench}: {error!r}, expected what `stillray bench --json` wrote")
    arguments.picture.write_text(picture)


if __name__ == "__main__":
    main()
