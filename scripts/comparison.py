#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Compares the presets with other filters and writes docs/comparison.md.

    scripts/comparison.py [--scenes lights,cornell,mirrors] [--spp 1,4,16,64] [--size 384x216]
                          [--sequence NAME=PATTERN,REFERENCE ...] [--learned NAME=COMMAND ...]

Scenes and references are rendered first, which takes most of the time: about half an hour on two cores.
What is finished is kept in the work folder: remove it to render again. Results of a preset are made
again if the program is newer. A video of each sequence is written beside them. Needs NumPy; OpenCV's
filters are left out without python3-opencv, the videos without ffmpeg.

--learned NAME=COMMAND adds any other filter, as scripts/comparison_intro.md describes.
"""
import argparse
import json
import pathlib
import shlex
import shutil
import subprocess
import sys

import numpy as np

import frame_filters  # this and the next two are beside this file
import picture_files
from measured import ROOT, compare, named, run, specks, table, value

NOISY = "noisy"
# Row, folder, options of stillray denoise.
PRESETS = [
    ("plain accumulation", "temporal", ["--preset", "temporal", "--window", "past"]),
    ("`svgf`", "svgf", ["--preset", "svgf", "--window", "past"]),
    ("`default` (past)", "default-past", ["--preset", "default", "--window", "past"]),
    ("`default` (both)", "default-both", ["--preset", "default", "--window", "both"]),
    ("`best` (past)", "best-past", ["--preset", "best", "--window", "past"]),
    ("`best` (both)", "best-both", ["--preset", "best", "--window", "both"]),
]
# Those that stillray recommends, against which all others are set.
OWN = [row for row, _, _ in PRESETS if row.startswith(("`default`", "`best`"))]
OPENCV = [("joint bilateral (OpenCV)", "bilateral"), ("non-local means (OpenCV)", "nlm")]
# Title, cell, and a number that is the lower the better.
MEASURES = [
    ("PSNR, dB", value("psnr", "{:.2f}"), lambda v: -v["psnr"]),
    ("FLIP", value("flip", "{:.4f}"), lambda v: v["flip"]),
    ("SSIM", value("ssim", "{:.4f}"), lambda v: -v["ssim"]),
    ("relMSE", value("rel_mse", "{:.5f}"), lambda v: v["rel_mse"]),
    ("specks", specks, lambda v: v["bright_specks"] + v["dark_specks"]),
    ("flicker", value("temporal_error", "{:.5f}"), lambda v: v["temporal_error"]),
    ("brightness", value("brightness", "{:.4f}"), lambda v: abs(v["brightness"] - 1)),
]
COSTS = [
    ("ms", value("ms", "{:.0f}"), lambda v: v["ms"]),
    ("MB", value("mb", "{:.0f}"), lambda v: v["mb"]),
]
CROP = (120, 80)  # of the pictures in the documentation, pixels
CROPS_PER_LINE = 4
MARGIN = 4
KEPT_BITS = 0xf8  # pictures of noise hardly shrink with all eight
VIDEO_ROWS = [NOISY, "`svgf`", "`default` (past)", "`best` (both)"]


# ---- words made from the numbers

def score(measure, values):
    """The lower the better, or None if the row has no such number."""
    try:
        return measure[2](values)
    except (KeyError, TypeError):
        return None


def ranked(rows, measure):
    """(score, row, text) from the best row to the worst, without the input."""
    found = [(score(measure, values), name, measure[1](values)) for name, values in rows
             if name != NOISY]
    return sorted((entry for entry in found if entry[0] is not None), key=lambda entry: entry[0])


def listed(words):
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def title_of(measure):
    return measure[0].split(",")[0]


def best_of_each(rows):
    """A sentence: which row is the best in each measure, as far as the table's digits show it."""
    found = {}
    for measure in MEASURES + COSTS:
        order = ranked(rows, measure)
        if order:
            names = [name for _, name, text in order if text == order[0][2]]
            words = listed(names) if len(names) <= 2 else f"{names[0]} and {len(names) - 1} others"
            found.setdefault(words, []).append(f"{title_of(measure)} ({order[0][2]})")
    return "Best: " + "; ".join(f"{words} in {listed(titles)}" for words, titles in found.items()) + "."


