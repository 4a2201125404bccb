# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Random mouse, keys and window sizes for a while: no crash, no growth of memory.

    soak.py PROGRAM [SECONDS, default 120] [SEED]
"""
import json
import os
import random
import subprocess
import sys
import tempfile
import time

from display import Display, require

KEYS = ["Tab", "p", "r", "i", "Home", "space", "comma", "period", "F1", "F2", "ctrl+1", "1", "2",
        "w", "s", "q", "e", "Escape"]


def resident_mb(pid):
    with open(f"/proc/{pid}/status", encoding="utf-8") as file:
        for line in file:
            if line.startswith("VmRSS"):
                return int(line.split()[1]) / 1024
    return 0


def event(display, window, rng):
    kind = rng.choice(["key", "drag", "drag", "wheel", "click", "move", "size"])
    place = (rng.randrange(1, 1100), rng.randrange(1, 640))
    if kind == "key":
        display.key(rng.choice(KEYS))
    elif kind == "drag":
        end = (rng.randrange(1, 1100), rng.randrange(1, 640))
        display.do("mousemove", *place, "mousedown", rng.choice([1, 1, 2, 3]), "sleep", "0.05",
                   "mousemove", (place[0] + end[0]) // 2, (place[1] + end[1]) // 2, "sleep", "0.05",
                   "mousemove", *end, "sleep", "0.05", "mouseup", 1, "mouseup", 2, "mouseup", 3)
    elif kind == "wheel":
        display.do("mousemove", *place, "click", "--repeat", "3", rng.choice([4, 5]))
    elif kind == "click":
        display.do("mousemove", *place, "sleep", "0.05", "click", "--repeat",
                   rng.choice([1, 2]), "--delay", "60", 1)
    elif kind == "move":
        display.do("mousemove", *place)
    elif rng.random() < 0.3:
        display.do("windowsize", window, rng.randrange(480, 1200), rng.randrange(320, 700))


def main():
    require("Xvfb", "xdotool")
    program = os.path.abspath(sys.argv[1])
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 120
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else int(time.time())
    print(f"seed {seed}", flush=True)
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder, Display() as display:
        report = os.path.join(folder, "report.json")
        process = subprocess.Popen(
            [program, "view", "builtin:lights", "--size", "1100x640", "--play", "--report", report],
            env=display.environment, cwd=folder)
        display.do("search", "--sync", "--name", "stillray")
        window = subprocess.run(["xdotool", "search", "--name", "stillray"],
                                env=display.environment, capture_output=True, text=True,
                                check=True).stdout.split()[0]
        display.show(window)
        began = time.monotonic()
        early = None
        peak = 0
        events = 0
        while time.monotonic() - began < seconds:
            if process.poll() is not None:
                sys.exit(f"the viewer ended with {process.returncode} after {events} events")
            event(display, window, rng)
            events += 1
            memory = resident_mb(process.pid)
            peak = max(peak, memory)
            # What pools, caches and the largest picture take is there after the first half.
            if early is None and time.monotonic() - began > seconds / 2:
                early = peak
        late = max(resident_mb(process.pid), 0)
        display.do("mousemove", 5, 300)
        for _ in range(4):
            if process.poll() is None:
                display.key("Escape")
                display.key("ctrl+q")
                time.sleep(1)
        code = process.wait(timeout=60)
        times = {}
        if os.path.exists(report):
            with open(report, encoding="utf-8") as file:
                times = json.load(file)
        print(f"{events} events; memory {early:.0f} MB at half time, {late:.0f} MB at the end, "
              f"peak {peak:.0f} MB; {times}")
        if code != 0:
            sys.exit(f"exit code {code}")
        if late > early * 1.15 + 20:
            sys.exit("memory grew")


if __name__ == "__main__":
    main()
