# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Denoises a sequence with past and future frames: the camera pans over a wall that is lit with one
noisy sample per pixel. Prints the error of the first frame, which has no past.

    python3 denoise_sequence.py
"""

import numpy as np
import stillray

WIDTH, HEIGHT, FRAMES, PAN = 320, 180, 40, 2
ALBEDO = np.array([0.3, 0.5, 0.7], np.float32)


def truth(index: int) -> np.ndarray:
    """The converged radiance of a frame."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH].astype(np.float32)
    arriving = 0.6 + 0.4 * np.sin(0.02 * (x + PAN * index)) * np.cos(0.03 * y)
    return (arriving[..., None] * ALBEDO).astype(np.float32)


def render(index: int) -> dict[str, np.ndarray]:
    lit = np.random.default_rng(index).random((HEIGHT, WIDTH, 1)) < 0.25
    motion = np.zeros((HEIGHT, WIDTH, 2), np.float32)
    motion[..., 0] = PAN
    normal = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    normal[..., 2] = 1
    return {
        "direct_diffuse": np.where(lit, 4 * truth(index), 0),
        "albedo": np.broadcast_to(ALBEDO, (HEIGHT, WIDTH, 3)).copy(),
        "normal": normal,
        "depth": np.full((HEIGHT, WIDTH), 5, np.float32),
        "motion": motion,
    }


def rms_error(picture: np.ndarray, index: int) -> float:
    return float(np.sqrt(np.mean((picture - truth(index)) ** 2)))


def main() -> None:
    denoiser = stillray.Denoiser("default")
    first = render(0)
    print(f"memory: {denoiser.memory_need(first)['most'] / 1e6:.0f} MB at most")
    frames = (render(index) for index in range(FRAMES))  # rendered on demand
    for index, clean in enumerate(stillray.denoise_sequence(denoiser, frames)):
        if index == 0:
            noisy = rms_error(first["direct_diffuse"], 0)
            print(f"rms error: noisy {noisy:.4f}, denoised {rms_error(clean, 0):.4f}")
    print(f"{index + 1} frames")


if __name__ == "__main__":
    main()