def where_others_lead(rows):
    """A sentence: in which measures of quality another row is better than all of `default` and `best`."""
    leads = {}
    for measure in MEASURES:
        order = ranked(rows, measure)
        own = [entry for entry in order if entry[1] in OWN]
        if not own:
            continue
        for points, name, text in order:
            if name in OWN or points >= own[0][0] or text == own[0][2]:
                continue
            leads.setdefault(name, []).append(f"{title_of(measure)} ({text}, not {own[0][2]})")
    if not leads:
        return "No other filter is better than the better of `default` and `best` in any measure of quality."
    return "Better than all of `default` and `best`: " + "; ".join(
        f"{name} in {listed(texts)}" for name, texts in leads.items()) + "."


def tally(sections):
    """A table: in how many tables each row is the best, for each measure.

    \\param sections  lists of rows
    """
    names = list(dict.fromkeys(name for rows in sections for name, _ in rows if name != NOISY))
    firsts = {name: {} for name in names}
    for rows in sections:
        for measure in MEASURES:
            order = ranked(rows, measure)
            for _, name, _ in [entry for entry in order if entry[0] == order[0][0]]:
                firsts[name][measure[0]] = firsts[name].get(measure[0], 0) + 1
    columns = [(title_of(m), lambda v, key=m[0]: str(v.get(key, 0) or "-")) for m in MEASURES]
    return table([(name, firsts[name]) for name in names], columns)


def means(sections):
    """Rows with the plain means of all measures over several tables that have the same rows."""
    rows = []
    for name, first in sections[0]:
        others = [dict(rows_of)[name] for rows_of in sections]
        rows.append((name, {key: sum(v[key] for v in others) / len(others) for key, number in
                            first.items() if number is not None and all(
                                v.get(key) is not None for v in others)}))
    return rows


def overview(by_samples, key, form):
    """A table of one measure: a column for each number of samples per pixel.

    \\param by_samples  samples per pixel to rows
    """
    names = [name for name, _ in next(iter(by_samples.values()))]
    columns = [(f"{spp} spp", lambda v, spp=spp: value(key, form)(v[spp])) for spp in by_samples]
    rows = [(name, {spp: dict(rows)[name] for spp, rows in by_samples.items()}) for name in names]
    return table(rows, columns)


def leaders(by_samples, measure):
    """A sentence: the best row for each number of samples, and the best one of the others."""
    own, others = {}, {}
    for spp, rows in by_samples.items():
        order = ranked(rows, measure)
        for found, kept in ((own, [e for e in order if e[1] in OWN]),
                            (others, [e for e in order if e[1] not in OWN])):
            if kept:
                found.setdefault(kept[0][1], []).append((spp, kept[0]))

    def words(found):
        return "; ".join(f"{name} at " + listed([f"{spp} spp ({entry[2]})" for spp, entry in places])
                         for name, places in found.items())

    better = [f"{spp} spp" for spp, rows in by_samples.items()
              if (order := ranked(rows, measure)) and order[0][1] not in OWN]
    verdict = f"another filter is better at {listed(better)}" if better else "none of them is better"
    return (f"Best of `default` and `best`: {words(own)}. Best of the others: {words(others)}: "
            f"{verdict}.")


# ---- what is filtered

class Sequence:
    """Noisy frames and references, in a folder for all that is made of them."""

    def __init__(self, title, folder, frames, judged, noisy, reference, spp):
        self.title = title
        self.folder = folder
        self.frames = frames
        self.judged = judged  # frames that have a reference
        self.noisy = noisy  # as stillray denoise gets them
        self.reference = reference
        self.spp = spp
        self.inputs = folder  # of noisy.####.exr, as other filters get them
        self.rendered_here = True
        self.pictures = {}  # row to pattern

    def exr(self, row, frame):
        return pathlib.Path(str(self.pictures[row]).replace("####", f"{frame:04d}"))


def parse_frames(text):
    """8,15-16 as a list."""
    frames = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        if not first.isdigit() or not (last or first).isdigit():
            raise ValueError(f"frames '{text}': expected a list such as 8,15-16")
        frames += range(int(first), int(last or first) + 1)
    return frames


def render(arguments, scene, folder, frames, spp, *options):
    """Frames of a built-in scene; those that are finished stay."""
    run(arguments.stillray, "render", f"builtin:{scene}", "-o", folder, "--size", arguments.size,
        "--frames", frames, "--spp", spp, "--preset", "temporal", "--no-jitter", "--format", "exr",
        "--threads", arguments.threads, "--resume", *options)


