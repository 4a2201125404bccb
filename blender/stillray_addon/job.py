# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""A run of `stillray` over frames: its stages, process, state on disk and end, without bpy.

One stage denoises one view layer; the next one reads its files. The output of the program goes to a
file and not to a pipe: if Blender is closed in mid-run, the program finishes its work, and the next
run finds out from the state how far it came.
"""
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time

from . import command, exr_header, lock, paths, progress

WORK = ".stillray"  # folder in the folder of results, for all that is not a result
_GRACE_SECONDS = 15.0
_POLL_SECONDS = 0.05


class JobError(RuntimeError):
    pass


class Stage:
    def __init__(self, label, folder, arguments, output, json_file, names, frames):
        self.label = label
        self.folder = folder  # in which the program runs
        self.arguments = arguments
        self.output = output
        self.json_file = json_file  # written when the program has finished everything
        self.names = names  # of the output; None for a check
        self.frames = frames

    @property
    def is_finished(self):
        """The program writes the log last, after all frames."""
        return os.path.isfile(self.json_file) and (
            self.names is None or all(os.path.isfile(self.names.file(f)) for f in self.frames))

    @property
    def can_resume(self):
        try:
            return any(name.startswith("resume") and name.endswith(".stillray")
                       for name in os.listdir(self.output))
        except OSError:
            return False


def fingerprint(names, frames):
    """Changes when a frame is rendered again."""
    digest = hashlib.sha256()
    for frame in frames:
        file = names.file(frame)
        status = os.stat(file)
        row = f"{os.path.basename(file)}\0{status.st_size}\0{status.st_mtime_ns}\n"
        digest.update(row.encode("utf-8", "surrogateescape"))
    return digest.hexdigest()


def damaged(names, frames):
    """[(frame, why)] of files that are not complete."""
    faults = ((frame, exr_header.fault(names.file(frame))) for frame in frames)
    return [(frame, why) for frame, why in faults if why]


def _make_folder(folder):
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise JobError(f"The folder {folder} cannot be made: {error.strerror}") from error


def _file_argument(file, names):
    """A file as an argument of the program, which runs in the folder of the frames."""
    return paths.relative_argument(file, names.folder).rstrip("/") if file else ""


def plan_denoise(program, names, frames, result, layers, options, work=None):
    """Stages that write `result`; `layers` are the view layers to denoise, one stage each. [""]
    leaves the choice to the program."""
    work = work or os.path.join(result, WORK)
    stages = []
    source = names
    for i, layer in enumerate(layers):
        is_last = i == len(layers) - 1
        output = result if is_last else os.path.join(work, f"layer{i + 1}")
        log = os.path.join(work, f"denoise{i + 1}.json")
        stage_options = options.for_stage(layer, layers, _file_argument(options.cameras, source))
        arguments = command.denoise(
            program, source, frames, paths.relative_argument(output, source.folder), stage_options,
            layer, _file_argument(log, source), first=i == 0)
        target = names.moved(output)
        label = f"Denoising view layer {layer}" if len(layers) > 1 else "Denoising"
        stages.append(Stage(label, source.folder, arguments, output, log, target, frames))
        source = target
    return stages


def plan_check(names, frames, options, work, layer=""):
    log = os.path.join(work, "check.json")
    arguments = command.check(names, frames, options, layer, _file_argument(log, names))
    return [Stage("Checking", names.folder, arguments, work, log, None, frames)]


class Job:
    """States: running, finished, cancelled, failed, detached."""

    def __init__(self, program, stages, work, key="", resume=True):
        self.program = program
        self.stages = stages
        self.work = work
        self.key = key
        self.resume = resume
        self.state = "new"
        self.error = ""
        self.output = progress.Output()
        self.reused = 0  # stages that an earlier run finished
        self.resumed = False
        self._index = 0
        self._process = None
        self._log = None
        self._lock = lock.Lock(os.path.join(work, "lock"))
        self._stop_time = None
        self._started = 0.0

    @property
    def log_file(self):
        return os.path.join(self.work, "stillray.log")

    @property
    def _state_file(self):
        return os.path.join(self.work, "run.json")

    def start(self):
        """Raises JobError; lock.Locked if another run is under way."""
        _make_folder(self.work)
        try:
            self._lock.acquire()
        except OSError as error:
            raise JobError(f"{self.work} cannot be written to: {error.strerror}") from error
        try:
            self._begin_state()
            self.state = "running"
            self._started = time.monotonic()
            self._skip_finished()
            self._next_stage()
        except BaseException as error:
            self._lock.release()
            self.state = "failed"
            if isinstance(error, OSError):
                raise JobError(f"{self.work} cannot be written to: {error.strerror}") from error
            raise

    def _signature(self):
        return {"version": 1, "key": self.key, "program": list(self.program.version),
                "arguments": [stage.arguments for stage in self.stages]}

    def _begin_state(self):
        """Same settings, same inputs: finished stages stay. Else their logs go, so that none counts
        as finished."""
        signature = self._signature()
        try:
            with open(self._state_file, encoding="utf-8") as stream:
                same = json.load(stream) == signature
        except (OSError, ValueError):
            same = False
        self._same = same and self.resume and bool(self.key)
        if not self._same:
            for stage in self.stages:
                if os.path.exists(stage.json_file):
                    os.remove(stage.json_file)
        if os.path.exists(self.log_file):
            os.remove(self.log_file)
        with open(self._state_file, "w", encoding="utf-8") as stream:
            json.dump(signature, stream)

    def _skip_finished(self):
        if not self._same:
            return
        if self.stages[-1].is_finished:  # files of the stages before it are gone by then
            self._index = len(self.stages)
        while self._index < len(self.stages) and self._stage.is_finished:
            self._index += 1
        self.reused = self._index

    def _next_stage(self):
        if self._index == len(self.stages):
            self._end("finished")
            return
        self.resumed = self._same and self._stage.can_resume
        self._launch(self._stage.arguments + (["--resume"] if self.resumed else []))

    @property
    def _stage(self):
        return self.stages[self._index]

    @property
    def stage(self):
        return self.stages[min(self._index, len(self.stages) - 1)]

    def _launch(self, arguments):
        self.output = progress.Output()
        flags = {"creationflags": 0x08000200} if sys.platform == "win32" else \
            {"start_new_session": True}
        try:
            if self._stage.names is not None:
                _make_folder(self._stage.output)
            self._log = open(self.log_file, "ab")
            self._log.write((json.dumps([self.program.path, *arguments]) + "\n").encode())
            self._log.flush()
            self._read_from = self._log.tell()
            self._process = subprocess.Popen(
                [self.program.path, *arguments], cwd=self._stage.folder, stdin=subprocess.DEVNULL,
                stdout=self._log, stderr=subprocess.STDOUT, **flags)
        except OSError as error:
            if self._log is not None:
                self._log.close()
            raise JobError(f"stillray does not start: {error}") from error
        self._lock.set_program(self._process.pid)

    def _read(self):
        try:
            with open(self.log_file, "rb") as stream:
                stream.seek(self._read_from)
                data = stream.read()
        except OSError:
            return
        self._read_from += len(data)
        self.output.feed(data)

    def poll(self):
        """To be called a few times per second. Returns the state."""
        if self.state != "running":
            return self.state
        self._lock.renew()
        code = self._process.poll()
        self._read()
        if code is None:
            if self._stop_time and time.monotonic() > self._stop_time + _GRACE_SECONDS:
                self._process.kill()
            return self.state
        self.output.finish()
        self._log.close()
        self._lock.set_program(None)
        self._finish_stage(code)
        return self.state

    def _finish_stage(self, code):
        if self._stop_time:
            self._end("cancelled")
        elif code == 0 or (code == 3 and self._stage.names is None):
            self._index += 1
            try:
                self._next_stage()
            except JobError as error:
                self._end("failed", str(error))
        elif code == 130:
            self._end("cancelled")
        elif code == 2 and self.resumed and "resume" in self.output.error_text():
            # A state of another version, or damaged: from the start, which replaces it.
            self.resumed = False
            try:
                self._launch(self._stage.arguments)
            except JobError as error:
                self._end("failed", str(error))
        else:
            self._end("failed", self._failure(code))

    def _failure(self, code):
        text = self.output.error_text()
        if code == 2:
            return f"stillray: {text}"
        if code == 1:
            return f"stillray has a defect: {text}. Its output is in {self.log_file}"
        if code < 0:
            return f"stillray was ended by signal {-code}. Denoise again to go on"
        return f"stillray ended with code {code}: {text}"

    def _end(self, state, error=""):
        self.state = state
        self.error = error
        if state == "finished":
            for stage in self.stages[:-1]:
                shutil.rmtree(stage.output, ignore_errors=True)
        self._lock.release()

    def cancel(self):
        """Asks the program to stop; it saves its state first, and the job ends at a later poll."""
        if self.state != "running" or self._stop_time:
            return
        self._stop_time = time.monotonic()
        try:
            if sys.platform == "win32":
                self._process.terminate()
            else:
                self._process.send_signal(signal.SIGINT)
        except OSError:
            pass  # it has ended

    def detach(self):
        """The program goes on alone; the next run finds its work."""
        if self.state == "running":
            self.state = "detached"
            self._log.close()
            self._lock.detach()

    def wait(self):
        while self.poll() == "running":
            time.sleep(_POLL_SECONDS)
        return self.state

    @property
    def fraction(self):
        return min((self._index + self.output.fraction) / len(self.stages), 1.0)

    def time_left(self):
        """As text; empty until it can be told."""
        if len(self.stages) - self.reused == 1:
            return self.output.left
        elapsed = time.monotonic() - self._started
        own = len(self.stages) - self.reused
        done = (self._index - self.reused + self.output.fraction) / own if own else 1.0
        return progress.duration(elapsed * (1 - done) / done) if done > 0 and elapsed > 1 else ""

    def status(self):
        if self._stop_time:
            return "Stopping ..."
        text = self.stage.label
        if self.output.total:
            text += f": frame {self.output.frame} ({self.output.done} of {self.output.total})"
        elif self.stage.names is not None:
            text += ": reading and looking ahead"
        left = self.time_left()
        return text + (f", {left} left" if left else "")


def findings_of(file):
    """Findings in a log of `stillray denoise` or `stillray check`."""
    try:
        with open(file, encoding="utf-8") as stream:
            found = json.load(stream).get("findings", [])
        return [{"name": str(f["name"]), "what": str(f["what"]), "cure": str(f["cure"]),
                 "aov": str(f.get("aov", "")), "frames": [int(n) for n in f["frames"]]}
                for f in found]
    except (OSError, ValueError, AttributeError, KeyError, TypeError):
        return []
