# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Files denoised from Python equal those of `stillray denoise`, byte for byte. STILLRAY_PROGRAM
names the program."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import stillray

FRAMES = 20
PROGRAM = os.environ["STILLRAY_PROGRAM"]
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/python/denoise_files.py"


def run(*arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


class FilesTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        run(PROGRAM, "render", "builtin:spheres", "-o", str(cls.folder / "rendered"), "--size",
            "48x32", "--frames", f"5-{4 + FRAMES}", "--format", "exr", "--save-inputs",
            "--no-jitter", "--device", "cpu")  # fmt: skip
        cls.inputs = cls.folder / "in"
        cls.inputs.mkdir()
        for path in (cls.folder / "rendered").glob("noisy.*.exr"):
            path.rename(cls.inputs / path.name)
        cls.paths = sorted(cls.inputs.glob("*.exr"))

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def expect_same(self, a, b):
        names = sorted(path.name for path in self.paths)
        for folder in a, b:
            self.assertEqual(sorted(path.name for path in folder.glob("*.exr")), names)
        for name in names:
            self.assertEqual((a / name).read_bytes(), (b / name).read_bytes(), name)

    def by_command(self, name, *options):
        run(PROGRAM, "denoise", str(self.inputs), "-o", str(self.folder / name) + "/",
            "--device", "cpu", *options)  # fmt: skip
        return self.folder / name

    def test_both_windows_with_passes(self):
        expected = self.by_command("command", "--window", "both", "--passes")
        seen = []
        frames = stillray.denoise_files(
            self.inputs / "noisy.####.exr", self.folder / "python", window="both", passes=True,
            progress=seen.append,
        )  # fmt: skip
        self.expect_same(self.folder / "python", expected)
        self.assertEqual([frame["frame"] for frame in frames], list(range(5, 5 + FRAMES)))
        self.assertEqual([frame["output"] for frame in seen], [f["output"] for f in frames])

    def test_example(self):
        expected = self.by_command("command2", "--window", "both", "--passes")
        out = run(sys.executable, "-B", EXAMPLE, self.inputs, self.folder / "example")
        self.assertIn(f"frame {4 + FRAMES}:", out)
        self.expect_same(self.folder / "example", expected)

    def test_settings_and_the_past(self):
        expected = self.by_command("command3", "--window", "past", "--set", "sigma_l=2", "--set",
                                   "prefilter_variance=off", "--preset", "svgf")  # fmt: skip
        stillray.denoise_files(self.paths, self.folder / "python3", window="past", preset="svgf",
                               sigma_l=2, prefilter_variance=False)  # fmt: skip
        self.expect_same(self.folder / "python3", expected)

    def test_estimated_motion(self):
        expected = self.by_command("command7", "--motion", "estimate")
        frames = stillray.denoise_files(self.paths, self.folder / "python7", motion="estimate")
        self.expect_same(self.folder / "python7", expected)
        self.assertEqual(frames[-1]["motion"], "estimate")

    def test_stated_samples(self):
        expected = self.by_command("command9", "--spp", "4")
        stillray.denoise_files(self.paths, self.folder / "python9", spp=4)
        self.expect_same(self.folder / "python9", expected)
        alone = self.by_command("command10")
        with self.assertRaises(AssertionError):
            self.expect_same(self.folder / "python9", alone)
        with self.assertRaisesRegex(ValueError, "spp is -1, expected 1 or more"):
            stillray.denoise_files(self.paths, self.folder / "python10", spp=-1)

    def test_alpha_that_does_not_exist_is_named(self):
        for alpha, message in [("denoise", "has no alpha"), ("clean", "expected 'keep' or 'denoise'")]:
            with self.assertRaisesRegex(ValueError, message):
                stillray.denoise_files(self.paths, self.folder / "python8", alpha=alpha)

    def test_a_stopped_call_goes_on(self):
        expected = self.by_command("command4", "--window", "both")
        out = self.folder / "python4"
        with self.assertRaises(stillray.Cancelled):
            stillray.denoise_files(
                self.paths, out, window="both", resume=True, progress=lambda frame: frame["frame"] < 9
            )
        done = len(list(out.glob("*.exr")))
        self.assertTrue(1 <= done < FRAMES, done)
        seen = []
        stillray.denoise_files(
            self.paths, out, window="both", resume=True, progress=seen.append
        )
        self.assertEqual(len(seen), FRAMES - done)
        self.expect_same(out, expected)

    def test_what_the_progress_function_raises_comes_through(self):
        with self.assertRaises(KeyError):
            stillray.denoise_files(self.paths, self.folder / "python5", progress=lambda f: {}["no"])

    def test_wrong_calls_name_what_is_wrong(self):
        out = self.folder / "python6"
        with self.assertRaisesRegex(FileNotFoundError, "absent.exr"):
            stillray.denoise_files(["absent.exr"], out)
        with self.assertRaisesRegex(ValueError, "window is 'future'"):
            stillray.denoise_files(self.paths, out, window="future")
        with self.assertRaisesRegex(ValueError, "motion is 'guessed'"):
            stillray.denoise_files(self.paths, out, motion="guessed")
        with self.assertRaisesRegex(FileNotFoundError, "absent.json"):
            stillray.denoise_files(self.paths, out, cameras="absent.json")
        with self.assertRaisesRegex(ValueError, "sigma_q"):
            stillray.denoise_files(self.paths, out, sigma_q=1)
        with self.assertRaisesRegex(ValueError, "overwrite the input"):
            stillray.denoise_files(self.paths, self.inputs)


if __name__ == "__main__":
    unittest.main()
