# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Command lines of `stillray`, without bpy."""
import copy


class Options:
    """What the panel sets, as plain data."""

    def __init__(self, preset="default", window="auto", passes=False, fireflies=False,
                 smooth=False, device="auto", threads=0, memory_limit="", aovs=(), cameras=""):
        self.preset = preset
        self.window = window
        self.passes = passes
        self.fireflies = fireflies
        self.smooth = smooth  # edges, in time
        self.device = device
        self.threads = threads
        self.memory_limit = memory_limit
        self.aovs = tuple(aovs)
        self.cameras = cameras  # a path as the program is to get it, or ""

    def for_stage(self, layer, layers, cameras):
        """Of a chain over view layers: without layer options (--aov) that name another one."""
        others = tuple(other + "." for other in layers if other and other != layer)
        aovs = [aov for aov in self.aovs if not aov.partition("=")[2].startswith(others)]
        options = copy.copy(self)
        options.aovs, options.cameras = tuple(aovs), cameras
        return options


# Presets as published stay as they are.
_SMOOTH_PRESETS = ("default", "best")


def _range(frames):
    return str(frames[0]) if frames[0] == frames[-1] else f"{frames[0]}-{frames[-1]}"


def _inputs(names, frames):
    """All files of a pattern are read unless --frames limits them."""
    inputs = names.inputs(frames)
    return inputs + (["--frames", _range(frames)] if "#" in inputs[0] else [])


def denoise(program, names, frames, output, options, view_layer="", json="", first=True):
    """Arguments after the program's path, for a process in the folder of the frames.

    Of a chain over several view layers only the first run checks the frames.
    """
    arguments = ["denoise", *_inputs(names, frames), "-o", output, "--renderer", "blender",
                 "--preset", options.preset, "--window", options.window]
    if view_layer:
        arguments += ["--view-layer", view_layer]
    if options.passes:
        arguments.append("--passes")
    if options.fireflies:
        arguments += ["--set", "firefly=clamp"]
    if options.smooth and options.preset in _SMOOTH_PRESETS and not options.passes:
        arguments += ["--set", "antialias=taa"]
    for aov in options.aovs:
        arguments += ["--aov", aov]
    if options.device != "auto":
        arguments += ["--device", options.device]
    if options.threads:
        arguments += ["--threads", str(options.threads)]
    if options.memory_limit.strip():
        arguments += ["--memory-limit", options.memory_limit.strip()]
    if options.cameras and program.has("--cameras"):
        arguments += ["--cameras", options.cameras]
    if not first:
        arguments.append("--no-check")
    if json:
        arguments += ["--json", json]
    return arguments


def check(names, frames, options, view_layer="", json=""):
    arguments = ["check", *_inputs(names, frames), "--renderer", "blender"]
    if view_layer:
        arguments += ["--view-layer", view_layer]
    for aov in options.aovs:
        arguments += ["--aov", aov]
    if options.threads:
        arguments += ["--threads", str(options.threads)]
    return arguments + (["--json", json] if json else [])