def render_sequence(arguments, scene, spp):
    judged = parse_frames(arguments.judged)
    reference = arguments.work / f"{scene}-reference"
    render(arguments, scene, reference, f"{judged[0]}-{judged[-1]}", 1, "--reference",
           arguments.reference, "--reference-frames", arguments.judged, "--seed", 1000)
    folder = arguments.work / f"{scene}-{spp}"
    render(arguments, scene, folder, f"1-{arguments.frames}", spp, "--save-inputs")
    return Sequence(f"{scene}, {spp} spp", folder, list(range(1, arguments.frames + 1)), judged,
                    folder / "noisy.####.exr", reference / "reference.####.exr", spp)


def tuning_frames(arguments, spp):
    """(planes, reference) of the scene that filters are tuned on."""
    scene, frames = arguments.tune_scene, (8, 16)
    folder, reference = (arguments.work / f"{scene}-{part}" for part in (spp, "reference"))
    for frame in frames:
        render(arguments, scene, folder, f"{frame}-{frame}", spp, "--save-inputs")
        render(arguments, scene, reference, f"{frame}-{frame}", 1, "--reference",
               arguments.reference, "--reference-frames", ",".join(map(str, frames)), "--seed", 1000)
    return [(picture_files.read_exr(folder / f"noisy.{frame:04d}.exr"), picture_files.layer(
        picture_files.read_exr(reference / f"reference.{frame:04d}.exr"), "")) for frame in frames]


def tuned(arguments, name, spp, cv):
    """The settings of a filter of OpenCV with the highest PSNR on the scene for tuning."""
    path = arguments.work / f"{name}-{spp}.json"
    if not path.exists():
        print(f"+ tuning {name}, {spp} spp", flush=True)
        path.write_text(json.dumps(frame_filters.tune_filter(name, tuning_frames(arguments, spp), cv)))
    return json.loads(path.read_text())


def in_standard_layers(planes, colour, sources):
    """Planes of another renderer's frame under stillray's names.

    \\param planes  channel name to plane
    \\param colour  planes R, G and B of the whole picture
    \\param sources  the roles of layers that stillray denoise --json lists
    """
    out = {letter: colour[letter].astype(np.float32) for letter in "RGB"}
    letters = {"albedo": "RGB", "specular_albedo": "RGB", "emission": "RGB", "background": "RGB",
               "normal": "XYZ", "depth": "Z"}
    for source in sources:
        for letter, channel in zip(letters.get(source["aov"], ""), source["channels"]):
            out[f"{source['aov']}.{letter}"] = planes[channel].astype(np.float32)
    return out


def read_colour(path):
    """R, G and B of a file that stillray has written, in whatever layer they are."""
    planes = picture_files.read_exr(path)
    for prefix in ["", *sorted({name[:-1] for name in planes if name.endswith("Combined.R")})]:
        if all(prefix + letter in planes for letter in "RGB"):
            return {letter: planes[prefix + letter] for letter in "RGB"}
    raise ValueError(f"{path}: expected channels R, G and B or a layer Combined")


def samples_of(name):
    """(title, samples per pixel) of a foreign sequence: "Fur" has 1, "Fur:16" has 16."""
    title, colon, count = name.partition(":")
    if colon and not (count.isdigit() and int(count) > 0):
        raise ValueError(f"--sequence {name}: expected NAME or NAME:SPP, such as Fur:16")
    return (f"{title}, {count} spp", int(count)) if colon else (title, 1)


def foreign_sequence(arguments, name, text):
    """Frames of another renderer: PATTERN,REFERENCE with #### for the number of the frame."""
    title, spp = samples_of(name)
    pattern, _, reference = text.partition(",")
    if "####" not in pattern or "####" not in reference:
        raise ValueError(f"'{name}={text}': expected NAME=PATTERN,REFERENCE with #### in both")
    head, tail = pathlib.Path(reference).name.split("####")
    judged = sorted(int(path.name[len(head):len(path.name) - len(tail)])
                    for path in pathlib.Path(reference).parent.glob(f"{head}[0-9][0-9][0-9][0-9]{tail}"))
    if not judged:
        raise ValueError(f"{reference}: no such frame")
    folder = arguments.work / "".join(c if c.isalnum() else "_" for c in name)
    inputs = folder / "inputs"
    inputs.mkdir(parents=True, exist_ok=True)
    log_path = folder / "sum.json"
    if not log_path.exists():
        # Without time and without a wavelet the frames come out as they are, summed.
        run(arguments.stillray, "denoise", pattern, "-o", folder / "sum", "--preset", "temporal",
            "--set", "temporal=off", "--window", "past", "--no-check", "--json", log_path)
    log = json.loads(log_path.read_text())
    for entry in log["frames"]:
        target = inputs / f"noisy.{entry['frame']:04d}.exr"
        if not target.exists():
            picture_files.write_exr(target, in_standard_layers(
                picture_files.read_exr(pathlib.Path(entry["input"])),
                read_colour(pathlib.Path(entry["output"])), log["aovs"]["sources"]))
    sequence = Sequence(title, folder, [entry["frame"] for entry in log["frames"]], judged, pattern,
                        reference, spp)
    sequence.inputs = inputs
    sequence.rendered_here = False
    return sequence


