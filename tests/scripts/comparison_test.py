# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""scripts/comparison.py and what it is made of, on tiny frames.

    comparison_test.py ROOT [PROGRAM]
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

ROOT = pathlib.Path(sys.argv[1])
PROGRAM = sys.argv[2] if len(sys.argv) > 2 else None
sys.path.insert(0, str(ROOT / "scripts"))

import comparison  # noqa: E402
import frame_filters  # noqa: E402
import measured  # noqa: E402
import picture_files  # noqa: E402


def values(**changed):
    """The numbers of a row; PSNR grows with quality, the others fall."""
    return {"psnr": 30.0, "flip": 0.1, "ssim": 0.9, "rel_mse": 0.01, "bright_specks": 1.0,
            "dark_specks": 2.0, "temporal_error": 0.005, "brightness": 0.98, "ms": 10.0, "mb": 50.0,
            **changed}


class Words(unittest.TestCase):
    def test_table(self):
        rows = [("a", {"x": 1.26}), ("b", {"x": None}), ("c", {})]
        self.assertEqual(measured.table(rows, [("X", measured.value("x", "{:.1f}"))]),
                         "| | X |\n|---|---|\n| a | 1.3 |\n| b | - |\n| c | - |")

    def test_names_and_frames(self):
        self.assertEqual(measured.named(["a b=c=d"]), [("a b", "c=d")])
        for wrong in ("a", "=b", "a="):
            with self.assertRaisesRegex(ValueError, f"'{wrong}': expected NAME="):
                measured.named([wrong])
        self.assertEqual(comparison.parse_frames("8,15-17"), [8, 15, 16, 17])
        with self.assertRaisesRegex(ValueError, "frames 'x': expected"):
            comparison.parse_frames("x")

    def test_foreign_frames_state_their_samples(self):
        self.assertEqual(comparison.samples_of("Fur"), ("Fur", 1))
        self.assertEqual(comparison.samples_of("Long hair:16"), ("Long hair, 16 spp", 16))
        for wrong in ("Fur:", "Fur:0", "Fur:many"):
            with self.assertRaisesRegex(ValueError, f"--sequence {wrong}: expected"):
                comparison.samples_of(wrong)

    def test_the_best_of_each_measure(self):
        rows = [("noisy", values(psnr=99, brightness=1.0)),
                ("`svgf`", values(psnr=31, dark_specks=0, brightness=1.01)),
                ("`best` (both)", values(flip=0.05, ms=80))]
        words = comparison.best_of_each(rows)
        # The input is no filter, and brightness counts by its distance from 1.
        self.assertIn("`svgf` in PSNR (31.00), specks (1.0 / 0.0), brightness (1.0100) and ms (10)",
                      words)
        self.assertIn("`best` (both) in FLIP (0.0500)", words)
        self.assertIn("`svgf` and `best` (both) in SSIM (0.9000), relMSE (0.01000), flicker (0.00500) "
                      "and MB (50)", words)

    def test_many_that_are_equal_are_counted(self):
        rows = [(name, values()) for name in "abc"]
        self.assertIn("a and 2 others in PSNR (30.00)", comparison.best_of_each(rows))

    def test_others_that_lead_are_named(self):
        rows = [("`default` (past)", values()), ("`best` (both)", values(psnr=32)),
                ("learned", values(psnr=31, flip=0.0900, ms=1))]
        self.assertEqual(comparison.where_others_lead(rows),
                         "Better than all of `default` and `best`: learned in FLIP (0.0900, not 0.1000).")
        rows[2] = ("learned", values(ms=1))
        self.assertIn("No other filter is better", comparison.where_others_lead(rows))

    def test_a_measure_that_is_missing_has_no_best(self):
        rows = [("`best` (both)", values(temporal_error=None))]
        self.assertNotIn("flicker", comparison.best_of_each(rows))
        self.assertIn("No other", comparison.where_others_lead(rows))

    def test_tally_counts_tables(self):
        first = [("a", values(psnr=31)), ("b", values(flip=0.05))]
        second = [("a", values(psnr=31)), ("b", values(psnr=30))]
        lines = comparison.tally([first, second]).splitlines()
        self.assertEqual(lines[0], "| | PSNR | FLIP | SSIM | relMSE | specks | flicker | brightness |")
        # Equal rows are both the best.
        self.assertEqual(lines[2], "| a | 2 | 1 | 2 | 2 | 2 | 2 | 2 |")
        self.assertEqual(lines[3], "| b | - | 2 | 2 | 2 | 2 | 2 | 2 |")

    def test_means_and_overview(self):
        one = [("a", values(psnr=30)), ("b", values(psnr=20))]
        two = [("a", values(psnr=32)), ("b", values(psnr=25, temporal_error=None))]
        rows = dict(comparison.means([one, two]))
        self.assertEqual(rows["a"]["psnr"], 31)
        self.assertEqual(rows["b"]["psnr"], 22.5)
        self.assertNotIn("temporal_error", rows["b"])
        self.assertEqual(comparison.overview({1: one, 4: two}, "psnr", "{:.1f}"),
                         "| | 1 spp | 4 spp |\n|---|---|---|\n| a | 30.0 | 32.0 |\n| b | 20.0 | 25.0 |")

    def test_leaders_for_each_number_of_samples(self):
        one = [("noisy", values(psnr=99)), ("`default` (past)", values(psnr=30)),
               ("`best` (both)", values(psnr=31)), ("x", values(psnr=29)), ("y", values(psnr=28))]
        four = [("`default` (past)", values(psnr=34)), ("`best` (both)", values(psnr=33)),
                ("x", values(psnr=35)), ("y", values(psnr=28))]
        psnr = comparison.MEASURES[0]
        self.assertEqual(comparison.leaders({1: one, 4: four}, psnr),
                         "Best of `default` and `best`: `best` (both) at 1 spp (31.00); `default` (past) "
                         "at 4 spp (34.00). Best of the others: x at 1 spp (29.00) and 4 spp (35.00): "
                         "another filter is better at 4 spp.")
        self.assertIn(": none of them is better.", comparison.leaders({1: one}, psnr))

    def test_judged_frames_at_the_end_are_remarked(self):
        settings = types.SimpleNamespace(frames=24, judged="8,15-16")
        self.assertEqual(comparison.later_frames(settings), "")
        settings.judged = "23-24"
        self.assertIn("there are 0 frames", comparison.later_frames(settings))

    def test_times(self):
        frame = {"read_ms": 1, "write_ms": 2, "future_ms": 3, "denoise_ms": 4}
        # 7 of 10 ms are the filter's, 2 s over both frames.
        self.assertAlmostEqual(comparison.denoise_ms({"frames": [frame, frame]}, 2.0), 700)
        self.assertEqual(comparison.command_ms('words\n{"ms_per_frame": 12}\n', 9.0, 3), 12)
        for output in ("", "words", "[1]", "{}", '{"ms_per_frame": null}'):
            self.assertEqual(comparison.command_ms(output, 9.0, 3), 3000, output)


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_exr_and_back(self):
        rng = np.random.default_rng(1)
        planes = {"R": rng.random((35, 19), np.float32), "G": np.zeros((35, 19), np.float16),
                  "direct_diffuse.second_moment.of.X": rng.random((35, 19), np.float32),
                  "id.X": rng.integers(0, 1 << 32, (35, 19), np.uint32)}
        path = self.folder / "a.exr"
        picture_files.write_exr(path, planes)
        back = picture_files.read_exr(path)
        self.assertEqual(sorted(back), sorted(planes))
        for name, plane in planes.items():
            self.assertEqual(back[name].dtype, plane.dtype)
            np.testing.assert_array_equal(back[name], plane)
        path.write_bytes(b"no EXR file")
        with self.assertRaisesRegex(ValueError, "expected an EXR file"):
            picture_files.read_exr(path)

    @unittest.skipUnless(PROGRAM, "no program is given")
    def test_stillray_reads_what_is_written(self):
        picture = np.full((8, 8), 0.5, np.float32)
        picture_files.write_exr(self.folder / "a.exr", {c: picture for c in "RGB"})
        picture_files.write_exr(self.folder / "b.exr", {c: picture * 2 for c in "RGB"})
        found = measured.compare(PROGRAM, self.folder / "b.exr", self.folder / "a.exr",
                                 self.folder / "c.json")
        self.assertAlmostEqual(found["brightness"], 2)
        # The curve takes 0.5 to 1/3 and 1 to 1/2; frame_filters.psnr is the same measure.
        self.assertAlmostEqual(found["psnr"], -20 * np.log10(1 / 6), places=4)
        colour = np.stack([picture] * 3, axis=2)
        self.assertAlmostEqual(frame_filters.psnr(2 * colour, colour), found["psnr"], places=4)

    def test_usage_of_a_process(self):
        report = self.folder / "usage.json"
        memory = 60 << 20
        output = comparison.run_measured(report, sys.executable, "-c",
                                         f"x = bytearray(b'1') * {memory}; print(len(x))")
        usage = json.loads(report.read_text())
        self.assertEqual(output.strip(), str(memory))
        self.assertGreater(usage["peak_bytes"], memory)
        self.assertLess(usage["peak_bytes"], memory + (60 << 20))
        self.assertGreater(usage["cpu_s"], 0)
        with self.assertRaises(subprocess.CalledProcessError):
            comparison.run_measured(report, sys.executable, "-c", "raise SystemExit(3)")

    @unittest.skipUnless(PROGRAM, "no program is given")
    def test_a_command_is_measured_along_the_motion_of_its_input(self):
        # The picture moves two pixels to the right: flicker is none along the motion alone.
        base = np.random.default_rng(2).random((16, 24)).astype(np.float32)
        inputs = self.folder / "inputs"
        inputs.mkdir()
        for frame in (1, 2):
            colour = np.roll(base, 2 * (frame - 1), axis=1)
            planes = {**{c: colour for c in "RGB"}, "motion.X": np.full_like(base, -2),
                      "motion.Y": np.zeros_like(base), "depth.Z": np.ones_like(base)}
            picture_files.write_exr(inputs / f"noisy.{frame:04d}.exr", planes)
            picture_files.write_exr(self.folder / f"reference.{frame:04d}.exr",
                                    {c: np.full_like(base, 0.5) for c in "RGB"})
        script = self.folder / "copy.py"
        script.write_text("import shutil, sys\n"
                          "inputs, outputs, frames = sys.argv[1:]\n"
                          "for f in frames.split(','):\n"
                          "  name = f'{int(f):04d}.exr'\n"
                          "  shutil.copy(f'{inputs}/noisy.{name}', f'{outputs}/denoised.{name}')\n"
                          "print('{\"ms_per_frame\": 5}')\n")
        sequence = comparison.Sequence("copy", self.folder, [1, 2], [1, 2], inputs / "noisy.####.exr",
                                       self.folder / "reference.####.exr", 1)
        sequence.inputs = inputs
        arguments = types.SimpleNamespace(stillray=PROGRAM)
        found, pattern = comparison.run_command(arguments, sequence, "copy",
                                                [sys.executable, script])
        self.assertEqual(found["ms"], 5)
        self.assertGreater(found["mb"], 1)
        self.assertAlmostEqual(found["temporal_error"], 0, places=6)
        self.assertTrue(pathlib.Path(str(pattern).replace("####", "0002")).exists())
        # Finished results stay, unless the command is another one.
        script.write_text("raise SystemExit(1)")
        again, _ = comparison.run_command(arguments, sequence, "copy", [sys.executable, script])
        self.assertEqual(again, found)
        with self.assertRaises(subprocess.CalledProcessError):
            comparison.run_command(arguments, sequence, "copy", [sys.executable, script, "--option"])

    def test_crops_are_where_pictures_differ(self):
        a = np.zeros((64, 96, 3), np.uint8)
        b = a.copy()
        b[41:47, 70:79] = 200
        left, top = comparison.place_of_crop([a, b], 24, 16)
        self.assertTrue(left <= 70 and left + 24 >= 79 and top <= 41 and top + 16 >= 47, (left, top))


