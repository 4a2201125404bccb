# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Runs a command and writes the processor time and the peak memory of it and its children.

    measured_run.py REPORT.json COMMAND...

A process of its own, because Linux counts the memory of the process that starts a program towards
that program's peak: this one is small.
"""
import json
import os
import sys


def main():
    report, command = sys.argv[1], sys.argv[2:]
    process = os.fork()
    if process == 0:
        try:
            os.execvp(command[0], command)
        except OSError as error:
            print(f"error: {command[0]}: {error.strerror}", file=sys.stderr)
            os._exit(127)
    _, status, usage = os.wait4(process, 0)
    with open(report, "w", encoding="utf-8") as file:
        json.dump({"cpu_s": usage.ru_utime + usage.ru_stime, "peak_bytes": usage.ru_maxrss * 1024}, file)
    sys.exit(os.waitstatus_to_exitcode(status) if os.WIFEXITED(status) else 1)


if __name__ == "__main__":
    main()