# ---- filters

def run_measured(report, *command):
    """Output of a command; processor time and peak memory are in the file `report`."""
    print("+", *command, flush=True)
    done = subprocess.run([sys.executable, "-S", "-E", ROOT / "scripts/measured_run.py", report,
                           *(str(part) for part in command)], check=True, stdout=subprocess.PIPE,
                          text=True)
    return done.stdout


def denoise_ms(log, cpu_s):
    """Processor time per frame of the filter alone: the share of the whole, which also reads and
    writes files, that the log gives it.
    """
    frames = log["frames"]
    filtering = sum(frame["future_ms"] + frame["denoise_ms"] for frame in frames)
    files = sum(frame["read_ms"] + frame["write_ms"] for frame in frames)
    return 1000 * cpu_s * filtering / (filtering + files) / len(frames)


def command_ms(output, cpu_s, frames):
    """Processor time per frame: what the command says in its last line, else that of its process."""
    lines = output.strip().splitlines()
    try:
        return float(json.loads(lines[-1])["ms_per_frame"])
    except (IndexError, ValueError, KeyError, TypeError):
        return 1000 * cpu_s / frames


def with_costs(sequence, folder, pattern, ms_of, stillray):
    """The measures of finished frames, with time and memory of the process that made them."""
    usage = json.loads((folder / "usage.json").read_text())
    values = compare(stillray, pattern, sequence.reference, folder / "compare.json")
    values.update(ms=ms_of(usage["cpu_s"]), mb=usage["peak_bytes"] / 1e6)
    (folder / "values.json").write_text(json.dumps(values))
    return values


def run_preset(arguments, sequence, suffix, options):
    folder = sequence.folder / "rows" / suffix
    pattern = folder / "denoised.####.exr"
    kept = folder / "values.json"
    program = pathlib.Path(arguments.stillray)
    if kept.exists() and kept.stat().st_mtime > program.stat().st_mtime:
        return json.loads(kept.read_text()), pattern
    folder.mkdir(parents=True, exist_ok=True)
    run_measured(folder / "usage.json", arguments.stillray, "denoise", sequence.noisy, "-o", pattern,
                 "--no-check", "--threads", 1, "--json", folder / "log.json", *options)
    log = json.loads((folder / "log.json").read_text())
    return with_costs(sequence, folder, pattern, lambda cpu_s: denoise_ms(log, cpu_s),
                      arguments.stillray), pattern


def run_command(arguments, sequence, suffix, command):
    """A filter outside of stillray: COMMAND INPUT OUTPUT FRAMES."""
    folder = sequence.folder / "rows" / suffix
    raw, pattern = folder / "raw", folder / "denoised.####.exr"
    kept, used = folder / "values.json", folder / "command.json"
    text = json.dumps([str(part) for part in command])
    if not kept.exists() or not used.exists() or used.read_text() != text:
        raw.mkdir(parents=True, exist_ok=True)
        frames = ",".join(map(str, sequence.judged))
        output = run_measured(folder / "usage.json", *command, sequence.inputs, raw, frames)
        for frame in sequence.judged:
            # Flicker is measured along the motion that the test frames hold.
            noisy = picture_files.read_exr(sequence.inputs / f"noisy.{frame:04d}.exr")
            planes = {n: noisy[n] for n in ("motion.X", "motion.Y", "depth.Z") if n in noisy}
            denoised = picture_files.read_exr(raw / f"denoised.{frame:04d}.exr")
            for letter in "RGB":
                planes[letter] = denoised[letter].astype(np.float32)
            picture_files.write_exr(folder / f"denoised.{frame:04d}.exr", planes)
        with_costs(sequence, folder, pattern,
                   lambda cpu_s: command_ms(output, cpu_s, len(sequence.judged)), arguments.stillray)
        used.write_text(text)
    return json.loads(kept.read_text()), pattern