class Filters(unittest.TestCase):
    def frame(self, **layers):
        shape = (6, 7)
        planes = {}
        for name, colour in layers.items():
            for i, letter in enumerate("XYZ" if name == "normal" else "RGB"):
                key = letter if name == "colour" else f"{name}.{letter}"
                planes[key] = np.full(shape, colour[i], np.float32)
        return planes

    def test_light_is_split_by_kind(self):
        planes = self.frame(colour=(1, 1, 1), emission=(0.1, 0.1, 0.1), albedo=(0.5, 0.5, 0.5),
                            specular_albedo=(0.2, 0.2, 0.2), direct_diffuse=(0.3, 0.3, 0.3),
                            indirect_diffuse=(0.2, 0.2, 0.2), direct_specular=(0.4, 0.4, 0.4))
        parts, kept = frame_filters.split_light(planes)
        self.assertEqual([(round(float(light[0, 0, 0]), 5), round(float(albedo[0, 0, 0]), 5))
                          for light, albedo in parts], [(0.5, 0.5), (0.4, 0.2)])
        self.assertAlmostEqual(float(kept[0, 0, 0]), 0.1, places=6)

    def test_light_of_frames_without_layers_is_the_rest(self):
        parts, _ = frame_filters.split_light(
            self.frame(colour=(1, 0.5, 0.2), background=(0.4, 0, 0.3), albedo=(0.5, 1, 1)))
        self.assertEqual(len(parts), 1)
        np.testing.assert_allclose(parts[0][0][0, 0], (0.6, 0.5, 0), atol=1e-6)

    def test_filters_restore_what_has_no_noise(self):
        # A stand-in for OpenCV that changes nothing: dividing, curves and 16 bits cancel.
        unchanged = types.SimpleNamespace(
            ximgproc=types.SimpleNamespace(jointBilateralFilter=lambda joint, source, *_: source),
            fastNlMeansDenoising=lambda source, *_: source, NORM_L1=2)
        planes = self.frame(colour=(1.6, 40, 0.1), emission=(0.1, 0, 0.1), albedo=(0.5, 0.002, 0),
                            normal=(0, 1, 0))
        for curve in ("linear", "log"):
            settings = {**frame_filters.FIRST["bilateral"], "curve": curve}
            np.testing.assert_allclose(frame_filters.bilateral(planes, settings, unchanged)[2, 3],
                                       (1.6, 40, 0.1), rtol=1e-4)
        np.testing.assert_allclose(
            frame_filters.nlm(planes, frame_filters.FIRST["nlm"], unchanged)[2, 3], (1.6, 40, 0.1),
            rtol=2e-3)

    def test_guide(self):
        planes = self.frame(colour=(1, 1, 1), normal=(0, 0, 1), albedo=(0.5, 0, 0))
        planes["depth.Z"] = np.full((6, 7), np.e, np.float32)
        planes["depth.Z"][0, 0] = np.inf
        joint = frame_filters.guide(planes, {"albedo_weight": 2, "depth_weight": 3})
        np.testing.assert_allclose(joint[1, 1], (1 + 3, 3, 1 + 3), rtol=1e-6)
        np.testing.assert_allclose(joint[0, 0], [frame_filters.FAR] * 3)

    def test_tuning_finds_the_peak(self):
        grids = {"a": [1, 2, 3], "b": [1, 2, 3, 4]}
        tried = []

        def quality(settings):
            tried.append(tuple(settings.values()))
            return -2 * abs(settings["a"] - 3) - abs(settings["b"] - settings["a"])

        # From (1, 1): a = 3 first, then b = 3, then nothing is better.
        self.assertEqual(frame_filters.tune({"a": 1, "b": 1}, grids, quality), {"a": 3, "b": 3})
        self.assertLess(len(tried), 3 * 7)

    @unittest.skipIf(frame_filters.opencv() is None, "OpenCV with ximgproc is not installed")
    def test_opencv_removes_noise_and_keeps_edges(self):
        rng = np.random.default_rng(3)
        planes = self.frame(colour=(1, 1, 1))
        shape = (32, 48)
        right = np.broadcast_to(np.arange(48) >= 24, shape)
        truth = np.where(right, 1.0, 0.2)[..., None] * np.ones(3)
        noisy = truth * rng.gamma(4, 1 / 4, (*shape, 1))
        planes = {c: noisy[..., i].astype(np.float32) for i, c in enumerate("RGB")}
        for i, letter in enumerate("XYZ"):
            planes[f"normal.{letter}"] = np.where(right, i == 0, i == 1).astype(np.float32)
        cv = frame_filters.opencv()
        before = frame_filters.psnr(noisy, truth)
        smooth = frame_filters.bilateral(planes, frame_filters.FIRST["bilateral"], cv)
        self.assertGreater(frame_filters.psnr(smooth, truth), before + 10)
        smooth = frame_filters.nlm(planes, {"strength": 0.16, "template": 5, "search": 11}, cv)
        self.assertGreater(frame_filters.psnr(smooth, truth), before + 3)


class Layers(unittest.TestCase):
    def test_standard_names(self):
        plane = np.ones((2, 2), np.float16)
        planes = {f"View.DiffCol.{c}": plane * i for i, c in enumerate("RGB")}
        planes["View.Depth.Z"] = plane * 7
        colour = {c: plane for c in "RGB"}
        out = comparison.in_standard_layers(planes, colour, [
            {"aov": "albedo", "channels": [f"View.DiffCol.{c}" for c in "RGB"]},
            {"aov": "depth", "channels": ["View.Depth.Z"]},
            {"aov": "motion", "channels": ["View.Vector.X", "View.Vector.Y"]}])
        self.assertEqual(sorted(out), ["B", "G", "R", "albedo.B", "albedo.G", "albedo.R", "depth.Z"])
        self.assertEqual(float(out["albedo.B"][0, 0]), 2)
        self.assertEqual(float(out["depth.Z"][1, 1]), 7)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
