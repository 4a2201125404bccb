# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Runs the Python example and looks at what it made."""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/python/denoise.py"


class ExampleTest(unittest.TestCase):
    def test_example_denoises(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subprocess.run(
                [sys.executable, "-B", str(EXAMPLE), folder], capture_output=True, text=True
            )
            self.assertEqual(run.returncode, 0, run.stderr)
            noisy, denoised = map(
                float, re.search(r"noisy ([\d.]+), denoised ([\d.]+)", run.stdout).groups()
            )
            self.assertLess(4 * denoised, noisy)
            picture = (pathlib.Path(folder) / "denoised.ppm").read_bytes()
            self.assertTrue(picture.startswith(b"P6\n320 180\n255\n"))
            self.assertEqual(len(picture), 15 + 320 * 180 * 3)


if __name__ == "__main__":
    unittest.main()
