# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Whole sequences in memory: arrays of all frames in, arrays of all frames out."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, Iterator, List, Mapping, Optional, Union

import numpy as np

from ._sequence import denoise_sequence
from ._stillray import Cancelled, Denoiser


class Sequence:
    """The frames of a sequence, as one array per image with the frame's number as first axis.

        images: arrays by name, see stillray.inputs(), such as "direct_diffuse" of the shape
            (frames, height, width, 3) and "depth" of (frames, height, width); also "next_motion"
        jitter: one (x, y) per frame, in pixels, as for Denoiser.denoise(); None: pixel centres
        cuts: indices of the frames that begin a shot; None: cuts are detected
        focal_pixels: one number for all frames, or one per frame, as for Denoiser.denoise(); None:
            unknown

    sequence[3] is a frame for Denoiser.denoise(), sequence[8:16] a Sequence; both are views of
    the memory of the sequence. Raises ValueError naming the image whose size differs.
    """

    def __init__(
        self,
        images: Mapping[str, np.ndarray],
        jitter: Optional[Any] = None,
        cuts: Optional[Iterable[int]] = None,
        focal_pixels: Optional[Any] = None,
    ) -> None:
        self.images: Dict[str, np.ndarray] = {k: v for k, v in images.items() if v is not None}
        if not self.images:
            raise ValueError("the sequence has no images")
        for name, array in self.images.items():
            _check_stack(name, array)
        first, stack = next(iter(self.images.items()))
        self.shape = stack.shape[:3]
        for name, array in self.images.items():
            if array.shape[:3] != self.shape:
                raise ValueError(
                    "image '%s' has the shape %s, expected %d frames of (%d, %d) as '%s'"
                    % ((name, array.shape) + self.shape + (first,))
                )
        self.jitter = None if jitter is None else np.asarray(jitter, np.float32)
        if self.jitter is not None and self.jitter.shape != (len(self), 2):
            raise ValueError(
                "jitter has the shape %s, expected (%d, 2)" % (self.jitter.shape, len(self))
            )
        self.focal_pixels = None
        if focal_pixels is not None:
            self.focal_pixels = np.broadcast_to(np.asarray(focal_pixels, np.float32), len(self))
        self.cuts = None if cuts is None else frozenset(int(cut) for cut in cuts)
        for cut in self.cuts or ():
            if not 0 <= cut < len(self):
                raise ValueError("cut %d is not among the %d frames" % (cut, len(self)))

    @classmethod
    def from_frames(cls, frames: Iterable[Mapping[str, Any]]) -> "Sequence":
        """Stacks frames, given as for denoise_sequence(), with "jitter", "cut" and
        "focal_pixels"."""
        listed = [dict(frame) for frame in frames]
        jitter = [frame.pop("jitter", (0.0, 0.0)) for frame in listed]
        focal_pixels = [frame.pop("focal_pixels", 0.0) for frame in listed]
        marks = [frame.pop("cut", None) for frame in listed]
        for index, frame in enumerate(listed):
            if frame.keys() != listed[0].keys():
                raise ValueError(
                    "frame %d has the images %s, expected %s as frame 0"
                    % (index, sorted(frame), sorted(listed[0]))
                )
        if not listed:
            raise ValueError("the sequence has no frames")
        images = {name: _stack(name, [frame[name] for frame in listed]) for name in listed[0]}
        cuts = None if all(mark is None for mark in marks) else [i for i, m in enumerate(marks) if m]
        return cls(
            images,
            jitter if np.any(jitter) else None,
            cuts,
            focal_pixels if np.any(focal_pixels) else None,
        )

    def __len__(self) -> int:
        return int(self.shape[0])

    def __getitem__(self, index: Union[int, slice]) -> Any:
        if isinstance(index, slice):
            return self._part(range(len(self))[index], index)
        number = range(len(self))[index]  # counts from the end, too; IndexError beyond it
        frame: Dict[str, Any] = {name: array[number] for name, array in self.images.items()}
        if self.jitter is not None:
            frame["jitter"] = (float(self.jitter[number, 0]), float(self.jitter[number, 1]))
        if self.focal_pixels is not None:
            frame["focal_pixels"] = float(self.focal_pixels[number])
        if self.cuts is not None:
            frame["cut"] = number in self.cuts
        return frame

    def __iter__(self) -> Iterator[Dict[str, Any]]:
        return (self[number] for number in range(len(self)))

    def __repr__(self) -> str:
        return "<Sequence of %d frames, %dx%d: %s>" % (
            len(self),
            self.shape[2],
            self.shape[1],
            ", ".join(self.images),
        )

    def denoise(self, **arguments: Any) -> Any:
        """stillray.denoise(self, ...)"""
        return denoise(self, **arguments)

    def _part(self, numbers: range, index: slice) -> "Sequence":
        if numbers.step != 1:
            raise ValueError("a step of %d: motion leads from each frame to the next" % numbers.step)
        if not numbers:
            raise ValueError("the part %s has no frames" % (index,))
        cuts = None if self.cuts is None else [c - numbers.start for c in self.cuts if c in numbers]
        jitter = None if self.jitter is None else self.jitter[index]
        focal = None if self.focal_pixels is None else self.focal_pixels[index]
        return Sequence(
            {name: array[index] for name, array in self.images.items()}, jitter, cuts, focal
        )