def measure_sequence(arguments, sequence, settings):
    """Rows of the table, (name, values); sets the pictures of the sequence."""
    pattern = sequence.inputs / "noisy.####.exr"
    sequence.pictures[NOISY] = pattern
    report = sequence.folder / "noisy.json"
    rows = [(NOISY, compare(arguments.stillray, pattern, sequence.reference, report))]

    def add(row, result):
        values, sequence.pictures[row] = result
        rows.append((row, values))

    for row, suffix, options in PRESETS:
        add(row, run_preset(arguments, sequence, suffix, options))
    for row, name in OPENCV:
        if name in settings:
            command = [sys.executable, ROOT / "scripts/frame_filters.py", name,
                       json.dumps(settings[name][sequence.spp])]
            add(row, run_command(arguments, sequence, name, command))
    for row, command in named(arguments.learned):
        add(row, run_command(arguments, sequence, "".join(c if c.isalnum() else "_" for c in row),
                             shlex.split(command)))
    sequence.pictures["reference"] = sequence.reference
    return rows


# ---- pictures

def display(path):
    """x / (1 + x) as sRGB, (height, width, 3) uint8."""
    planes = read_colour(path)
    x = np.maximum(np.stack([planes[c].astype(np.float32) for c in "RGB"], axis=2), 0)
    x = x / (1 + x)
    coded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
    return (coded * 255 + 0.5).astype(np.uint8)


