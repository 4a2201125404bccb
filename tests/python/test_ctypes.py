# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The module that calls the library by ctypes: the same API and bits as the compiled module, whose
folder STILLRAY_COMPILED_MODULE names; and what it says where its library is missing or wrong."""

import inspect
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import stillray

PACKAGE = pathlib.Path(stillray.__file__).parent
COMPILED = os.environ.get("STILLRAY_COMPILED_MODULE", "")

# Prints what both modules must agree on: tables, documentation, results.
FACTS = """
import hashlib, numpy as np, stillray
for p in stillray.parameters():
    print(p, p.help, p.group, p.unit, p.type, p.min, p.max, p.default, p.choices)
print(stillray.__version__, stillray.presets(), stillray.inputs())
for name in sorted(stillray.__all__):
    print(name, getattr(stillray, name).__module__ if name[0] not in "_" else "")
for name in sorted(n for n in dir(stillray.Denoiser) if n[0] != "_"):
    doc = getattr(stillray.Denoiser, name).__doc__
    print(name, " ".join(line.strip() for line in doc.splitlines() if not line.startswith(name + "(")).strip())
rng = np.random.default_rng(5)
denoiser = stillray.Denoiser("svgf", threads=2, sigma_l=3, steps=(1, 2), demodulate=True)
print(denoiser.settings, denoiser.threads, denoiser.device, denoiser.outputs)
for i in range(3):
    frame = {"direct_diffuse": rng.random((17, 23, 3), np.float32),
             "motion": rng.random((17, 23, 2)).astype(np.float16)}
    results = denoiser.denoise(frame, outputs=denoiser.outputs, jitter=(0.25, -0.125))
    for name in sorted(results):
        print(name, results[name].shape, results[name].dtype, hashlib.sha1(results[name].tobytes()).hexdigest())
print(hashlib.sha1(denoiser.save_history()).hexdigest(), denoiser.memory_need(frame))
print({k: v for k, v in denoiser.statistics.items() if k != "filter_ms"})
"""


def facts(folder):
    # Python looks in the working folder first.
    return subprocess.run([sys.executable, "-B", "-c", FACTS], capture_output=True, text=True,
                          check=True, cwd=str(folder), env={**os.environ, "PYTHONPATH": str(folder)}).stdout


def import_error(folder, *path):
    """The last line of what `import stillray` prints."""
    run = subprocess.run([sys.executable, "-B", "-c", "import stillray"], capture_output=True, text=True,
                         cwd=str(folder), env={**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), *path])})
    return run.stderr.strip().split("\n")[-1] if run.returncode else ""


class SameApiTest(unittest.TestCase):
    @unittest.skipUnless(COMPILED, "no compiled module is there")
    def test_tables_documentation_and_bits(self):
        here, there = facts(PACKAGE.parent).splitlines(), facts(COMPILED).splitlines()
        self.assertGreater(len(here), 100)
        self.assertEqual(here, there)

    def test_arguments_are_those_of_the_hints(self):
        hints = (PACKAGE / "_stillray.pyi").read_text().replace("\n", " ")
        for name, method in inspect.getmembers(stillray.Denoiser, inspect.isfunction):
            if not name.startswith("_"):
                for argument in inspect.signature(method).parameters:
                    self.assertIn(argument, hints[hints.index("def %s(" % name):][:400], name)

    def test_wrong_types(self):
        for arguments in {"preset": 3}, {"threads": 1.5}, {"threads": 1 << 40}, {"device": None}:
            with self.assertRaises(TypeError):
                stillray.Denoiser(**arguments)
        with self.assertRaises(TypeError):
            stillray.Denoiser().restore_history("text")
        with self.assertRaisesRegex(ValueError, "null character"):
            stillray.Denoiser("default\0")


class BrokenInstallationTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name, "a folder")
        shutil.copytree(PACKAGE, self.folder / "stillray", symlinks=False,
                        ignore=shutil.ignore_patterns("__pycache__"))
        self.library = next(self.folder.glob("stillray/libstillray.so.*"))

    def test_without_its_library(self):
        self.library.unlink()
        error = import_error(self.folder)
        self.assertIn("ImportError: stillray: %s is not in " % self.library.name, error)
        self.assertIn("install the package again", error)

    def test_with_a_damaged_library(self):
        self.library.write_bytes(b"no library")
        self.assertRegex(import_error(self.folder), "ImportError: stillray: .* could not be loaded: ")

    def test_with_another_library(self):
        self.library.unlink()
        self.library.symlink_to("/lib/x86_64-linux-gnu/libc.so.6")
        if self.library.exists():
            self.assertIn("has no function stillray_abi_version: it is of another version",
                          import_error(self.folder))

    def test_other_modules_of_the_name_in_the_path(self):
        # What stands later in the path is not mixed in; nor are files of the name of its parts.
        other = self.folder / "other"
        (other / "stillray").mkdir(parents=True)
        (other / "stillray/__init__.py").write_text("raise SystemExit('the other one')\n")
        (other / "_stillray.py").write_text("raise SystemExit('a part of the other one')\n")
        (other / "_frames.py").write_text("raise SystemExit('a part of the other one')\n")
        self.assertEqual(import_error(PACKAGE.parent, str(other)), "")

    def test_without_numpy(self):
        (self.folder / "numpy.py").write_text("raise ImportError('none here')\n")
        self.assertIn("ImportError: stillray needs NumPy: pip install numpy", import_error(self.folder))


if __name__ == "__main__":
    unittest.main()
