#!/usr/bin/env python3
# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Tests of the add-on's parts that need no Blender: names, command lines, progress, lock, runs, EXR
headers, matrices, settings."""
import ast
import json
import math
import ntpath
import os
import pathlib
import posixpath
import random
import re
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zipfile
import zlib

import addon_package

from stillray_addon import (camera_math, command, exr_header, job, lock, paths, program, progress,
                            settings)

try:
    import tomllib
except ImportError:
    tomllib = None

FAKE = str(pathlib.Path(__file__).with_name("fake_stillray.py"))


def names_in(folder, prefix="f.", digits=4, suffix=".exr"):
    return paths.FrameNames(str(folder), prefix, digits, suffix)


class TemporaryFolder(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="still ray \"ö'#")
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, data=b"x"):
        with open(self.path(name), "wb") as stream:
            stream.write(data)
        return self.path(name)


class FrameNames(unittest.TestCase):
    def test_probe_finds_prefix_digits_and_suffix(self):
        cases = (("/r/shot.%04d.exr", "/r", "shot.", 4, ".exr"),
                 ("/r/%04d.exr", "/r", "", 4, ".exr"),
                 ("/r 1/a 2_%02d_v2.exr", "/r 1", "a 2_", 2, "_v2.exr"),
                 ("/r/1111111.%d.exr", "/r", "1111111.", 1, ".exr"),
                 ("/größe/it's \"a\".%06d.exr", "/größe", "it's \"a\".", 6, ".exr"))
        for pattern, folder, prefix, digits, suffix in cases:
            names = paths.FrameNames.probe(lambda n, p=pattern: p % n, posixpath)
            self.assertEqual((names.folder, names.prefix, names.digits, names.suffix),
                             (folder, prefix, digits, suffix))
            for frame in (0, 7, 123, 12345):
                self.assertEqual(names.file(frame, posixpath), pattern % frame)

    def test_probe_on_windows(self):
        names = paths.FrameNames.probe(lambda n: f"D:\\Öl\\my shot\\a.{n:04d}.exr", ntpath)
        self.assertEqual((names.folder, names.prefix), ("D:\\Öl\\my shot", "a."))
        self.assertEqual(names.file(3, ntpath), "D:\\Öl\\my shot\\a.0003.exr")

    def test_probe_without_a_number(self):
        with self.assertRaisesRegex(ValueError, "no frame number"):
            paths.FrameNames.probe(lambda n: "/r/a.exr")

    def test_number_is_the_inverse_of_name(self):
        names = names_in("/r", "a1.", 4, ".exr")
        for frame in (0, 1, 9999, 10000, -3):
            self.assertEqual(names.number(names.name(frame)), frame)
        for other in ("a1.001.exr", "a1.00001.exr", "a1.0001.png", "b1.0001.exr", "a1..exr",
                      "a1.0001.exr.tmp", "a1.x001.exr", "a1.1².exr"):
            self.assertIsNone(names.number(other), other)

    def test_present_sorts_and_limits(self):
        listed = ["a.0010.exr", "a.0002.exr", "a.0001.exr", "b.0003.exr", "a.0003.exr~"]
        names = names_in("/r", "a.")
        self.assertEqual(names.present(2, 10, lambda folder: listed), [2, 10])
        self.assertEqual(names_in("/nonexistent/folder").present(1, 5), [])

    def test_inputs_are_a_pattern_or_files(self):
        self.assertEqual(names_in("/r").inputs([1, 2]), ["./f.####.exr"])
        self.assertEqual(names_in("/r").inputs([7]), ["./f.0007.exr"])
        for mark in "#%*?[]":
            names = names_in("/r", f"a{mark}b.")
            self.assertFalse(names.is_plain)
            self.assertEqual(names.inputs([1, 2]), [f"./a{mark}b.0001.exr", f"./a{mark}b.0002.exr"])
        self.assertEqual(names_in("/r", "-o.").inputs([1, 2]), ["./-o.####.exr"])

    def test_ranges(self):
        self.assertEqual(paths.ranges([5, 1, 2, 3]), "1-3, 5")
        self.assertEqual(paths.ranges([]), "")
        self.assertEqual(paths.ranges([4]), "4")

    def test_contiguous_around(self):
        have = [1, 2, 3, 5, 6, 7, 8]
        self.assertEqual(paths.contiguous_around(have, 6, 8), [5, 6, 7, 8])
        self.assertEqual(paths.contiguous_around(have, 6, 1), [5, 6, 7])
        self.assertEqual(paths.contiguous_around(have, 3, 0), [3])
        self.assertEqual(paths.contiguous_around(have, 4, 8), [])


class Folders(unittest.TestCase):
    def test_result_folder(self):
        self.assertEqual(paths.result_folder("/r/a", "clean", posixpath), "/r/a/clean")
        self.assertEqual(paths.result_folder("/r/a", "/x/y/", posixpath), "/x/y")
        self.assertEqual(paths.result_folder("C:\\r", "clean", ntpath), "C:\\r\\clean")
        self.assertEqual(paths.result_folder("C:\\r", "D:\\x", ntpath), "D:\\x")
        for bad in ("", "  ", ".", "../a"):
            with self.assertRaises(ValueError, msg=bad):
                paths.result_folder("/r/a", bad, posixpath)

    def test_relative_argument_is_a_folder_whatever_its_name(self):
        self.assertEqual(paths.relative_argument("/r/a/c.exr", "/r/a", posixpath), "./c.exr/")
        self.assertEqual(paths.relative_argument("/r/b", "/r/a", posixpath), "../b/")
        self.assertEqual(paths.relative_argument("C:\\r\\ö ä", "C:\\r", ntpath), "./ö ä/")
        self.assertEqual(paths.relative_argument("D:\\x", "C:\\r", ntpath), "D:/x/")

    def test_default_output(self):
        self.assertEqual(paths.default_output("/p/my shot.blend", "Scene", False, posixpath),
                         "//render/my shot.####")
        self.assertEqual(paths.default_output("", "A/B#", True, posixpath),
                         "//render/untitled A_B_.####")
        for text in ("/tmp/", "/tmp\\", "", "C:\\tmp\\"):
            self.assertTrue(paths.is_default_output(text), text)
        self.assertTrue(paths.is_default_output("/var/x/", ["/var/x"]))
        self.assertFalse(paths.is_default_output("//render/a"))
        self.assertFalse(paths.is_default_output("/tmp/mine"))


class CommandLines(unittest.TestCase):
    program = program.Program("/bin/stillray", (0, 1, 0), {"--window"})

    def test_denoise(self):
        options = command.Options(preset="svgf", window="past", passes=True, fireflies=True,
                                  device="cpu", threads=2, memory_limit=" 2G ", aovs=["normal=N"])
        arguments = command.denoise(self.program, names_in("/r"), [3, 4, 5], "./clean/", options,
                                    "View Layer", "./log.json")
        self.assertEqual(arguments, [
            "denoise", "./f.####.exr", "--frames", "3-5", "-o", "./clean/", "--renderer", "blender",
            "--preset", "svgf", "--window", "past", "--view-layer", "View Layer", "--passes",
            "--set", "firefly=clamp", "--aov", "normal=N", "--device", "cpu", "--threads", "2",
            "--memory-limit", "2G", "--json", "./log.json"])

    def test_defaults_are_left_out(self):
        arguments = command.denoise(self.program, names_in("/r"), [3], "./c/", command.Options())
        self.assertEqual(arguments, ["denoise", "./f.0003.exr", "-o", "./c/", "--renderer",
                                     "blender", "--preset", "default", "--window", "auto"])

    def test_edges_are_smooth_in_time(self):
        def settings(**values):
            arguments = command.denoise(self.program, names_in("/r"), [1, 2], "./c/",
                                        command.Options(smooth=True, **values))
            return [b for a, b in zip(arguments, arguments[1:]) if a == "--set"]
        self.assertEqual(settings(), ["antialias=taa"])
        self.assertEqual(settings(preset="best"), ["antialias=taa"])
        self.assertEqual(settings(preset="svgf"), [])
        self.assertEqual(settings(passes=True), [])

    def test_cameras_only_for_a_program_that_takes_them(self):
        options = command.Options(cameras="./f.cameras.json")
        arguments = command.denoise(self.program, names_in("/r"), [1, 2], "./c/", options)
        self.assertNotIn("--cameras", arguments)
        newer = program.Program("/bin/stillray", (0, 2, 0), {"--cameras"})
        arguments = command.denoise(newer, names_in("/r"), [1, 2], "./c/", options)
        self.assertEqual(arguments[arguments.index("--cameras") + 1], "./f.cameras.json")

    def test_layer_options_go_to_their_view_layer(self):
        options = command.Options(aovs=["motion=A.Vector,pixels", "depth=B.Depth", "normal=N"],
                                  smooth=True)
        self.assertTrue(options.for_stage("A", ["A", "B"], "").smooth)
        self.assertEqual(options.for_stage("A", ["A", "B"], "").aovs,
                         ("motion=A.Vector,pixels", "normal=N"))
        self.assertEqual(options.for_stage("", [""], "").aovs, options.aovs)

    def test_chain_of_view_layers(self):
        newer = program.Program("/bin/stillray", (0, 2, 0), {"--cameras"})
        stages = job.plan_denoise(newer, names_in("/r"), [1, 2], "/r/clean", ["A", "B"],
                                  command.Options(cameras="/r/f.cameras.json"))
        self.assertEqual([stage.folder for stage in stages], ["/r", "/r/clean/.stillray/layer1"])
        first, second = (stage.arguments for stage in stages)
        self.assertEqual(first[first.index("-o") + 1], "./clean/.stillray/layer1/")
        self.assertEqual(second[second.index("-o") + 1], "../../")
        self.assertEqual(first[first.index("--cameras") + 1], "./f.cameras.json")
        self.assertEqual(second[second.index("--cameras") + 1], "../../../f.cameras.json")
        self.assertNotIn("--no-check", first)
        self.assertIn("--no-check", second)
        self.assertEqual(second[second.index("--json") + 1], "../denoise2.json")


class Progress(unittest.TestCase):
    text = ("understood as frames of blender\n  colour   ViewLayer.Combined RGB\n"
            "note: --window past, as frames are missing between 2 and 5\n"
            "frame 1 (1 of 6): read 5 ms, look ahead 81 ms, denoise 7 ms, write 7 ms\n"
            "frame -2 (2 of 6): read 5 ms, denoise 7 ms, write 7 ms, 3 min 05 s left\n")

    def test_frames_and_time_left(self):
        output = progress.Output()
        output.feed(self.text.encode())
        self.assertEqual((output.frame, output.done, output.total, output.left),
                         (-2, 2, 6, "3 min 05 s"))
        self.assertEqual(output.notes,
                         ["note: --window past, as frames are missing between 2 and 5"])

    def test_any_pieces_give_the_same(self):
        data = (self.text + "stillray: error: größe.exr: no such file").encode()
        for seed in range(20):
            random.seed(seed)
            output, at = progress.Output(), 0
            while at < len(data):
                step = random.randint(1, 40)
                output.feed(data[at:at + step])
                at += step
            output.finish()
            self.assertEqual((output.done, output.errors), (2, ["größe.exr: no such file"]))

    def test_error_text(self):
        output = progress.Output()
        self.assertEqual(output.error_text(), "it printed nothing")
        output.feed(b"Killed\n")
        self.assertEqual(output.error_text(), "Killed")
        output.feed(b"stillray: error: a\nstillray: error: b\n")
        self.assertEqual(output.error_text(), "a; b")

    def test_duration(self):
        self.assertEqual([progress.duration(s) for s in (-1, 12.4, 185, 7800)],
                         ["0 s", "12 s", "3 min 05 s", "2 h 10 min"])


class Locks(TemporaryFolder):
    def test_second_lock_is_refused_until_release(self):
        first, second = lock.Lock(self.path("lock")), lock.Lock(self.path("lock"))
        first.acquire()
        with self.assertRaisesRegex(lock.Locked, "being denoised already"):
            second.acquire()
        first.release()
        second.acquire()
        second.release()
        self.assertEqual(os.listdir(self.folder), [])

    def dead_process(self):
        process = subprocess.Popen([sys.executable, "-c", ""])
        process.wait()
        return process.pid

    def write_record(self, **record):
        self.write("lock", json.dumps(record).encode())

    def test_lock_of_a_dead_run_is_taken(self):
        host = lock.socket.gethostname()
        dead = {"pid": self.dead_process(), "started": "1"}
        self.write_record(host=host, blender=dead, program=dead)
        taken = lock.Lock(self.path("lock"))
        taken.acquire()
        taken.release()

    def test_lock_holds_while_the_program_outlives_blender(self):
        process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.write_record(host=lock.socket.gethostname(), blender={"pid": self.dead_process()},
                          program={"pid": process.pid, "started": lock.start_time(process.pid)})
        with self.assertRaisesRegex(lock.Locked, f"process {process.pid}"):
            lock.Lock(self.path("lock")).acquire()

    @unittest.skipUnless(os.path.exists("/proc/self/stat"), "needs /proc")
    def test_another_process_of_the_same_number_does_not_hold(self):
        self.write_record(host=lock.socket.gethostname(), program=None,
                          blender={"pid": os.getpid(), "started": "1"})
        self.assertIsNone(lock.Lock(self.path("lock")).holder())

    def test_another_computer_holds_by_the_age_of_the_file(self):
        self.write_record(host="elsewhere", blender={"pid": 1}, program=None)
        made = os.path.getmtime(self.path("lock"))
        young = lock.Lock(self.path("lock"), now=lambda: made + 10)
        old = lock.Lock(self.path("lock"), now=lambda: made + 2 * lock.FOREIGN_SECONDS)
        self.assertIsNotNone(young.holder())
        self.assertIsNone(old.holder())

    def test_renew_touches_the_file(self):
        clock = [time.time()]
        held = lock.Lock(self.path("lock"), now=lambda: clock[0])
        held.acquire()
        os.utime(self.path("lock"), (1, 1))
        held.renew()
        self.assertEqual(os.path.getmtime(self.path("lock")), 1)
        clock[0] += 2 * lock.RENEW_SECONDS
        held.renew()
        self.assertGreater(os.path.getmtime(self.path("lock")), 1)
        held.release()

    def test_damaged_file_holds_for_a_while_only(self):
        self.write("lock", b"{")
        self.assertIsNotNone(lock.Lock(self.path("lock")).holder())
        os.utime(self.path("lock"), (1, 1))
        self.assertIsNone(lock.Lock(self.path("lock")).holder())


class FindProgram(TemporaryFolder):
    def named(self, preference="", environment=None, on_path=None, platform="linux"):
        return program.candidates(preference, environment or {}, self.folder,
                                  lambda name: on_path, platform)

    def test_order(self):
        os.mkdir(self.path("bin"))
        beside = self.write("bin/stillray")
        self.assertEqual(self.named("/p", {"STILLRAY": "/e"}, "/w")[0][1], "/p")
        self.assertEqual(self.named("", {"STILLRAY": "/e"}, "/w")[0][1], "/e")
        self.assertEqual([path for _, path in self.named("", {}, "/w")], ["/w", beside])
        self.assertEqual(self.named(platform="win32"), [])

    def test_version_and_options(self):
        self.assertEqual(program.parse_version("stillray 1.20.3-dev\n"), (1, 20, 3))
        self.assertIsNone(program.parse_version("blender 3.4.1"))
        self.assertEqual(program.parse_options("  -o,--output TEXT\n --no-check x--y"),
                         {"--output", "--no-check"})

    def test_found(self):
        found = program.find(FAKE, {}, self.folder)
        self.assertEqual((found.version, found.has("--cameras")), ((0, 1, 0), True))

    def test_faults_are_forgotten_after_a_while(self):
        path = self.write("later", b"#!/bin/sh\nexit 1\n")
        os.chmod(path, 0o755)
        times = os.stat(path)
        with self.assertRaises(program.ProgramError):
            program.find(path, {}, self.folder)
        self.write("later", b"#!/bin/sh\necho stillray 1.0.0\n")
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
        with self.assertRaises(program.ProgramError):
            program.find(path, {}, self.folder)
        before, program._FAULT_SECONDS = program._FAULT_SECONDS, 0
        self.addCleanup(setattr, program, "_FAULT_SECONDS", before)
        self.assertEqual(program.find(path, {}, self.folder).version, (1, 0, 0))

    def test_faults_say_what_to_do(self):
        not_stillray = self.write("other", b"#!/bin/sh\necho hello\n")
        os.chmod(not_stillray, 0o755)
        old = self.write("old", b"#!/bin/sh\necho stillray 0.0.9\n")
        os.chmod(old, 0o755)
        plain = self.write("plain", b"\x7fnothing")
        for path, text in ((self.path("none"), "is not at .* preferences"),
                           (not_stillray, "is not stillray: --version prints 'hello'"),
                           (old, "is stillray 0.0.9; this add-on needs 0.1.0"),
                           (plain, "does not start")):
            with self.assertRaisesRegex(program.ProgramError, text):
                program.find(path, {}, self.folder)
        nowhere = {"PATH": ""}
        before, os.environ["PATH"] = os.environ["PATH"], ""
        self.addCleanup(os.environ.__setitem__, "PATH", before)
        with self.assertRaisesRegex(program.ProgramError, "was not found. Set its path in Pref"):
            program.find("", nowhere, self.path("empty", "folder"))


class Jobs(TemporaryFolder):
    def job(self, mode="ok", layers=("",), key="k", resume=True):
        os.environ["FAKE_STILLRAY"] = mode
        self.addCleanup(os.environ.pop, "FAKE_STILLRAY", None)
        found = program.Program(FAKE, (0, 1, 0), set())
        for frame in (1, 2, 3):
            self.write(f"f.{frame:04d}.exr")
        stages = job.plan_denoise(found, names_in(self.folder), [1, 2, 3], self.path("clean"),
                                  list(layers), command.Options())
        return job.Job(found, stages, self.path("clean", job.WORK), key, resume)

    def wait_for(self, condition):
        end = time.monotonic() + 20
        while not condition():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)

    def run_job(self, *arguments, **named):
        made = self.job(*arguments, **named)
        made.start()
        made.wait()
        return made

    def test_finished(self):
        done = self.run_job()
        self.assertEqual((done.state, done.error, done.fraction), ("finished", "", 1.0))
        self.assertEqual(done.status(), "Denoising: frame 3 (3 of 3), 5 s left")
        self.assertFalse(os.path.exists(self.path("clean", job.WORK, "lock")))
        self.assertEqual(job.findings_of(done.stages[0].json_file), [
            {"name": "fixed_seed", "what": "w", "cure": "c", "aov": "", "frames": [1, 2]}])

    def test_nothing_is_done_twice(self):
        self.run_job()
        self.assertEqual(self.run_job().reused, 1)
        self.assertEqual(self.run_job(resume=False).reused, 0)
        self.assertEqual(self.run_job(key="other").reused, 0)
        os.remove(self.path("clean", "f.0002.exr"))
        self.assertEqual(self.run_job(key="other").reused, 0)

    def test_several_view_layers(self):
        done = self.run_job(layers=("A", "B"))
        self.assertEqual(done.state, "finished")
        self.assertFalse(os.path.exists(self.path("clean", job.WORK, "layer1")))
        self.assertEqual(self.run_job(layers=("A", "B")).reused, 2)

    def test_errors_of_the_program(self):
        for mode, text in (("fail", "^stillray: out/f.0001.exr: No space left on device$"),
                           ("defect", "has a defect: check failed.*stillray.log"),
                           ("crash", "was ended by signal 9")):
            done = self.run_job(mode)
            self.assertEqual(done.state, "failed")
            self.assertRegex(done.error, text)
            self.assertFalse(os.path.exists(self.path("clean", job.WORK, "lock")))

    def test_program_that_cannot_start(self):
        made = self.job()
        made.program = program.Program(self.path("none"), (0, 1, 0), set())
        with self.assertRaisesRegex(job.JobError, "does not start"):
            made.start()
        self.assertFalse(os.path.exists(self.path("clean", job.WORK, "lock")))

    def test_folder_that_cannot_be_made(self):
        made = self.job()
        self.write("clean")
        with self.assertRaisesRegex(job.JobError, "cannot be made"):
            made.start()

    def test_cancel_then_resume(self):
        made = self.job("slow")
        made.start()
        self.wait_for(lambda: made.poll() == "running" and made.output.done == 1)
        made.cancel()
        self.assertEqual(made.status(), "Stopping ...")
        self.assertEqual(made.wait(), "cancelled")
        again = self.run_job()
        self.assertEqual((again.state, again.resumed), ("finished", True))
        with open(again.log_file, encoding="utf-8") as stream:
            self.assertIn("resuming with frame 2", stream.read())

    def test_state_that_cannot_be_resumed_is_replaced(self):
        made = self.job("slow")
        made.start()
        self.wait_for(lambda: made.poll() == "running" and made.output.done == 1)
        made.cancel()
        made.wait()
        again = self.run_job("bad_state")
        self.assertEqual((again.state, again.error), ("finished", ""))

    def test_two_at_once(self):
        made = self.job("slow")
        made.start()
        with self.assertRaises(lock.Locked):
            self.job("slow").start()
        made.cancel()
        made.wait()

    def test_blender_is_killed_and_the_program_finishes(self):
        """A process starts a job and dies; the program goes on, and the next run finds its work."""
        code = (f"import sys, os; sys.path.insert(0, {str(pathlib.Path(__file__).parent)!r})\n"
                "import parts_test\n"
                "case = parts_test.Jobs(); case.folder = sys.argv[1]\n"
                "made = case.job(); made.start(); os.kill(os.getpid(), 9)\n")
        subprocess.run([sys.executable, "-B", "-c", code, self.folder], check=False)
        self.wait_for(lambda: lock.Lock(self.path("clean", job.WORK, "lock")).holder() is None)
        again = self.run_job()
        self.assertEqual((again.state, again.reused), ("finished", 1))

    def test_detached_run_is_found_by_the_next_one(self):
        made = self.job()
        made.start()
        made.detach()
        self.assertEqual(made.poll(), "detached")
        made._process.wait()
        self.wait_for(lambda: lock.Lock(self.path("clean", job.WORK, "lock")).holder() is None)
        self.assertEqual(self.run_job().reused, 1)

    def test_fingerprint_changes_with_a_frame(self):
        names = names_in(self.folder)
        self.write("f.0001.exr")
        before = job.fingerprint(names, [1])
        self.write("f.0001.exr", b"other")
        self.assertNotEqual(job.fingerprint(names, [1]), before)

    def test_findings_of_a_damaged_log(self):
        for data in (b"", b"[]", b'{"findings": 3}', b'{"findings": [1]}'):
            self.write("log", data)
            self.assertEqual(job.findings_of(self.path("log")), [])


def exr(channels=("V.Combined.R",), compression=3, height=20, width=4):
    """A complete scan line file; all values are zero."""
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    listed = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1)
                      for n in sorted(channels)) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + attribute(b"channels", b"chlist", listed)
    head += attribute(b"compression", b"compression", bytes([compression]))
    head += attribute(b"dataWindow", b"box2i", window)
    head += attribute(b"displayWindow", b"box2i", window)
    head += b"\0"
    lines = {0: 1, 3: 16}[compression]
    chunks = []
    for y in range(0, height, lines):
        plain = bytes(2 * width * len(channels) * min(lines, height - y))
        data = plain if compression == 0 else zlib.compress(b"\0" + bytes([128]) * (len(plain) - 1))
        chunks.append(struct.pack("<ii", y, len(data)) + data)
    at, offsets = len(head) + 8 * len(chunks), b""
    for chunk in chunks:
        offsets += struct.pack("<Q", at)
        at += len(chunk)
    return head + offsets + b"".join(chunks)


class ExrHeaders(TemporaryFolder):
    def test_view_layers(self):
        channels = ["A.Combined.R", "A.Combined.G", "B.001.Combined.R", "A.Depth.Z", "R",
                    "Composite.Combined.R"]
        header = exr_header.parse(exr(channels))
        self.assertEqual(header.view_layers, ["A", "B.001"])
        self.assertEqual(exr_header.parse(exr(["R"])).view_layers, [])

    def test_complete(self):
        for compression in (0, 3):
            file = self.write("a.exr", exr(compression=compression))
            self.assertEqual(exr_header.fault(file), "")

    def test_every_cut_is_found(self):
        data = exr()
        for end in range(0, len(data), 7):
            self.assertNotEqual(exr_header.fault(self.write("a.exr", data[:end])), "", end)
        self.assertNotEqual(exr_header.fault(self.write("a.exr", data[:-1])), "")

    def test_chunks_that_were_not_written(self):
        data = bytearray(exr())
        at = data.index(struct.pack("<Q", len(exr_header_of(data)) + 16))
        data[at + 8:at + 16] = bytes(8)
        self.assertIn("not written to its end", exr_header.fault(self.write("a.exr", bytes(data))))

    def test_other_files(self):
        for data in (b"", b"PNG", os.urandom(1000), exr()[:8] + os.urandom(300)):
            self.assertNotEqual(exr_header.fault(self.write("a.exr", data)), "")
        self.assertIn("No such file", exr_header.fault(self.path("none.exr")))


def exr_header_of(data):
    return data[:exr_header.parse(bytes(data)).end]


class Flatten(TemporaryFolder):
    def setUp(self):
        super().setUp()
        from stillray_addon import flatten
        if flatten.numpy is None:
            self.skipTest("NumPy is not installed")
        self.flatten = flatten

    def test_zip_filter_by_definition(self):
        """Against the two steps of the format written as loops."""
        import numpy
        for size in (1, 2, 3, 16, 255):
            values = numpy.frombuffer(os.urandom(size), numpy.uint8)
            order = [int(v) for v in values[0::2]] + [int(v) for v in values[1::2]]
            packed = [order[0]] + [(b - a + 128 + 256) % 256 for a, b in zip(order, order[1:])]
            self.assertEqual(zlib.decompress(self.flatten.do_zip(values)), bytes(packed))
            self.assertEqual(self.flatten.undo_zip(zlib.compress(bytes(packed))).tobytes(),
                             values.tobytes())

    def test_plain_file(self):
        channels = [f"V.Combined.{c}" for c in "RGBA"] + ["V.Depth.Z", "W.Combined.R"]
        for compression in (0, 3):
            source = self.write("a.exr", exr(channels, compression))
            self.flatten.flatten(source, self.path("b.exr"), "V")
            header = exr_header.read(self.path("b.exr"))
            self.assertEqual(header.channels, ["A", "B", "G", "R"])
            self.assertEqual(exr_header.fault(self.path("b.exr")), "")

    def test_bad_files(self):
        target = self.path("b.exr")
        with self.assertRaisesRegex(ValueError, "no pass"):
            self.flatten.flatten(self.write("a.exr", exr(["R"])), target)
        with self.assertRaisesRegex(ValueError, "no pass X"):
            self.flatten.flatten(self.write("a.exr", exr()), target, "X")
        with self.assertRaises(ValueError):
            self.flatten.flatten(self.write("a.exr", exr()[:-8]), target, "V")
        self.assertFalse(os.path.exists(target))

    def test_job(self):
        for frame in (1, 2):
            self.write(f"f.{frame:04d}.exr", exr())
        target = names_in(self.path("plain"))
        made = self.flatten.FlattenJob(names_in(self.folder), [1, 2], target)
        made.start()
        self.assertEqual((made.wait(), made.fraction), ("finished", 1.0))
        os.remove(self.path("f.0002.exr"))
        os.remove(target.file(2))
        made = self.flatten.FlattenJob(names_in(self.folder), [1, 2], target)
        made.start()
        self.assertEqual(made.wait(), "failed")
        self.assertIn("f.0002.exr", made.error)


class CameraMath(TemporaryFolder):
    def test_inverse(self):
        random.seed(1)
        for _ in range(50):
            matrix = [[random.uniform(-2, 2) for _ in range(4)] for _ in range(4)]
            product = camera_math.multiply(matrix, camera_math.inverse(matrix))
            for i in range(4):
                for j in range(4):
                    self.assertAlmostEqual(product[i][j], float(i == j), places=8)
        with self.assertRaises(ValueError):
            camera_math.inverse([[0] * 4] * 4)

    def test_scale_of_the_camera_has_no_effect(self):
        angle, scale = 0.3, (2.0, 3.0, 0.5)
        c, s = math.cos(angle), math.sin(angle)
        plain = [[c, -s, 0, 4], [s, c, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1]]
        scaled = [[row[j] * scale[j] if j < 3 else row[3] for j in range(4)] for row in plain]
        scaled[3][3] = 1
        for a, b in zip(camera_math.flat(camera_math.world_to_camera(scaled)),
                        camera_math.flat(camera_math.inverse(plain))):
            self.assertAlmostEqual(a, b)

    def test_cropped(self):
        """A point at the border's corner is at the corner of the cropped picture."""
        projection = [[1.5, 0, 0.1, 0], [0, 2, -0.2, 0], [0, 0, -1.1, -0.2], [0, 0, -1, 0]]
        border = (0.25, 0.5, 0.75, 0.9)

        def project(matrix, point):
            clip = [sum(row[k] * point[k] for k in range(4)) for row in matrix]
            return [clip[i] / clip[3] for i in range(3)]

        for point in ((0.3, -0.2, -2, 1), (1, 1, -5, 1)):
            x, y, z = project(projection, point)
            u, v = (x + 1) / 2, (y + 1) / 2
            new = project(camera_math.cropped(projection, border), point)
            self.assertAlmostEqual((new[0] + 1) / 2, (u - 0.25) / 0.5)
            self.assertAlmostEqual((new[1] + 1) / 2, (v - 0.5) / 0.4)
            self.assertAlmostEqual(new[2], z)

    def test_markers(self):
        markers = [(10, "b"), (5, "a"), (7, None)]
        found = [camera_math.marker_camera(markers, n, "s") for n in (1, 5, 9, 10, 99)]
        self.assertEqual(found, ["a", "a", "a", "b", "b"])
        self.assertEqual(camera_math.marker_camera([], 1, "s"), "s")

    def test_file_keeps_earlier_frames_of_the_same_size(self):
        file = self.path("f.cameras.json")
        self.assertIsNone(camera_math.read(file))
        camera_math.write(file, 8, 4, [{"frame": 2, "projection": [1]}])
        camera_math.write(file, 8, 4, [{"frame": 1, "projection": None}])
        document = camera_math.read(file)
        self.assertEqual([f["frame"] for f in document["frames"]], [1, 2])
        names = names_in(self.folder)
        for frame in (1, 2):
            self.write(names.name(frame))
        self.assertTrue(camera_math.can_be_used(file, names, [2]))
        self.assertFalse(camera_math.can_be_used(file, names, [1, 2]))
        self.assertFalse(camera_math.can_be_used(self.path("none"), names, [2]))
        later = os.path.getmtime(file) + 60
        os.utime(names.file(2), (later, later))
        self.assertFalse(camera_math.can_be_used(file, names, [2]))
        camera_math.write(file, 16, 4, [{"frame": 5}])
        self.assertEqual([f["frame"] for f in camera_math.read(file)["frames"]], [5])
        for data in (b"{", b"[]", b'{"version": 2, "frames": []}'):
            self.write("f.cameras.json", data)
            self.assertIsNone(camera_math.read(file))


