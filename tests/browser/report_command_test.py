# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The command `stillray report` as a user types it: files written, exit codes, one-line errors.

    report_command_test.py STILLRAY
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True

from png import write_png  # noqa: E402

program = None


class ReportCommand(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stillray-report-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def add(self, name, level=100, width=8, height=8):
        write_png(self.folder / name, width, height, lambda x, y: (level, 10 * x, 10 * y))

    def run_report(self, *arguments):
        return subprocess.run([program, "report", *map(str, arguments)], capture_output=True,
                              text=True, timeout=60, check=False)

    def assert_fails(self, expected, *arguments):
        """The command ends with 2, one line that holds the text, and no page."""
        result = self.run_report(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        self.assertTrue(result.stderr.startswith("stillray: error: "), result.stderr)
        self.assertIn(expected, result.stderr)
        self.assertEqual(list(self.folder.glob("**/*.html*")), [])

    def test_writes_the_page_into_the_folder(self):
        self.add("denoised.0001.png")
        result = self.run_report(self.folder)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        self.assertIn("1 of 1 frames", result.stdout)
        page = (self.folder / "report.html").read_text(encoding="utf-8")
        self.assertTrue(page.startswith("<!doctype html>"))
        self.assertTrue(page.endswith("</html>\n"))

    def test_other_output_and_fewer_frames(self):
        for frame in range(1, 8):
            self.add(f"denoised.{frame:04}.png", 10 * frame)
        result = self.run_report(self.folder, "-o", self.folder / "a.html", "--max-frames", 3,
                                 "--zoom-width", 4)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("3 of 7 frames", result.stdout)
        self.assertIn('"zoom_width":4', (self.folder / "a.html").read_text(encoding="utf-8"))
        self.assertFalse((self.folder / "report.html").exists())

    def test_missing_folder(self):
        self.assert_fails("no such folder", self.folder / "none")

    def test_no_frames(self):
        self.assert_fails("no frames", self.folder)

    def test_sizes_that_differ(self):
        self.add("noisy.0001.png")
        self.add("denoised.0001.png", width=9)
        self.assert_fails("denoised.0001.png: 9x8 pixels", self.folder)

    def test_truncated_picture(self):
        self.add("noisy.0001.png")
        path = self.folder / "noisy.0001.png"
        path.write_bytes(path.read_bytes()[:60])
        self.assert_fails("noisy.0001.png", self.folder)

    def test_damaged_log(self):
        self.add("noisy.0001.png")
        (self.folder / "render.json").write_text('{\n"spp": }', encoding="utf-8")
        self.assert_fails("render.json: line 2", self.folder)

    def test_unknown_key_in_log(self):
        self.add("noisy.0001.png")
        (self.folder / "render.json").write_text('{"samples": 1}', encoding="utf-8")
        self.assert_fails('unknown key "samples"', self.folder)

    def test_unwritable_output(self):
        self.add("noisy.0001.png")
        self.assert_fails("nowhere", self.folder, "-o", self.folder / "nowhere" / "a.html")

    def test_number_of_frames_out_of_range(self):
        self.add("noisy.0001.png")
        self.assert_fails("found 0, expected 1..1000", self.folder, "--max-frames", 0)

    def test_sequences_of_any_name(self):
        for frame in (1, 2, 3):
            self.add(f"beauty_{frame:03}.png", 10 * frame)
            self.add(f"clean.{frame}.png", 20 * frame)
            self.add(f"ref.{frame:04}.png", 20 * frame + 1)
        page = self.folder / "page.html"
        result = self.run_report("--noisy", self.folder / "beauty_*.png", "--clean",
                                 self.folder / "clean.#.png", "--reference",
                                 self.folder / "ref.####.png", "-o", page)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("3 of 3 frames", result.stdout)
        self.assertTrue(page.exists())

    def test_default_output_of_sequences_lies_beside_the_clean_pictures(self):
        (self.folder / "clean").mkdir()
        self.add("shot.0001.png")
        self.add("clean/shot.0001.png")
        result = self.run_report("--noisy", self.folder / "shot.####.png", "--clean",
                                 self.folder / "clean")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertTrue((self.folder / "clean" / "report.html").exists())

    def test_sequences_that_do_not_fit(self):
        self.add("a.0001.png")
        self.assert_fails("--clean is missing", "--noisy", self.folder / "a.####.png")
        self.assert_fails("--clean: ", "--noisy", self.folder / "a.####.png", "--clean",
                          self.folder / "b.####.png")
        self.assert_fails("found a.0001.png: did you mean", "--noisy", self.folder / "a.####.png",
                          "--clean", self.folder / "b.####.png")
        self.assert_fails("folder of a stillray render, or", self.folder, "--noisy", "x")
        self.assert_fails("folder of a stillray render, or")
        self.assert_fails("--exposure and --tonemap go with --clean", self.folder, "--exposure", 1)

    def test_size_that_is_no_number(self):
        self.add("noisy.0001.png")
        for size in ("0", "-1", "inf"):
            self.assert_fails(f"--max-size is {size}, expected 0.01 to 2000 MB", self.folder,
                              f"--max-size={size}")
        self.assert_fails("--max-size: found 'nan', expected a number", self.folder,
                          "--max-size=nan")

    def test_command_line_errors_end_with_two(self):
        self.assertEqual(self.run_report().returncode, 2)
        self.assertEqual(self.run_report(self.folder, "--max-frames", "many").returncode, 2)


def main():
    global program
    if len(sys.argv) < 2:
        sys.exit("usage: report_command_test.py STILLRAY [unittest arguments]")
    program = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)


if __name__ == "__main__":
    main()
