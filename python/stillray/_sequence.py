# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Whole sequences, with light of past and future frames: of frames in memory, and of files."""

from __future__ import annotations

import os
from typing import Any, Callable, Iterable, Iterator, Mapping, Optional, Sequence, Union

from ._stillray import Denoiser, _setting_text

Path = Union[str, "os.PathLike[str]"]


_PUSH_ARGUMENTS = ("jitter", "cut", "focal_pixels")


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

        frames: an iterable of dictionaries as for Denoiser.denoise(). They may also contain
            "next_motion" and the arguments of Denoiser.push(): "jitter", "cut" and "focal_pixels"
        outputs: as for Denoiser.denoise()
        first_index: number of the first frame

    Yields the result of Denoiser.denoise() for each frame, bit-identical to `stillray denoise
    --window both`. A frame is yielded once the 16 frames after its block of 16 were taken from
    `frames`, or all frames were; up to 32 frames are held, whose memory is
    Denoiser.memory_need(). Frames still waiting in the denoiser are dropped first.
    """
    denoiser.reset()
    for index, frame in enumerate(frames, first_index):
        images = dict(frame)
        about = {key: images.pop(key) for key in _PUSH_ARGUMENTS if key in images}
        denoiser.push(images, index=index, **about)
        yield from _ready(denoiser, outputs)
    denoiser.finish()
    yield from _ready(denoiser, outputs)

def denoise_files(
    inputs: Union[Path, Iterable[Path]],
    output: Path,
    frames: str = "",
    window: str = "auto",
    spp: int = 0,
    passes: bool = False,
    alpha: str = "keep",
    preset: str = "default",
    motion: str = "auto",
    cameras: Optional[Path] = None,
    renderer: str = "auto",
    aovs: Sequence[str] = (),
    device: str = "cpu",
    threads: int = 0,
    memory_limit: int = 0,
    resume: bool = False,
    progress: Optional[Callable[[Mapping[str, Any]], Any]] = None,
    **settings: Any,
) -> list[dict[str, Any]]:
    """Denoises a sequence of EXR files, bit-identical to `stillray denoise`.

        inputs: a pattern ("in.####.exr"), a folder that holds one sequence, or files in order
        output: a pattern, or a folder that is created if needed; files keep their names and layers
        frames: "FIRST-LAST" or one number; all
        window: "both" for light of earlier and later frames, "past" for light of earlier frames;
            "auto": both if the sequence has no gap and memory is sufficient
        spp: samples per pixel of files without sample counts; 0: the number in the file, else 1
        passes: also write the denoised radiance of every light layer
        alpha: "keep" copies alpha, "denoise" filters it like a signal
        preset, settings: as for Denoiser
        motion: "file", "camera", "estimate", "auto": the source of motion, as --motion
        cameras: a JSON file with the camera of every frame, as --cameras
        renderer, aovs: the roles of layers, as --renderer and --aov
        threads: 0 for one per processor
        memory_limit: bytes; 0 for none
        resume: continue an earlier call that was stopped, and keep the state to continue this one
        progress: called after every frame with its dictionary of the result; return False to stop
            (raises stillray.Cancelled)

    Returns a dictionary per frame: "frame", "output", "restarted" and "note" (at cuts), "motion"
    ("file", "camera", "estimate"), "missing_light", times in milliseconds. Raises
    FileNotFoundError, OSError, ValueError and stillray.Error naming the file. Notes, for example
    on the window chosen by "auto", are logged at level INFO by the logger "stillray".
    """
    try:
        from . import _files
    except ImportError as error:
        raise ImportError(
            "this package of stillray denoises arrays, not files: for files use the program "
            "`stillray denoise`, or the module of the Debian package or of a build with "
            "STILLRAY_BUILD_APPS"
        ) from error
    paths = [inputs] if isinstance(inputs, (str, os.PathLike)) else list(inputs)
    texts = [(name, _setting_text(value)) for name, value in settings.items()]
    return _files.denoise_files(
        [os.fspath(path) for path in paths], os.fspath(output), frames, window, spp, passes, alpha,
        preset, texts, motion, "" if cameras is None else os.fspath(cameras), renderer, list(aovs), device, threads, memory_limit, resume, progress,
    )  # fmt: skip