def place_of_crop(pictures, width, height):
    """Left and top of the window in which the pictures differ most, on a grid of eight pixels."""
    spread = np.std(np.stack(pictures).astype(np.float32), axis=0).sum(axis=2)
    total = np.pad(spread.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    best = max(((total[y + height, x + width] - total[y, x + width] - total[y + height, x] +
                 total[y, x], x, y)
                for y in range(0, spread.shape[0] - height + 1, 8)
                for x in range(0, spread.shape[1] - width + 1, 8)), key=lambda entry: entry[0])
    return best[1], best[2]


def contact_sheet(sequence, path):
    """Crops of the last judged frame, in the order of the rows, and of the reference. Their caption."""
    frame = sequence.judged[-1]
    pictures = {row: display(sequence.exr(row, frame)) for row in sequence.pictures}
    full = next(iter(pictures.values()))
    width, height = min(CROP[0], full.shape[1]), min(CROP[1], full.shape[0])
    shown = {row for row, _, _ in PRESETS[1:]} | {"reference"}  # noise would outweigh all else
    left, top = place_of_crop([p for row, p in pictures.items() if row in shown], width, height)
    lines = (len(pictures) + CROPS_PER_LINE - 1) // CROPS_PER_LINE
    sheet = np.full((lines * (height + MARGIN) - MARGIN,
                     CROPS_PER_LINE * (width + MARGIN) - MARGIN, 3), 255, np.uint8)
    for i, picture in enumerate(pictures.values()):
        y, x = i // CROPS_PER_LINE * (height + MARGIN), i % CROPS_PER_LINE * (width + MARGIN)
        sheet[y:y + height, x:x + width] = picture[top:top + height, left:left + width] & KEPT_BITS
    picture_files.write_png(path, sheet)
    names = list(pictures)
    parts = ["; ".join(names[i:i + CROPS_PER_LINE]) for i in range(0, len(names), CROPS_PER_LINE)]
    return (f"*Frame {frame}, {sequence.title}, where presets and reference differ most. "
            + ". ".join(f"Line {i}: {part}" for i, part in enumerate(parts, 1)) + ".*")


def video(sequence):
    """Some rows side by side, as comparison.mp4 in the folder of the sequence."""
    if shutil.which("ffmpeg") is None:
        print("note: no video, since ffmpeg is not installed")
        return
    folder = sequence.folder / "video"
    folder.mkdir(exist_ok=True)
    for i, frame in enumerate(sequence.frames):
        parts = [display(sequence.exr(row, frame)) for row in VIDEO_ROWS]
        wide = np.concatenate(parts, axis=1)
        picture_files.write_png(folder / f"{i:04d}.png",
                                wide[:wide.shape[0] // 2 * 2, :wide.shape[1] // 2 * 2])
    run("ffmpeg", "-y", "-loglevel", "error", "-framerate", 12, "-i", folder / "%04d.png", "-c:v",
        "libx264", "-pix_fmt", "yuv420p", "-crf", 16, sequence.folder / "comparison.mp4")


# ---- the page

def settings_text(settings):
    """What the filters of OpenCV were tuned to."""
    if not settings:
        return ("OpenCV's filters are left out: python3-opencv was not installed where this page was "
                "made.\n")
    lines = []
    for row, name in OPENCV:
        if name in settings:
            samples = list(settings[name])
            columns = [(key, value(key, "{}")) for key in settings[name][samples[0]]]
            lines.append(f"{row}:\n\n" + table(
                [(f"{spp} spp", settings[name][spp]) for spp in samples], columns) + "\n")
    return "\n".join(lines)


def section(sequence, rows, image_line=""):
    no_flicker = all(v.get("temporal_error") is None for _, v in rows)
    remark = ("\nFlicker is not measured: it needs references of consecutive frames.\n"
              if no_flicker else "")
    return (f"### {sequence.title}\n\n{image_line}{table(rows, [m[:2] for m in MEASURES + COSTS])}\n\n"
            f"{best_of_each(rows)} {where_others_lead(rows)}\n{remark}")


def made_by(arguments):
    words = ["scripts/comparison.py", "--scenes", arguments.scenes, "--spp", arguments.spp,
             "--size", arguments.size, "--frames", arguments.frames, "--judged", arguments.judged,
             "--reference", arguments.reference]
    for text in arguments.also:
        words += ["--also", text]
    for name, text in named(arguments.sequence):
        files = ",".join(pathlib.Path(part).name for part in text.split(","))
        words += ["--sequence", f"{name}={files}"]
    for name, _ in named(arguments.learned):
        words += ["--learned", f"{name}=COMMAND"]
    lines, line = [], ""
    for word in (shlex.quote(str(w)) for w in words):
        if len(line) + len(word) > 90:
            lines.append(line + "\\")
            line = "    "
        line += word + " "
    return "\n".join("    " + text for text in [*lines, line.rstrip()])


def machine_of(measured):
    """As the program names it."""
    folder = measured[0][0].folder / "rows" / PRESETS[0][1]
    return json.loads((folder / "log.json").read_text())["machine"]


def later_frames(arguments):
    """What to keep in mind of `--window both` where the judged frames are the last ones."""
    left = arguments.frames - parse_frames(arguments.judged)[-1]
    return "" if left >= 8 else (f"After the last of them there are {left} frames, so rows with (both) "
                                 "have few later frames to gain from. ")


def page(arguments, settings, measured):
    """\\param measured  (sequence, rows, line with its picture)"""
    by_samples = {}
    for sequence, rows, _ in measured:
        if sequence.rendered_here:
            by_samples.setdefault(sequence.spp, []).append(rows)
    scenes = arguments.scenes.split(",")
    by_samples = {spp: means(sections) for spp, sections in by_samples.items()
                  if len(sections) >= len(scenes)}
    parts = [(ROOT / "scripts/comparison_intro.md").read_text(), "## Settings of this page\n",
             f"Made by\n\n{made_by(arguments)}\n",
             f"{arguments.size} pixels, {arguments.frames} frames; frames {arguments.judged} are judged "
             f"against references of {arguments.reference} samples per pixel. {later_frames(arguments)}"
             f"Times are of {machine_of(measured)}.\n", *(f"{text}\n" for text in arguments.remark),
             f"Settings of OpenCV's filters with the highest PSNR on `{arguments.tune_scene}`, frames 8 "
             f"and 16, for each number of samples:\n" if settings else "", settings_text(settings)]
    if by_samples:
        parts.append(f"## Means over {listed([f'`{scene}`' for scene in scenes])}\n")
        for title, key, words in [("PSNR, dB", "psnr", "PSNR in dB, higher is better:"),
                                  ("FLIP", "flip", "FLIP, lower is better:"),
                                  ("flicker", "temporal_error", "Flicker, lower is better:")]:
            measure = next(m for m in MEASURES if m[0] == title)
            form = {"psnr": "{:.2f}", "flip": "{:.4f}", "temporal_error": "{:.5f}"}[key]
            parts += [words + "\n", overview(by_samples, key, form) + "\n",
                      leaders(by_samples, measure) + "\n"]
    parts += ["## How often each is the best\n", f"Of {len(measured)} tables, those in which a row is "
              "the best in a measure:\n", tally([rows for _, rows, _ in measured]) + "\n",
              "## All measures\n"]
    return "\n".join(part for part in parts + [section(*entry) for entry in measured] if part)


def parse():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stillray", default=ROOT / "build/apps/stillray/stillray")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "out/comparison")
    parser.add_argument("--scenes", default="lights,cornell,mirrors", help="built-in scenes")
    parser.add_argument("--spp", default="1,4,16,64", help="samples per pixel, a list")
    parser.add_argument("--also", action="append", default=[], metavar="SCENE:SPP",
                        help="one more sequence, such as cornell:64")
    parser.add_argument("--size", default="384x216")
    parser.add_argument("--frames", default=24, type=int, help="of each sequence")
    parser.add_argument("--judged", default="8,15-16",
                        help="frames that are measured; flicker needs consecutive ones")
    parser.add_argument("--reference", default=512, type=int, help="their samples per pixel")
    parser.add_argument("--tune-scene", default="spheres",
                        help="built-in scene that OpenCV's filters are tuned on")
    parser.add_argument("--sequence", action="append", default=[],
                        metavar="NAME[:SPP]=PATTERN,REFERENCE",
                        help="EXR frames of another renderer at SPP samples per pixel (default: 1), "
                        "and their references, both with #### for the number of the frame")
    parser.add_argument("--learned", action="append", default=[], metavar="NAME=COMMAND",
                        help="a filter to compare with: COMMAND INPUT OUTPUT FRAMES denoises")
    parser.add_argument("--remark", action="append", default=[], metavar="TEXT",
                        help="a paragraph for the page, such as how --learned was run")
    parser.add_argument("--threads", default=1, type=int,
                        help="of rendering; filters always run on one")
    parser.add_argument("--images", type=pathlib.Path, default=ROOT / "docs/images")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs/comparison.md")
    arguments = parser.parse_args()
    if arguments.tune_scene in arguments.scenes.split(","):
        parser.error(f"--tune-scene {arguments.tune_scene}: expected a scene that is not in --scenes")
    if shutil.which(arguments.stillray) is None:
        parser.error(f"--stillray {arguments.stillray}: expected the program stillray")
    try:
        for name, _ in named(arguments.sequence):
            samples_of(name)
        named(arguments.learned)
        for text in arguments.also:
            if not text.partition(":")[2].isdigit():
                raise ValueError(f"--also {text}: expected SCENE:SPP, such as cornell:64")
        last = parse_frames(arguments.judged)[-1]
        if last > arguments.frames:
            raise ValueError(f"--judged {arguments.judged}: expected frames up to {arguments.frames}")
    except ValueError as error:
        parser.error(str(error))
    return arguments


def main():
    arguments = parse()
    arguments.work.mkdir(parents=True, exist_ok=True)
    arguments.images.mkdir(parents=True, exist_ok=True)
    samples = [int(text) for text in arguments.spp.split(",")]
    cv = frame_filters.opencv()
    if cv is None:
        print("note: OpenCV's filters are left out: python3-opencv is not installed")
    pairs = [(scene, spp) for scene in arguments.scenes.split(",") for spp in samples]
    pairs += [(scene, int(spp)) for scene, _, spp in (text.partition(":") for text in arguments.also)]
    needed = sorted({*(spp for _, spp in pairs),
                     *(samples_of(name)[1] for name, _ in named(arguments.sequence))})
    settings = {name: {spp: tuned(arguments, name, spp, cv) for spp in needed}
                for _, name in OPENCV} if cv else {}
    sequences = [render_sequence(arguments, scene, spp) for scene, spp in pairs]
    sequences += [foreign_sequence(arguments, *entry) for entry in named(arguments.sequence)]
    measured = []
    for sequence in sequences:
        rows = measure_sequence(arguments, sequence, settings)
        line = ""
        if sequence.spp == samples[0] or not sequence.rendered_here:
            stem = "".join(c if c.isalnum() else "_" for c in sequence.folder.name.lower())
            image = arguments.images / f"comparison_{stem}.png"
            caption = contact_sheet(sequence, image)
            line = f"![Crops of {sequence.title}](images/{image.name})\n\n{caption}\n\n"
            video(sequence)
        measured.append((sequence, rows, line))
    arguments.output.write_text(page(arguments, settings, measured).rstrip() + "\n")
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, ValueError, OSError) as error:
        sys.exit(f"error: {error}")
