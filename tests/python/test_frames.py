# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""stillray.denoise() and stillray.Sequence: whole sequences as arrays."""

import unittest

import numpy as np
import stillray

FRAMES, H, W = 5, 20, 28


def make_images(frames=FRAMES, height=H, width=W):
    rng = np.random.default_rng(3)
    normal = np.zeros((frames, height, width, 3), np.float32)
    normal[..., 2] = 1
    return {
        "direct_diffuse": rng.exponential(1, (frames, height, width, 3)).astype(np.float32),
        "albedo": np.full((frames, height, width, 3), 0.5, np.float32),
        "normal": normal,
        "depth": np.full((frames, height, width), 5, np.float32),
        "motion": np.zeros((frames, height, width, 2), np.float32),
    }


def frame_of(images, index):
    return {name: array[index] for name, array in images.items()}


def one_by_one(images, frames=range(FRAMES), **settings):
    denoiser = stillray.Denoiser(**settings)
    return np.stack([denoiser.denoise(frame_of(images, i)) for i in frames])


class DenoiseTest(unittest.TestCase):
    def test_the_past_has_the_bits_of_frames_one_by_one(self):
        images = make_images()
        clean = stillray.denoise(images, window="past", preset="svgf", sigma_l=2)
        self.assertEqual((clean.shape, clean.dtype), ((FRAMES, H, W, 3), np.float32))
        np.testing.assert_array_equal(clean, one_by_one(images, preset="svgf", sigma_l=2))

    def test_both_has_the_bits_of_denoise_sequence(self):
        images = make_images()
        frames = [frame_of(images, i) for i in range(FRAMES)]
        expected = list(stillray.denoise_sequence(stillray.Denoiser(), frames))
        for given in images, stillray.Sequence(images), frames, iter(frames):
            np.testing.assert_array_equal(stillray.denoise(given), expected)
        # The first frame has light of the later ones: its error is that of several samples.
        truth = 1.0
        first, alone = stillray.denoise(images)[0], stillray.denoise(images, window="past")[0]
        self.assertLess(np.square(first - truth).mean(), 0.7 * np.square(alone - truth).mean())

    def test_outputs_by_name(self):
        results = stillray.denoise(make_images(), outputs=["colour", "variance"])
        self.assertEqual(results["colour"].shape, (FRAMES, H, W, 3))
        self.assertEqual(results["variance"].shape, (FRAMES, H, W))
        self.assertEqual(set(results), {"colour", "variance"})

    def test_progress_and_cancelling(self):
        seen = []
        stillray.denoise(make_images(), window="past", progress=seen.append)
        self.assertEqual(seen, [1, 2, 3, 4, 5])
        with self.assertRaisesRegex(stillray.Cancelled, "after 2 frames"):
            stillray.denoise(make_images(), window="past", progress=lambda done: done < 2)

    def test_wrong_calls_name_what_is_wrong(self):
        images = make_images()

        def refused(error, pattern, *arguments, **more):
            with self.assertRaisesRegex(error, pattern):
                stillray.denoise(*arguments, **more)

        refused(ValueError, "window is 'future', expected both or past", images, window="future")
        refused(ValueError, "unknown input 'color'", {"color": images["albedo"]})
        refused(ValueError, "unknown parameter 'sigma'", images, sigma=2)
        refused(ValueError, "no frames", [])
        refused(ValueError, "no images", {})
        refused(ValueError, r"shape \(20, 28\), expected \(frames, height, width\)",
                {"depth": images["depth"][0]})
        refused(TypeError, "'depth' is a list", {"depth": [1, 2]})
        refused(TypeError, "outputs is a str, expected a list", images, outputs="colour")
        larger = frame_of(make_images(1, 24, 24), 0)
        refused(ValueError, r"frame 1: 'colour' has the shape \(24, 24, 3\), expected \(20, 28, 3\)",
                [frame_of(images, 0), larger], window="past")