Sequence.__module__ = "stillray"


def denoise(
    frames: Union[Sequence, Mapping[str, np.ndarray], Iterable[Mapping[str, Any]]],
    window: str = "both",
    preset: str = "default",
    outputs: Optional[Iterable[str]] = None,
    device: str = "cpu",
    threads: int = 0,
    progress: Optional[Callable[[int], Any]] = None,
    **settings: Any,
) -> Any:
    """Denoises all frames of a sequence.

        frames: a Sequence; a dictionary of its arrays, such as "direct_diffuse" of the shape
            (frames, height, width, 3); or an iterable of frames, as for denoise_sequence()
        window: "both" for light of earlier and later frames, "past" for light of earlier frames
            only, as Denoiser.denoise() (cuts must then be marked)
        preset, device, threads, settings: as for Denoiser
        outputs: names of the outputs to return; None: the denoised images
        progress: called with the number of finished frames; return False to cancel (raises
            stillray.Cancelled)

    Returns the denoised images, float32 of (frames, height, width, 3), or, with outputs, a
    dictionary of one array per name. To receive frames as they are finished, call
    denoise_sequence(). Raises ValueError naming the invalid frame, image or setting.
    """
    if window not in ("both", "past"):
        raise ValueError("window is '%s', expected both or past" % (window,))
    if isinstance(frames, Mapping):
        frames = Sequence(frames)
    names = None if outputs is None or isinstance(outputs, str) else list(outputs)
    wanted = outputs if isinstance(outputs, str) else names  # a str is refused by the denoiser
    denoiser = Denoiser(preset, threads=threads, device=device, **settings)
    run = denoise_sequence if window == "both" else _denoise_past
    finished: List[Any] = []
    for clean in run(denoiser, frames, wanted):
        finished.append(clean)
        answer = None if progress is None else progress(len(finished))
        if answer is not None and not answer:
            raise Cancelled("cancelled after %d frames" % len(finished))
    if not finished:
        raise ValueError("the sequence has no frames")
    if names is None:
        return _stack("colour", finished)
    return {name: _stack(name, [frame[name] for frame in finished]) for name in names}


def _denoise_past(
    denoiser: Denoiser, frames: Iterable[Mapping[str, Any]], outputs: Any
) -> Iterator[Any]:
    for frame in frames:
        images = dict(frame)
        images.pop("next_motion", None)
        if images.pop("cut", None):
            denoiser.reset()
        jitter = images.pop("jitter", (0.0, 0.0))
        focal_pixels = images.pop("focal_pixels", 0.0)
        yield denoiser.denoise(images, outputs, jitter=jitter, focal_pixels=focal_pixels)


def _check_stack(name: str, array: Any) -> None:
    if not isinstance(array, np.ndarray):
        raise TypeError(
            "image '%s' is a %s, expected a NumPy array" % (name, type(array).__name__)
        )
    if array.ndim not in (3, 4):
        raise ValueError(
            "image '%s' has the shape %s, expected (frames, height, width) or "
            "(frames, height, width, channels)" % (name, array.shape)
        )
    if array.shape[0] == 0:
        raise ValueError("image '%s' has the shape %s: no frames" % (name, array.shape))


def _stack(name: str, pictures: List[np.ndarray]) -> np.ndarray:
    for index, picture in enumerate(pictures):
        if not isinstance(picture, np.ndarray):
            raise TypeError(
                "frame %d: image '%s' is a %s, expected a NumPy array"
                % (index, name, type(picture).__name__)
            )
        if picture.shape != pictures[0].shape:
            raise ValueError(
                "frame %d: '%s' has the shape %s, expected %s as in frame 0"
                % (index, name, picture.shape, pictures[0].shape)
            )
    return np.stack(pictures)
