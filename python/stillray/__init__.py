# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""stillray: a temporally stable denoiser for path-traced animations.

    import numpy as np
    import stillray

    denoiser = stillray.Denoiser("default")
    for frame in frames:                       # a renderer's
        clean = denoiser.denoise({
            "direct_diffuse": frame.direct,    # (height, width, 3), linear, noisy
            "indirect_diffuse": frame.indirect,
            "albedo": frame.albedo,            # (height, width, 3)
            "normal": frame.normal,            # (height, width, 3), world space
            "depth": frame.depth,              # (height, width), linear view z
            "motion": frame.motion,            # (height, width, 2), pixels
        })                                     # (height, width, 3), float32

Arrays are float32 or float16 (`id`: uint32) of any strides, also planar, mirrored or a part of a
larger array; they are read and written in place. `stillray.inputs()` describes each image,
`stillray.parameters()` each setting.

A sequence that is known as a whole, or may be delayed by some frames, becomes cleaner with light of
later frames:

    for clean in stillray.denoise_sequence(denoiser, frames):   # frames as above
        show(clean)

All frames at once, as arrays with the frame as first axis; .shape is (frames, height, width, 3):

    clean = stillray.denoise({"direct_diffuse": light, "albedo": albedo, "motion": motion})

Files of a renderer, with all their layers:

    stillray.denoise_files("in.####.exr", "out/", window="both", passes=True)

Pixel (0, 0) is the top left; x runs right, y down. `motion` points to the position of the surface
one frame ago. Wrong arguments raise ValueError with the value found and the value expected.
"""

from ._stillray import (
    Cancelled,
    Denoiser,
    Error,
    Parameter,
    __version__,
    inputs,
    parameters,
    presets,
    reflections_from_hits,
)
from ._sequence import denoise_files, denoise_sequence
from ._frames import Sequence, denoise

__all__ = [
    "Cancelled",
    "Denoiser",
    "Error",
    "Parameter",
    "Sequence",
    "__version__",
    "denoise",
    "denoise_files",
    "denoise_sequence",
    "inputs",
    "parameters",
    "presets",
    "reflections_from_hits",
]
