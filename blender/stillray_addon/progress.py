# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Reads what `stillray` prints while it runs, without bpy."""
import re

_FRAME = re.compile(r"frame (-?\d+) \((\d+) of (\d+)\):")
_LEFT = re.compile(r", ((?:\d+ (?:h|min|s) ?)+) left$")
_RESUME = re.compile(r"resuming with frame (-?\d+)$")
_ERROR = re.compile(r"stillray: error: (.*)")
_MAX_LINES = 40


class Output:
    """Lines of a run, as far as they have come."""

    def __init__(self):
        self.frame = None
        self.done = 0
        self.total = 0
        self.left = ""
        self.errors = []
        self.notes = []
        self.lines = []
        self._rest = b""

    def feed(self, data):
        """Takes bytes; a line may come in several pieces."""
        self._rest += data
        *lines, self._rest = re.split(rb"[\r\n]", self._rest)
        for line in lines:
            self._line(line.decode("utf-8", "replace"))

    def finish(self):
        if self._rest:
            self._line(self._rest.decode("utf-8", "replace"))
            self._rest = b""

    def _line(self, line):
        line = line.strip()
        if not line:
            return
        self.lines = (self.lines + [line])[-_MAX_LINES:]
        frame = _FRAME.match(line)
        if frame:
            self.frame, self.done, self.total = (int(g) for g in frame.groups())
            left = _LEFT.search(line)
            self.left = left[1] if left else ""
        elif _ERROR.match(line):
            self.errors.append(_ERROR.match(line)[1])
        elif line.startswith(("note: ", "warning: ", "check: ")):
            self.notes.append(line)

    @property
    def fraction(self):
        return self.done / self.total if self.total else 0.0

    def error_text(self):
        """What went wrong, in the program's own words."""
        if self.errors:
            return "; ".join(self.errors)
        return self.lines[-1] if self.lines else "it printed nothing"


def duration(seconds):
    """12 s, 3 min 05 s, 2 h 10 min: as the program writes it."""
    whole = round(max(seconds, 0))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