class Package(TemporaryFolder):
    def manifest(self):
        if tomllib is None:
            self.skipTest("needs Python 3.11")
        file = addon_package.ROOT / "blender/stillray_addon/blender_manifest.toml"
        return tomllib.loads(file.read_text(encoding="utf-8"))

    def test_manifest_follows_the_rules_of_extensions(self):
        manifest = self.manifest()
        self.assertEqual(set(manifest), {
            "schema_version", "id", "version", "name", "tagline", "maintainer", "type",
            "blender_version_min", "license", "copyright", "tags", "permissions"})
        for text in (manifest["tagline"], *manifest["permissions"].values()):
            self.assertLessEqual(len(text), 64)
            self.assertTrue(text[-1].isalnum())
        self.assertTrue(manifest["license"][0].startswith("SPDX:"))
        self.assertEqual(manifest["blender_version_min"], "4.2.0")

    def test_versions_agree(self):
        source = (addon_package.ROOT / "blender/stillray_addon/__init__.py").read_text(
            encoding="utf-8")
        info = ast.literal_eval(source.split("bl_info = ")[1].split("\n}")[0] + "}")
        self.assertEqual(".".join(map(str, info["version"])), self.manifest()["version"])
        self.assertEqual(info["name"], self.manifest()["name"])
        self.assertEqual(info["blender"], (3, 4, 0))

    def test_zip(self):
        """One folder with everything, for both ways to install; the same bytes each time."""
        script = str(addon_package.ROOT / "scripts/blender_addon.sh")
        contents = []
        for name in ("a.zip", "b.zip"):
            subprocess.run([script, self.path(name)], check=True, stdout=subprocess.DEVNULL)
            with open(self.path(name), "rb") as stream:
                contents.append(stream.read())
        self.assertEqual(contents[0], contents[1])
        with zipfile.ZipFile(self.path("a.zip")) as archive:
            names = set(archive.namelist())
        sources = {f"stillray_addon/{p.name}"
                   for p in (addon_package.ROOT / "blender/stillray_addon").glob("*.py")}
        self.assertEqual(names - sources, {"stillray_addon/blender_manifest.toml",
                                           "stillray_addon/LICENSE"})
        self.assertEqual(sources - names, set())


