# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Sequences in memory, denoised with light of the past and of the future."""

from typing import Any, Iterable, Iterator, Mapping, Optional, Sequence

from ._stillray import Denoiser


def _ready(denoiser: Denoiser, outputs: Optional[Sequence[str]]) -> Iterator[Any]:
    while (clean := denoiser.pull(outputs)) is not None:
        yield clean


def denoise_sequence(
    denoiser: Denoiser,
    frames: Iterable[Mapping[str, Any]],
    outputs: Optional[Sequence[str]] = None,
    first_index: int = 0,
) -> Iterator[Any]:
    """Denoises the frames of a sequence with light of the frames before and after each.

        frames: an iterable of dictionaries as for Denoiser.denoise(). Beside arrays they may hold
            "next_motion" and the arguments of Denoiser.push(): "jitter" and "cut"
        outputs: as for Denoiser.denoise()
        first_index: number of the first frame

    Yields what denoise() returns, one frame after the other, with the bits of `stillray denoise
    --window both`. A frame comes once the 16 frames behind its block of 16 were taken from
    `frames`, or all were; up to 32 frames are held, for which Denoiser.memory_need() gives the
    bytes. Frames of the denoiser that wait from earlier calls are dropped.
    """
    denoiser.reset()
    for index, frame in enumerate(frames, first_index):
        images = dict(frame)
        about = {key: images.pop(key) for key in ("jitter", "cut") if key in images}
        denoiser.push(images, index=index, **about)
        yield from _ready(denoiser, outputs)
    denoiser.finish()
    yield from _ready(denoiser, outputs)
