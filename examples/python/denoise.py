# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""A renderer loop in Python: a chequered wall, over which the camera pans, lit with one noisy
sample per pixel. Writes noisy.ppm and denoised.ppm of the last frame.

    python3 denoise.py [FOLDER]
"""

import pathlib
import sys

import numpy as np
import stillray

WIDTH, HEIGHT, FRAMES, PAN = 320, 180, 16, 2


def render(index: int, rng: np.random.Generator) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The images of a frame, and its converged radiance."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    u = x + PAN * index  # position on the wall
    arriving = 0.6 + 0.4 * np.sin(0.02 * u) * np.cos(0.03 * y)
    # One sample hits the light with probability 1/4, and is then weighted by 4.
    sample = np.where(rng.random((HEIGHT, WIDTH)) < 0.25, 4 * arriving, 0)
    chequered = ((u // 16 + y // 16) % 2 == 0)[..., None]
    albedo = np.where(chequered, 0.8, np.array([0.2, 0.4, 0.6])).astype(np.float32)
    normal = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    normal[..., 2] = 1
    motion = np.zeros((HEIGHT, WIDTH, 2), np.float32)
    motion[..., 0] = PAN
    frame = {
        "direct_diffuse": albedo * sample[..., None].astype(np.float32),
        "albedo": albedo,
        "normal": normal,
        "depth": np.full((HEIGHT, WIDTH), 5, np.float32),
        "motion": motion,
    }
    return frame, albedo * arriving[..., None]


def rms_error(picture: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((picture - truth) ** 2)))


def write_ppm(path: pathlib.Path, picture: np.ndarray) -> None:
    shown = np.clip(picture, 0, 1) ** (1 / 2.2) * 255 + 0.5
    path.write_bytes(b"P6\n%d %d\n255\n" % (WIDTH, HEIGHT) + shown.astype(np.uint8).tobytes())


def main() -> None:
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    denoiser = stillray.Denoiser("default")
    rng = np.random.default_rng(1)
    for index in range(FRAMES):
        frame, truth = render(index, rng)
        clean = denoiser.denoise(frame)
    noisy = frame["direct_diffuse"]
    print(f"rms error: noisy {rms_error(noisy, truth):.4f}, denoised {rms_error(clean, truth):.4f}")
    write_ppm(folder / "noisy.ppm", noisy)
    write_ppm(folder / "denoised.ppm", clean)


if __name__ == "__main__":
    main()