class Labels(unittest.TestCase):
    """Blender is not needed to read them: the lists are literals."""

    def items_of(self, name):
        source = (addon_package.ROOT / "blender/stillray_addon/properties.py").read_text(
            encoding="utf-8")
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.AnnAssign) and node.target.id == name:
                values = {k.arg: k.value for k in node.annotation.keywords}
                return ast.literal_eval(values["items"])
        self.fail(f"no property {name}")

    def test_no_quality_is_called_best_but_a_preset_of_that_name(self):
        labels = {identifier: label for identifier, label, _ in self.items_of("preset")}
        self.assertEqual(labels["default"], "High")
        for identifier, label in labels.items():
            self.assertEqual(label == "Best", identifier == "best", identifier)

    def test_the_page_lists_the_qualities_of_the_panel(self):
        page = (addon_package.ROOT / "docs/blender.md").read_text(encoding="utf-8")
        (row,) = [line for line in page.splitlines() if line.startswith("| *Quality* |")]
        self.assertEqual(re.findall(r"\*([^*]+)\*", row.split("|")[2]),
                         [label for _, label, _ in self.items_of("preset")])


class Thing:
    def __init__(self, **values):
        self.__dict__.update(values)


class Format(Thing):
    """As Blender: the depth follows the format."""

    def __setattr__(self, name, value):
        if name == "file_format" and value not in ("PNG", "EXR"):
            raise TypeError(value)
        depths = {"PNG": ("8", "16"), "EXR": ("16", "32")}
        if name == "depth" and value not in depths[self.file_format]:
            raise TypeError(value)
        self.__dict__[name] = value
        if name == "file_format":
            self.__dict__["depth"] = {"PNG": "8", "EXR": "32"}[value]


