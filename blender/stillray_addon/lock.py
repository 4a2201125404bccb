# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""A lock file in the folder of results, so that no two runs write there, without bpy.

The file holds host, process and start time of Blender and of the program that it started. It counts
while one of them runs: the program finishes its work if Blender is closed. Of another host nothing
is known but the age of the file, which a run renews every few seconds.
"""
import json
import os
import socket
import sys
import time

RENEW_SECONDS = 5.0
FOREIGN_SECONDS = 60.0


class Locked(RuntimeError):
    pass


def start_time(pid):
    """Tells a process from a later one of the same number. Empty where the system has no /proc."""
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stream:
            return stream.read().rpartition(")")[2].split()[19]
    except (OSError, IndexError):
        return ""


def _is_zombie(pid):
    try:
        with open(f"/proc/{pid}/stat", encoding="utf-8", errors="replace") as stream:
            return stream.read().rpartition(")")[2].split()[0] == "Z"
    except (OSError, IndexError):
        return False


def is_running(pid, started=""):
    if not isinstance(pid, int) or pid <= 0:
        return False
    if sys.platform == "win32":
        return _is_running_on_windows(pid)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    if _is_zombie(pid):
        return False
    now = start_time(pid)
    return not started or not now or started == now


def _is_running_on_windows(pid):
    import ctypes
    query, still_active = 0x1000, 259
    kernel = ctypes.windll.kernel32
    handle = kernel.OpenProcess(query, False, pid)
    if not handle:
        return False
    code = ctypes.c_ulong()
    known = kernel.GetExitCodeProcess(handle, ctypes.byref(code))
    kernel.CloseHandle(handle)
    return bool(known) and code.value == still_active


def _process(pid):
    return {"pid": pid, "started": start_time(pid)}


class Lock:
    def __init__(self, file, host=None, now=time.time):
        self.file = file
        self._host = host or socket.gethostname()
        self._now = now
        self._record = None
        self._renewed = 0.0

    def holder(self):
        """The record of a run that is under way, or None."""
        try:
            with open(self.file, encoding="utf-8") as stream:
                record = json.load(stream)
            age = self._now() - os.path.getmtime(self.file)
        except FileNotFoundError:
            return None
        except (OSError, ValueError):
            # Being written this moment, or damaged: it counts for as long as a foreign one.
            try:
                age = self._now() - os.path.getmtime(self.file)
            except OSError:
                return None
            return {} if age < FOREIGN_SECONDS else None
        if not isinstance(record, dict):
            return None
        if record.get("host") != self._host:
            return record if age < FOREIGN_SECONDS else None
        processes = [record.get("blender"), record.get("program")]
        alive = any(isinstance(p, dict) and is_running(p.get("pid"), p.get("started", ""))
                    for p in processes)
        return record if alive else None

    def acquire(self):
        """Raises Locked if another run has it. A file that a dead run left is replaced."""
        for _ in range(2):
            try:
                handle = os.open(self.file, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
            except FileExistsError:
                holder = self.holder()
                if holder is not None:
                    raise Locked(self._text(holder))
                self._remove()
                continue
            os.close(handle)
            self._record = {"host": self._host, "blender": _process(os.getpid()), "program": None,
                            "since": self._now()}
            try:
                self._write()
            except OSError:
                self.release()
                raise
            return
        raise Locked(self._text({}))

    def _text(self, holder):
        program = holder.get("program") or {}
        who = f"process {program['pid']} on {holder.get('host')}" if program.get("pid") else \
            f"Blender on {holder.get('host', 'another computer')}"
        return f"These frames are being denoised already, by {who}"

    def set_program(self, pid):
        self._record["program"] = _process(pid) if pid else None
        try:
            self._write()
        except OSError:
            pass  # a full disk: the program itself reports it

    def detach(self):
        """Leaves the lock to the program, which goes on alone."""
        if self._record:
            self._record["blender"] = None
            try:
                self._write()
            except OSError:
                pass
            self._record = None

    def renew(self):
        """To be called often: the file is touched every few seconds."""
        if self._record and self._now() - self._renewed > RENEW_SECONDS:
            try:
                os.utime(self.file)
            except OSError:
                pass
            self._renewed = self._now()

    def release(self):
        if self._record:
            self._record = None
            self._remove()

    def _write(self):
        temporary = f"{self.file}.{os.getpid()}"
        with open(temporary, "w", encoding="utf-8") as stream:
            json.dump(self._record, stream)
        os.replace(temporary, self.file)
        self._renewed = self._now()

    def _remove(self):
        try:
            os.remove(self.file)
        except OSError:
            pass