class SequenceTest(unittest.TestCase):
    def test_frames_are_views(self):
        images = make_images()
        sequence = stillray.Sequence(images, jitter=np.full((FRAMES, 2), 0.25), cuts=[3])
        self.assertEqual(len(sequence), FRAMES)
        self.assertEqual(sequence.shape, (FRAMES, H, W))
        frame = sequence[-2]
        self.assertTrue(np.shares_memory(frame["depth"], images["depth"]))
        self.assertEqual((frame["jitter"], frame["cut"]), ((0.25, 0.25), True))
        self.assertEqual([f["cut"] for f in sequence], [False, False, False, True, False])
        self.assertIn("5 frames, 28x20: direct_diffuse", repr(sequence))
        with self.assertRaises(IndexError):
            sequence[FRAMES]

    def test_a_part_keeps_its_cuts_and_jitter(self):
        jitter = np.arange(2 * FRAMES).reshape(FRAMES, 2) / 20 - 0.25
        part = stillray.Sequence(make_images(), jitter, cuts=[1, 3])[2:]
        self.assertEqual((len(part), sorted(part.cuts)), (3, [1]))
        np.testing.assert_array_equal(part.jitter, np.float32(jitter[2:]))
        with self.assertRaisesRegex(ValueError, "no frames"):
            part[3:]
        with self.assertRaisesRegex(ValueError, "a step of -1"):
            part[::-1]

    def test_focal_lengths(self):
        images = make_images()
        sequence = stillray.Sequence(images, focal_pixels=40)
        self.assertEqual([frame["focal_pixels"] for frame in sequence[1:]], [40.0] * (FRAMES - 1))
        for window in "past", "both":
            clean = sequence.denoise(window=window, depth_weight="position")
            frames = stillray.Sequence.from_frames(sequence)
            again = frames.denoise(window=window, depth_weight="position")
            np.testing.assert_array_equal(clean, again)
            with self.assertRaisesRegex(ValueError, "needs the focal length"):
                stillray.denoise(images, window=window, depth_weight="position")

    def test_cuts_part_the_light(self):
        images = make_images()
        for window in "past", "both":
            clean = stillray.Sequence(images, cuts=[0, 3]).denoise(window=window)
            halves = [stillray.Sequence(images)[part].denoise(window=window)
                      for part in (slice(0, 3), slice(3, 5))]
            np.testing.assert_array_equal(clean, np.concatenate(halves))
            self.assertTrue((clean != stillray.denoise(images, window=window)).any())

    def test_from_frames(self):
        images = make_images()
        frames = [dict(frame_of(images, i), jitter=(0.1, 0), cut=i == 2) for i in range(FRAMES)]
        sequence = stillray.Sequence.from_frames(frames)
        self.assertEqual(sequence.cuts, {2})
        for name, array in images.items():
            np.testing.assert_array_equal(sequence.images[name], array)
        np.testing.assert_array_equal(sequence.denoise(), stillray.denoise(frames))
        plain = stillray.Sequence.from_frames([frame_of(images, 0)])
        self.assertEqual((plain.cuts, plain.jitter), (None, None))
        del frames[1]["depth"]
        with self.assertRaisesRegex(ValueError, "frame 1 has the images"):
            stillray.Sequence.from_frames(frames)

    def test_sizes_must_agree(self):
        images = make_images()
        images["depth"] = images["depth"][:, :-1]
        with self.assertRaisesRegex(ValueError, r"'depth' has the shape \(5, 19, 28\), expected 5 frames"):
            stillray.Sequence(images)
        with self.assertRaisesRegex(ValueError, r"jitter has the shape \(2,\), expected \(5, 2\)"):
            stillray.Sequence(make_images(), jitter=(0, 0))
        with self.assertRaisesRegex(ValueError, "cut 5 is not among the 5 frames"):
            stillray.Sequence(make_images(), cuts=[5])


if __name__ == "__main__":
    unittest.main()