class Settings(unittest.TestCase):
    def setUp(self):
        self.format = Format(file_format="PNG")
        self.format.depth = "16"
        self.scene = Thing(samples=4096, width=1.5, seed=False)
        owners = {"": self.scene, "format": self.format}
        self.resolve = owners.__getitem__

    wanted = [("format", "file_format", "EXR"), ("format", "depth", "32"), ("", "samples", 4),
              ("", "width", 0.01), ("", "absent", True), ("gone", "x", 1), ("", "seed", False)]

    def apply(self, wanted=None):
        return settings.apply(wanted or self.wanted, self.resolve, [("format", "depth")])

    def values(self):
        return (self.format.file_format, self.format.depth, self.scene.samples, self.scene.width)

    def test_apply_lists_what_changed(self):
        changes, failed = self.apply()
        self.assertEqual(failed, [])
        self.assertEqual(self.values(), ("EXR", "32", 4, 0.01))
        self.assertEqual({c.key: (c.old, c.new) for c in changes}, {
            ("format", "file_format"): ("PNG", "EXR"), ("format", "depth"): ("16", "32"),
            ("", "samples"): (4096, 4), ("", "width"): (1.5, 0.01)})

    def test_restore_after_saving(self):
        saved = settings.dump(self.apply()[0])
        undone, left = settings.restore(settings.load(saved), self.resolve)
        self.assertEqual((len(undone), left), (4, []))
        self.assertEqual(self.values(), ("PNG", "16", 4096, 1.5))

    def test_twice_keeps_the_oldest_values(self):
        saved = settings.merge([], self.apply()[0])
        saved = settings.merge(saved, self.apply([("", "samples", 16)])[0])
        self.assertEqual(len(saved), 4)
        settings.restore(saved, self.resolve)
        self.assertEqual(self.values(), ("PNG", "16", 4096, 1.5))
        saved = settings.merge([], self.apply([("", "samples", 16)])[0])
        saved = settings.merge(saved, self.apply([("", "samples", 4096)])[0])
        self.assertEqual(saved, [])

    def test_what_the_user_changed_since_stays(self):
        saved = self.apply()[0]
        self.scene.samples = 64
        undone, left = settings.restore(saved, self.resolve)
        self.assertEqual([c.name for c in left], ["samples"])
        self.assertEqual(self.values(), ("PNG", "16", 64, 1.5))

    def test_values_that_cannot_be_set(self):
        self.assertEqual(self.apply([("format", "file_format", "TIFF")]), ([], ["File Format"]))

    def test_damaged_property(self):
        for text in ("", "{", "[1]", '[{"owner": ""}]', "null"):
            self.assertEqual(settings.load(text), [])

    def test_text(self):
        change = settings.Change('view_layers["a \\"b\\""].cycles', "denoising_store_passes", False,
                                 True)
        self.assertEqual(change.text(), 'a "b", Pass Denoising Data: off → on')
        self.assertEqual(settings.Change("cycles", "filter_width", 1.5, 0.01).text(),
                         "Pixel Filter Width: 1.5 → 0.01")


if __name__ == "__main__":
    unittest.main()
