#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Stands in for the program `stillray` in tests of the add-on. FAKE_STILLRAY says what it does:
ok, slow, fail, defect, crash, bad_state, or old (of an old version)."""
import json
import os
import signal
import sys
import time

mode = os.environ.get("FAKE_STILLRAY", "ok")
arguments = sys.argv[1:]
if arguments == ["--version"]:
    print("stillray 0.0.9" if mode == "old" else "stillray 0.1.0")
    sys.exit(0)
if arguments == ["denoise", "--help"]:
    print("  -o,--output TEXT\n  --window TEXT" + ("\n  --cameras TEXT" if mode == "ok" else ""))
    sys.exit(0)

output = arguments[arguments.index("-o") + 1]
log = arguments[arguments.index("--json") + 1]
state = os.path.join(output, "resume.stillray")
frames = [1, 2, 3]
stopped = []
signal.signal(signal.SIGINT, lambda *_: stopped.append(True))


def say(text):
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


if mode == "fail":
    say("note: something\nstillray: error: out/f.0001.exr: No space left on device")
    sys.exit(2)
if mode == "defect":
    say("stillray: error: check failed")
    sys.exit(1)
if mode == "crash":
    os.kill(os.getpid(), signal.SIGKILL)
if mode == "bad_state" and "--resume" in arguments:
    say("stillray: error: cannot resume resume.stillray: it is damaged")
    sys.exit(2)
done = 0
if "--resume" in arguments and os.path.exists(state):
    with open(state, encoding="utf-8") as stream:
        done = int(stream.read())
    say(f"resuming with frame {frames[done]}")
for i in range(done, len(frames)):
    # The first frame comes soon; the others take long enough to be stopped on a busy machine.
    for _ in range(1000 if mode == "slow" and i > 0 else 1):
        if stopped:
            with open(state, "w", encoding="utf-8") as stream:
                stream.write(str(i))
            say(f"stillray: stopped; {i} of {len(frames)} frames are finished")
            sys.exit(130)
        time.sleep(0.01)
    with open(os.path.join(output, f"f.{frames[i]:04d}.exr"), "w", encoding="utf-8") as stream:
        stream.write("frame")
    say(f"frame {frames[i]} ({i + 1} of {len(frames)}): read 1 ms, denoise 2 ms, write 3 ms, "
        "5 s left")
if os.path.exists(state):
    os.remove(state)
with open(log, "w", encoding="utf-8") as stream:
    json.dump({"arguments": arguments, "findings": [
        {"name": "fixed_seed", "what": "w", "cure": "c", "frames": [1, 2]}]}, stream)
