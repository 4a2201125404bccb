# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""A display without a screen (Xvfb), real input events (xdotool), and what is to be seen on it."""
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time

SKIPPED = 77


def require(*programs):
    """Ends the test as skipped, with the reason, where a program is not installed."""
    missing = [name for name in programs if shutil.which(name) is None]
    if missing:
        print("skipped: not installed: " + ", ".join(missing))
        sys.exit(SKIPPED)


class Screen:
    """Pixels of the whole display: rows of blue, green, red and an unused byte."""

    def __init__(self, data):
        header = struct.unpack(">25I", data[:100])
        self.width, self.height, self.stride = header[4], header[5], header[12]
        self.pixels = data[header[0] + header[19] * 12:]

    def row(self, y, x0, x1, channel=1):
        """One channel, 0 blue, 1 green, 2 red, of the pixels x0 to x1 - 1."""
        begin = y * self.stride + channel
        return self.pixels[begin + x0 * 4:begin + x1 * 4:4]

    def values(self, box, step=2, channel=1):
        """A channel of every step-th row of a box (x0, y0, x1, y1), as bytes."""
        x0, y0, x1, y1 = box
        return b"".join(self.row(y, x0, x1, channel) for y in range(y0, y1, step))

    def mean(self, box):
        values = self.values(box)
        return sum(values) / len(values)

    def roughness(self, box):
        """Mean difference of neighbours in a row: noise."""
        x0, y0, x1, y1 = box
        total = count = 0
        for y in range(y0, y1, 2):
            row = self.row(y, x0, x1)
            total += sum(abs(a - b) for a, b in zip(row, row[1:]))
            count += len(row) - 1
        return total / count


def difference(a, b, box, channel=1):
    va, vb = a.values(box, channel=channel), b.values(box, channel=channel)
    return sum(abs(x - y) for x, y in zip(va, vb)) / len(va)


class Display:
    def __init__(self, width=1280, height=720):
        self.folder = tempfile.mkdtemp(prefix="stillray-display-")
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-fbdir",
             self.folder, "-nolisten", "tcp"],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        if not number:
            print("skipped: Xvfb does not start")
            sys.exit(SKIPPED)
        self.environment = dict(os.environ, DISPLAY=":" + number, LIBGL_ALWAYS_SOFTWARE="1")
        until("a display that answers", lambda: subprocess.run(
            ["xdotool", "getdisplaygeometry"], env=self.environment, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL).returncode == 0)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def screen(self):
        with open(os.path.join(self.folder, "Xvfb_screen0"), "rb") as file:
            return Screen(file.read())

    def do(self, *arguments):
        subprocess.run(["xdotool", *map(str, arguments)], env=self.environment, check=True,
                       stdout=subprocess.DEVNULL, timeout=60)

    def show(self, window):
        """To the corner, with the keyboard: without a window manager nobody else gives it that."""
        self.do("windowmove", window, 0, 0)
        # On a busy machine it takes a while until a new window can have it.
        until("a window that takes the keyboard", lambda: subprocess.run(
            ["xdotool", "windowfocus", window], env=self.environment, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL).returncode == 0)

    def key(self, name):
        # As long as a finger: a key that is up again before the window looks was never down.
        self.do("keydown", name, "sleep", "0.12", "keyup", name)
        time.sleep(0.15)

    def drag(self, start, end, button=1, steps=8):
        """One step after the other, as a hand moves: the window sees every place."""
        self.do("mousemove", *start)
        time.sleep(0.15)
        self.do("mousedown", button)
        for i in range(1, steps + 1):
            time.sleep(0.05)
            self.do("mousemove", *(round(a + (b - a) * i / steps) for a, b in zip(start, end)))
        time.sleep(0.15)
        self.do("mouseup", button)
        time.sleep(0.15)


def until(what, condition, seconds=60):
    """Waits for the condition; the test fails if it never holds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return
        time.sleep(0.1)
    raise AssertionError("never seen: " + what)
