# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The Python module: arrays of every layout, errors, history, hints and help."""

import ast
import pathlib
import pydoc
import threading
import unittest
import warnings

import numpy as np
import stillray

H, W = 24, 36


def make_frame(index, height=H, width=W):
    rng = np.random.default_rng(index)
    depth = np.full((height, width), 5, np.float32)
    depth[:, width // 2 :] = 9
    normal = np.zeros((height, width, 3), np.float32)
    normal[..., 2] = 1
    motion = np.zeros((height, width, 2), np.float32)
    motion[..., 0] = 1
    return {
        "direct_diffuse": rng.exponential(1, (height, width, 3)).astype(np.float32),
        "indirect_diffuse": rng.exponential(0.3, (height, width, 3)).astype(np.float32),
        "albedo": np.full((height, width, 3), 0.5, np.float32),
        "normal": normal,
        "depth": depth,
        "motion": motion,
        "id": (depth > 7).astype(np.uint32) + 1,
    }


def run(frames, change=lambda a: a, **settings):
    denoiser = stillray.Denoiser(**settings)
    return [denoiser.denoise({k: change(v) for k, v in f.items()}) for f in frames]


def planar(array):
    """The same values, one plane per channel in memory."""
    if array.ndim == 2:
        return np.asfortranarray(array)
    return np.moveaxis(np.ascontiguousarray(np.moveaxis(array, 2, 0)), 0, 2)


def part_of_larger(array):
    larger = np.full((array.shape[0] + 5, 2 * array.shape[1] + 3) + array.shape[2:], 7, array.dtype)
    view = larger[2:-3, 1:-2:2]
    view[...] = array
    return view


def camera_at(x):
    """Looks along -z, 90 degrees across."""
    to_camera = np.eye(4)
    to_camera[0, 3] = -x
    projection = np.array(
        [[1, 0, 0, 0], [0, W / H, 0, 0], [0, 0, -1.002, -0.2], [0, 0, -1, 0]], np.float64
    )
    return {"world_to_camera": to_camera, "projection": projection.ravel().tolist(), "frame": 3}


class ReflectionsTest(unittest.TestCase):
    def test_images_lie_behind_the_mirror_and_move_less(self):
        frame = make_frame(0)
        frame["roughness"] = np.zeros((H, W), np.float32)
        hits = np.full((H, W), 4, np.float32)
        hits[0, :3] = 0, np.nan, np.inf
        made = stillray.reflections_from_hits(frame, hits, camera_at(0.1), camera_at(0))
        y, x = np.mgrid[0:H, 0:W] + 0.5
        secant = np.sqrt(1 + ((x - W / 2) ** 2 + (y - H / 2) ** 2) / (W / 2) ** 2)
        depth = frame["depth"] + 4 / secant
        np.testing.assert_allclose(made["reflection_depth"][1:], depth[1:], rtol=1e-5)
        np.testing.assert_allclose(
            made["reflection_motion"][1:, :, 0], 0.1 * W / 2 / depth[1:], rtol=1e-4
        )
        np.testing.assert_allclose(made["reflection_motion"][..., 1], 0, atol=1e-5)
        self.assertEqual(made["reflection_depth"][0, :3].tolist(), [0, 0, np.inf])
        self.assertEqual(made["reflection_motion"][0, 2].tolist(), [0, 0])
        denoiser = stillray.Denoiser()
        denoiser.denoise({**frame, "direct_specular": frame["direct_diffuse"], **made})

    def test_errors(self):
        hits = np.ones((H, W), np.float32)
        camera = camera_at(0)
        for frame, distance, now, message in (
            ({}, hits, camera, "image 'depth' is not given"),
            (make_frame(0), hits[1:], camera, "image 'hit_distance' is 36x23, expected 36x24"),
            (make_frame(0), hits, {"projection": [1]}, "the camera has no 'world_to_camera'"),
            (make_frame(0), hits, {**camera, "projection": [1]}, "has 1 numbers, expected 16"),
            (make_frame(0), hits, {**camera, "projection": np.eye(4)}, "no perspective"),
        ):
            with self.assertRaisesRegex(ValueError, message):
                stillray.reflections_from_hits(frame, distance, now, camera)


class LayoutTest(unittest.TestCase):
    def test_layouts_give_the_same_bits(self):
        frames = [make_frame(i) for i in range(3)]
        expected = run(frames)
        for change in planar, part_of_larger, lambda a: a[::-1].copy()[::-1]:
            for got, want in zip(run(frames, change), expected):
                np.testing.assert_array_equal(got, want)

    def test_half_is_the_rounded_float(self):
        frames = [make_frame(i) for i in range(2)]
        halves = [
            {k: v if k == "id" else v.astype(np.float16) for k, v in f.items()} for f in frames
        ]
        widened = [
            {k: v if k == "id" else v.astype(np.float32) for k, v in f.items()} for f in halves
        ]
        for got, want in zip(run(halves), run(widened)):
            np.testing.assert_array_equal(got, want)

    def test_result(self):
        (clean,) = run([make_frame(0)])
        self.assertEqual((clean.shape, clean.dtype), ((H, W, 3), np.float32))
        noisy = make_frame(0)["direct_diffuse"]
        self.assertLess(clean.std(), 0.5 * noisy.std())

    def test_out_is_written_in_place(self):
        expected = run([make_frame(0)])[0]
        out = np.zeros((H, W, 4), np.float32)
        returned = stillray.Denoiser().denoise(make_frame(0), out={"colour": out})
        self.assertIs(returned, out)
        np.testing.assert_array_equal(out[..., :3], expected)
        self.assertTrue((out[..., 3] == 0).all())
        frame = make_frame(0)
        stillray.Denoiser().denoise(frame, out={"colour": frame["direct_diffuse"]})
        np.testing.assert_array_equal(frame["direct_diffuse"], expected)

    def test_half_out_is_rounded(self):
        expected = run([make_frame(0)])[0]
        out = np.zeros((H, W, 3), np.float16)
        stillray.Denoiser().denoise(make_frame(0), out={"colour": out})
        np.testing.assert_array_equal(out, expected.astype(np.float16))

    def test_outputs_by_name(self):
        denoiser = stillray.Denoiser()
        got = denoiser.denoise(make_frame(0), outputs=denoiser.outputs)
        self.assertEqual(set(got), set(denoiser.outputs))
        self.assertEqual(got["variance"].shape, (H, W))
        self.assertTrue((got["history_length"] == 1).all())
        self.assertEqual(got["noisy.direct"].shape, (H, W, 3))

    def test_input_arrays_are_not_kept(self):
        denoiser = stillray.Denoiser()
        denoiser.denoise(make_frame(0))
        with self.assertRaisesRegex(ValueError, "no input is set"):
            denoiser.denoise({})


class ErrorTest(unittest.TestCase):
    def expect(self, error, pattern, frame=None, **arguments):
        denoiser = stillray.Denoiser()
        with self.assertRaisesRegex(error, pattern):
            denoiser.denoise(make_frame(0) if frame is None else frame, **arguments)
        denoiser.denoise(make_frame(0))  # is not harmed

    def changed(self, **changes):
        return {**make_frame(0), **changes}

    def test_types(self):
        self.expect(TypeError, "'depth' is of type float64", self.changed(depth=np.ones((H, W))))
        self.expect(TypeError, "'depth' is a list", self.changed(depth=[1.0]))
        self.expect(
            TypeError, "'depth' is of type >f4", self.changed(depth=np.ones((H, W), ">f4"))
        )
        self.expect(
            ValueError, "'id' has the wrong format", self.changed(id=np.ones((H, W), np.float32))
        )

    def test_shapes(self):
        for shape in [(H,), (H, W, 1, 1), ()]:
            self.expect(
                ValueError, "'depth' has the shape", self.changed(depth=np.ones(shape, np.float32))
            )
        self.expect(
            ValueError, "'depth' is 36x23", self.changed(depth=np.ones((23, 36), np.float32))
        )
        self.expect(ValueError, "'depth' is 0x24", self.changed(depth=np.ones((H, 0), np.float32)))
        self.expect(
            ValueError, "2 channels", self.changed(albedo=np.ones((H, W, 2), np.float32))
        )
        view = np.broadcast_to(np.float32(1), (H, W))
        self.expect(ValueError, "broadcast", self.changed(depth=view))

    def test_missing_and_unknown(self):
        denoiser = stillray.Denoiser()
        denoiser.denoise(make_frame(0))
        with self.assertRaisesRegex(ValueError, "'motion' is missing, expected 36x24: 'temporal'"):
            denoiser.denoise(self.changed(motion=None))
        self.expect(ValueError, "unknown input 'color'", self.changed(color=np.ones((H, W, 3), "f4")))
        self.expect(ValueError, "unknown output 'color'", outputs=["color"])
        self.expect(ValueError, "jitter", jitter=(0.7, 0))
        self.expect(TypeError, "outputs is a str, expected a list", outputs="colour")
        self.expect(TypeError, "outputs is a list, expected a list of names", outputs=[1, 2])
        self.expect(TypeError, "the progress function returned a str, expected True",
                    progress=lambda fraction: "on")

    def test_positions_need_the_focal_length(self):
        denoiser = stillray.Denoiser(depth_weight="position")
        with self.assertRaisesRegex(ValueError, "needs the focal length of the frame"):
            denoiser.denoise(make_frame(0))
        self.expect(ValueError, "focal_pixels is -1", focal_pixels=-1)
        near = denoiser.denoise(make_frame(0), focal_pixels=10)
        denoiser.reset()
        self.assertTrue((near != denoiser.denoise(make_frame(0), focal_pixels=100)).any())

    def test_a_colour_alone_is_enough(self):
        frame = make_frame(0)
        alone = {"direct_diffuse": frame["direct_diffuse"]}
        flat = dict(
            alone,
            depth=np.ones((H, W), np.float32),
            normal=np.tile(np.float32([0, 0, 1]), (H, W, 1)),
            albedo=np.ones((H, W, 3), np.float32),
            motion=np.zeros((H, W, 2), np.float32),
        )
        np.testing.assert_array_equal(
            stillray.Denoiser().denoise(alone), stillray.Denoiser().denoise(flat)
        )

    def test_normals_that_are_all_zero_are_a_warning(self):
        frame = self.changed(normal=np.zeros((H, W, 3), np.float32))
        with self.assertWarnsRegex(RuntimeWarning, "'normal' is zero at every surface"):
            stillray.Denoiser().denoise(frame)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            stillray.Denoiser().denoise(make_frame(0))
            with self.assertRaises(RuntimeWarning):
                stillray.Denoiser().denoise(frame)

    def test_read_only_out(self):
        out = np.zeros((H, W, 3), np.float32)
        out.flags.writeable = False
        self.expect(ValueError, "read-only", out={"colour": out})

    def test_settings(self):
        with self.assertRaisesRegex(ValueError, "unknown parameter 'alpha'"):
            stillray.Denoiser(alpha=0.1)
        with self.assertRaisesRegex(ValueError, "'nicest'"):
            stillray.Denoiser("nicest")
        with self.assertRaisesRegex(ValueError, "threads is -1"):
            stillray.Denoiser(threads=-1)

    def test_damaged_history(self):
        with self.assertRaises(stillray.Error):
            stillray.Denoiser().restore_history(b"nonsense")


class SequenceTest(unittest.TestCase):
    def test_confidence(self):
        frames = [make_frame(i) for i in range(4)]

        def last(**more):
            denoiser = stillray.Denoiser()
            for frame in frames[:3]:
                denoiser.denoise(frame)
            return denoiser.denoise({**frames[3], **more}, outputs=["colour", "history_length"])

        def filled(value, dtype=np.float32):
            return np.full((H, W), value, dtype)

        without = last()
        for dtype in np.float32, np.float16:
            whole = last(confidence=filled(1, dtype))
            np.testing.assert_array_equal(whole["colour"], without["colour"])
            none = last(confidence=filled(0, dtype))
            np.testing.assert_array_equal(none["history_length"], filled(1))
        half = last(confidence=filled(0.5))["history_length"][H // 2, W // 4]
        self.assertLess(half, without["history_length"][H // 2, W // 4])
        self.assertGreater(half, 1)
        with self.assertRaisesRegex(ValueError, "'confidence'"):
            last(confidence=np.ones((H, W + 1), np.float32))

    def test_settings_as_python_values(self):
        denoiser = stillray.Denoiser("svgf", alpha_min=0.25, steps=[1, 2, 4], demodulate=False)
        denoiser.set(kernel="3x3", feedback=2)
        settings = denoiser.settings
        self.assertEqual(settings["alpha_min"], "0.25")
        self.assertEqual(settings["steps"], "1,2,4")
        self.assertEqual(settings["demodulate"], "off")
        self.assertEqual(settings["kernel"], "3x3")
        denoiser.set_preset("default")
        self.assertEqual(denoiser.settings, stillray.Denoiser().settings)

    def test_history_continues(self):
        denoiser = stillray.Denoiser()
        denoiser.denoise(make_frame(0))
        later = stillray.Denoiser()
        later.restore_history(denoiser.save_history())
        second = denoiser.denoise(make_frame(1))
        np.testing.assert_array_equal(later.denoise(make_frame(1)), second)
        denoiser.reset()
        self.assertTrue((denoiser.denoise(make_frame(1)) != second).any())

    def test_progress_and_cancel(self):
        denoiser = stillray.Denoiser()
        seen = []
        denoiser.denoise(make_frame(0), progress=seen.append)
        self.assertEqual((seen[0], seen[-1]), (0.0, 1.0))
        with self.assertRaises(stillray.Cancelled):
            denoiser.denoise(make_frame(1), progress=lambda part: False)
        with self.assertRaises(ZeroDivisionError):
            denoiser.denoise(make_frame(1), progress=lambda part: 1 // 0)
        denoiser.denoise(make_frame(1))

    def test_use_within_progress_is_refused(self):
        denoiser = stillray.Denoiser()
        with self.assertRaisesRegex(stillray.Error, "at work"):
            denoiser.denoise(make_frame(0), progress=lambda part: denoiser.reset())
        denoiser.denoise(make_frame(0))

    def test_threads(self):
        expected = run([make_frame(i) for i in range(3)])
        results = [None] * 3

        def work(i):
            results[i] = run([make_frame(j) for j in range(3)], threads=i)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result in results:
            for got, want in zip(result, expected):
                np.testing.assert_array_equal(got, want)

    def test_device(self):
        self.assertEqual(stillray.Denoiser().device, "cpu")
        with self.assertRaisesRegex(ValueError, "device is 'gpu', expected auto, cpu, vulkan or"):
            stillray.Denoiser(device="gpu")
        chosen = stillray.Denoiser(device="auto")
        self.assertRegex(chosen.device, "^(cpu$|vulkan:)")
        try:
            denoiser = stillray.Denoiser(device="vulkan")
        except (stillray.Error, ValueError) as error:
            self.skipTest(str(error))
        self.assertRegex(denoiser.device, "^vulkan:[0-9]+: .+")
        frames = [make_frame(i) for i in range(2)]
        for got, want in zip([denoiser.denoise(f) for f in frames], run(frames)):
            self.assertLess(np.abs(got - want).mean(), 0.02 * want.mean())
        later = stillray.Denoiser(device="vulkan")
        later.restore_history(denoiser.save_history())
        frame = make_frame(2)
        self.assertTrue((later.denoise(frame) == denoiser.denoise(frame)).all())

    def test_statistics(self):
        frame = make_frame(0)
        frame["direct_diffuse"][3, 4] = np.nan
        denoiser = stillray.Denoiser()
        self.assertTrue(np.isfinite(denoiser.denoise(frame)).all())
        self.assertGreater(denoiser.statistics["non_finite"], 0)
        self.assertGreater(denoiser.statistics["memory_bytes"], 0)


class DocumentationTest(unittest.TestCase):
    def test_tables(self):
        self.assertIn("default", stillray.presets())
        self.assertIn("pixels", stillray.inputs()["motion"].lower())
        by_name = {p.name: p for p in stillray.parameters()}
        self.assertEqual(by_name["alpha_min"].type, "float")
        self.assertIn("svgf", by_name["wavelet"].choices)
        for parameter in by_name.values():
            stillray.Denoiser(**{parameter.name: parameter.default})

    def test_help_reads_well(self):
        text = pydoc.plain(pydoc.render_doc(stillray))
        for expected in "Denoises the next frame", "outputs:", "save_history", "ValueError":
            self.assertIn(expected, text)
        for name in "denoise", "reset", "set", "save_history", "restore_history":
            self.assertTrue(getattr(stillray.Denoiser, name).__doc__)

    def test_hints_name_what_there_is(self):
        package = pathlib.Path(stillray.__file__).parent
        self.assertTrue((package / "py.typed").exists())
        tree = ast.parse((package / "_stillray.pyi").read_text())
        hinted = {
            node.name: node
            for node in tree.body
            if isinstance(node, (ast.ClassDef, ast.FunctionDef))
        }
        in_python = {"Sequence", "__version__", "denoise", "denoise_files", "denoise_sequence"}
        self.assertEqual(set(hinted) | in_python, set(stillray.__all__))
        for name in "Denoiser", "Parameter":
            methods = {n.name for n in hinted[name].body if isinstance(n, ast.FunctionDef)}
            real = {m for m in vars(getattr(stillray, name)) if not m.startswith("_")}
            self.assertEqual(methods - {"__init__"}, real)


if __name__ == "__main__":
    unittest.main()
