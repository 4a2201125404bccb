# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""What the scripts that measure have in common: running programs, stillray compare, and tables."""
import json
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent


def run(*command):
    print("+", *command, flush=True)
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)


def compare(stillray, test, reference, report, *options):
    """The means of all measures of stillray compare, which `report` keeps."""
    run(stillray, "compare", test, reference, "--json", report, *options)
    return json.loads(report.read_text())["mean"]


def value(key, form):
    return lambda values: form.format(values[key]) if values.get(key) is not None else "-"


def specks(values):
    return "{bright_specks:.1f} / {dark_specks:.1f}".format(**values)


def table(rows, measures):
    """\\param rows  (name, values); \\param measures  (title, function from values to text)"""
    lines = ["| | " + " | ".join(title for title, _ in measures) + " |",
             "|---|" + "---|" * len(measures)]
    for name, values in rows:
        lines.append(f"| {name} | " + " | ".join(cell(values) for _, cell in measures) + " |")
    return "\n".join(lines)


def named(texts):
    """NAME=REST of a repeated option as pairs."""
    pairs = [tuple(text.split("=", 1)) for text in texts]
    for text, pair in zip(texts, pairs):
        if len(pair) != 2 or not all(pair):
            raise ValueError(f"'{text}': expected NAME=...")
    return pairs
