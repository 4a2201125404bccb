# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Sequences with light of past and future: the bits of `stillray denoise --window both`, and the
calls that they are made of. STILLRAY_PROGRAM names the program."""

import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np
import stillray

FRAMES, W, H = 36, 48, 32
EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/python/denoise_sequence.py"


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def undo_prediction(packed):
    """Bytes as the ZIP compression of OpenEXR stores them: differences, even bytes first."""
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    raw = ((np.cumsum(raw) - 128 * np.arange(raw.size)) & 255).astype(np.uint8)
    half = (raw.size + 1) // 2
    out = np.empty_like(raw)
    out[0::2], out[1::2] = raw[:half], raw[half:]
    return out.tobytes()


def channels_of(data):
    channels, at = [], 0
    while data[at] != 0:
        name, at = text_at(data, at)
        channels.append((name, ("<u4", "<f2", "<f4")[struct.unpack_from("<i", data, at)[0]]))
        at += 16
    return channels


def read_exr(path):
    """Channels and attributes of a scanline file with ZIP compression, as the program writes."""
    data = pathlib.Path(path).read_bytes()
    attributes, at = {}, 8
    while data[at] != 0:
        name, at = text_at(data, at)
        _, at = text_at(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    assert attributes["compression"] == b"\3", "not ZIP"
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = channels_of(attributes["channels"])
    planes = {name: np.empty((height, width), dtype) for name, dtype in channels}
    row_bytes = sum(width * np.dtype(dtype).itemsize for _, dtype in channels)
    for (block,) in struct.iter_unpack("<Q", data[at + 1 : at + 1 + 8 * ((height + 15) // 16)]):
        y, size = struct.unpack_from("<ii", data, block)
        rows = min(16, height - (y - y0))
        packed = data[block + 8 : block + 8 + size]
        pixels = packed if size == rows * row_bytes else undo_prediction(packed)
        read = 0
        for row in range(y - y0, y - y0 + rows):
            for name, dtype in channels:
                planes[name][row] = np.frombuffer(pixels, dtype, width, read)
                read += width * np.dtype(dtype).itemsize
    return planes, attributes


def stack(planes, layer, components):
    return np.stack([planes[layer + c] for c in components], axis=-1)


def unit(normal):
    """Normals as the program reads them: of unit length, in single precision."""
    x, y, z = np.moveaxis(normal, 2, 0)
    squared = x * x + y * y + z * z
    scale = np.float32(1) / np.sqrt(np.maximum(squared, np.float32(1e-4)))
    return np.where((squared < 1e-4)[..., None], np.float32(0), normal * scale[..., None])


def read_frame(path):
    planes, attributes = read_exr(path)
    layers = {"motion": "XY", "normal": "XYZ"}
    for name in "albedo specular_albedo transmission_albedo emission background".split():
        layers[name] = "RGB"
    for name in "diffuse specular transmission".split():
        layers["direct_" + name] = layers["indirect_" + name] = "RGB"
    frame = {name: stack(planes, name + ".", c) for name, c in layers.items()}
    frame["normal"] = unit(frame["normal"])
    frame["depth"] = planes["depth.Z"]
    frame["roughness"] = planes["roughness.X"]
    frame["id"] = planes["id.X"]
    for image in ("reflection_", "refraction_"):
        for name, components in {"normal": "XYZ", "albedo": "RGB", "motion": "XY"}.items():
            frame[image + name] = stack(planes, f"{image}{name}.", components)
        frame[image + "normal"] = unit(frame[image + "normal"])
        frame[image + "depth"] = planes[image + "depth.Z"]
        frame[image + "id"] = planes[image + "id.X"]
    frame["jitter"] = tuple(float(v) for v in attributes["jitter"].decode().split())
    return frame


def make_frame(index):
    rng = np.random.default_rng(index)
    return {
        "direct_diffuse": rng.exponential(1, (H, W, 3)).astype(np.float32),
        "depth": np.full((H, W), 5, np.float32),
        "motion": np.zeros((H, W, 2), np.float32),
    }


class CommandLineTest(unittest.TestCase):
    @unittest.skipUnless("STILLRAY_PROGRAM" in os.environ, "no program was built")
    def test_a_rendered_sequence_gets_the_bits_of_the_command_line(self):
        program = os.environ["STILLRAY_PROGRAM"]
        with tempfile.TemporaryDirectory() as folder:

            def run(*arguments):
                done = subprocess.run([program, *arguments], capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)

            run("render", "builtin:spheres", "-o", folder + "/in", "--size", f"{W}x{H}",
                "--frames", f"1-{FRAMES}", "--format", "exr", "--save-inputs", "--float",
                "--device", "cpu")  # fmt: skip
            run("denoise", folder + "/in/noisy.####.exr", "-o", folder + "/out/f.####.exr",
                "--window", "both", "--device", "cpu")  # fmt: skip
            frames = (read_frame(f"{folder}/in/noisy.{i:04}.exr") for i in range(1, FRAMES + 1))
            done = 0
            for clean in stillray.denoise_sequence(stillray.Denoiser(), frames, first_index=1):
                done += 1
                expected = stack(read_exr(f"{folder}/out/f.{done:04}.exr")[0], "", "RGB")
                self.assertEqual(clean.tobytes(), expected.tobytes(), f"frame {done}")
            self.assertEqual(done, FRAMES)


class CallsTest(unittest.TestCase):
    def test_frames_wait_until_their_future_is_known(self):
        denoiser = stillray.Denoiser(antialias="off")
        for index in range(32):
            self.assertIsNone(denoiser.pull())
            denoiser.push(make_frame(index))
        self.assertEqual(denoiser.waiting, 32)
        pictures = []
        while (clean := denoiser.pull()) is not None:
            pictures.append(clean)
        self.assertEqual((len(pictures), denoiser.waiting), (16, 16))
        denoiser.finish()
        self.assertEqual(denoiser.pull().shape, (H, W, 3))
        denoiser.reset()
        self.assertEqual(denoiser.waiting, 0)

        sequence = stillray.denoise_sequence(denoiser, map(make_frame, range(40)))
        for expected in pictures[:8]:  # of blocks that saw the same frames
            self.assertEqual(next(sequence).tobytes(), expected.tobytes())
        sequence.close()

    def test_outputs_and_results_of_ones_own(self):
        denoiser = stillray.Denoiser()
        for index in range(2):
            denoiser.push(make_frame(index))
        denoiser.finish()
        picture = np.zeros((H, W, 3), np.float16)
        results = denoiser.pull(outputs=["colour", "variance"], out={"colour": picture})
        self.assertIs(results["colour"], picture)
        self.assertGreater(float(picture.mean()), 0.5)
        self.assertEqual(results["variance"].shape, (H, W))

    def test_a_cut_ends_the_sharing_of_light(self):
        alone, cut, continued = (
            list(stillray.denoise_sequence(stillray.Denoiser(), frames))[-1]
            for frames in (
                [make_frame(1)],
                [make_frame(0), {**make_frame(1), "cut": True}],
                [make_frame(0), {**make_frame(1), "cut": False}],
            )
        )
        self.assertEqual(alone.tobytes(), cut.tobytes())
        self.assertNotEqual(alone.tobytes(), continued.tobytes())

    def test_cancelling_loses_nothing(self):
        expected = list(stillray.denoise_sequence(stillray.Denoiser(), map(make_frame, range(3))))
        denoiser = stillray.Denoiser()
        for index in range(3):
            denoiser.push(make_frame(index))
        denoiser.finish()

        def stop(fraction):
            raise KeyError(fraction)

        with self.assertRaises(stillray.Cancelled):
            denoiser.pull(progress=lambda fraction: False)
        with self.assertRaises(KeyError):
            denoiser.pull(progress=stop)
        self.assertEqual(denoiser.waiting, 3)
        for picture in expected:
            self.assertEqual(denoiser.pull().tobytes(), picture.tobytes())

    def test_the_memory_need_is_known_beforehand(self):
        denoiser = stillray.Denoiser()
        need = denoiser.memory_need(make_frame(0))
        parts = need["denoisers"] + 32 * need["per_frame"] + 16 * need["per_future"]
        self.assertEqual(need["most"], parts)
        denoiser.push(make_frame(0))
        self.assertGreaterEqual(denoiser.statistics["memory_bytes"], need["per_frame"])

    def test_wrong_frames_are_refused(self):
        denoiser = stillray.Denoiser()
        denoiser.push(make_frame(0))
        frame = make_frame(1)
        del frame["motion"]
        with self.assertRaisesRegex(ValueError, "frame 1: image 'motion' is missing"):
            denoiser.push(frame)
        with self.assertRaisesRegex(ValueError, "while frames wait"):
            denoiser.denoise(make_frame(1))
        self.assertEqual(denoiser.waiting, 1)


class ExampleTest(unittest.TestCase):
    def test_example_denoises_the_first_frame(self):
        run = subprocess.run([sys.executable, "-B", str(EXAMPLE)], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("40 frames", run.stdout)
        noisy, denoised = map(float, [word.strip(",") for word in run.stdout.split()
                                      if word.count(".") == 1 and word[0] == "0"])  # fmt: skip
        self.assertLess(6 * denoised, noisy)


if __name__ == "__main__":
    unittest.main()
