# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The C API with NumPy arrays, by ctypes: for every version of Python, where the compiled module of
module.cpp is for one. Names, meanings and messages are the same; both pass the same tests."""

import contextlib
import ctypes
import os
import threading
import warnings
from typing import NamedTuple

try:
    import numpy as np
except ImportError as error:
    raise ImportError("stillray needs NumPy: pip install numpy") from error

from ._structs import (
    _Camera,
    _Hits,
    _Image,
    _InputInfo,
    _MemoryNeed,
    _ParameterInfo,
    _Statistics,
    _Waiting,
)

ABI_VERSION = 2  # STILLRAY_ABI_VERSION, which the name of the library ends in
_OK, _INVALID_ARGUMENT, _OUT_OF_MEMORY, _CANCELLED = 0, 1, 6, 7
_LARGEST_SIDE = 32768
_TYPE_NAMES = ("float", "int", "flag", "choice", "steps")
_CUTS = {None: 0, True: 1, False: 2}


class Error(RuntimeError):
    """What has no counterpart among Python's own exceptions."""


class Cancelled(Error):
    """Cancelled by the progress function."""


Error.__module__ = Cancelled.__module__ = "stillray"

# ---- The library ---------------------------------------------------------------------------------

_Progress = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)
_handle, _text, _size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t

# Result and arguments of every function that is used.
_FUNCTIONS = {
    "abi_version": (ctypes.c_uint32, []),
    "version": (_text, []),
    "input_count": (_size, []),
    "input_at": (ctypes.c_int, [_size, ctypes.POINTER(_InputInfo)]),
    "parameter_count": (_size, []),
    "parameter_at": (ctypes.c_int, [_size, ctypes.POINTER(_ParameterInfo)]),
    "preset_count": (_size, []),
    "preset_name": (_text, [_size]),
    "device_create_on": (
        ctypes.c_int,
        [ctypes.c_uint32, ctypes.c_int32, _text, ctypes.POINTER(_handle)],
    ),
    "device_description": (_text, [_handle]),
    "device_release": (None, [_handle]),
    "device_threads": (ctypes.c_int32, [_handle]),
    "denoiser_create": (ctypes.c_int, [_handle, _text, ctypes.POINTER(_handle)]),
    "denoiser_release": (None, [_handle]),
    "error_message": (_text, [_handle]),
    "denoiser_set_preset": (ctypes.c_int, [_handle, _text]),
    "denoiser_set": (ctypes.c_int, [_handle, _text, _text]),
    "denoiser_get": (ctypes.c_int, [_handle, _text, ctypes.POINTER(_text)]),
    "denoiser_set_input": (ctypes.c_int, [_handle, _text, ctypes.POINTER(_Image)]),
    "denoiser_set_output": (ctypes.c_int, [_handle, _text, ctypes.POINTER(_Image)]),
    "denoiser_output_count": (_size, [_handle]),
    "denoiser_output_name": (_text, [_handle, _size]),
    "denoiser_set_jitter": (ctypes.c_int, [_handle, ctypes.c_float, ctypes.c_float]),
    "denoiser_set_focal_pixels": (ctypes.c_int, [_handle, ctypes.c_float]),
    "denoiser_set_progress": (ctypes.c_int, [_handle, _Progress, ctypes.c_void_p]),
    "denoiser_execute": (ctypes.c_int, [_handle]),
    "denoiser_set_frame_index": (ctypes.c_int, [_handle, ctypes.c_int64]),
    "denoiser_reset": (ctypes.c_int, [_handle]),
    "denoiser_save_history": (
        ctypes.c_int,
        [_handle, ctypes.c_void_p, _size, ctypes.POINTER(_size)],
    ),
    "denoiser_restore_history": (ctypes.c_int, [_handle, ctypes.c_void_p, _size]),
    "denoiser_push": (ctypes.c_int, [_handle, ctypes.c_int32]),
    "denoiser_finish": (ctypes.c_int, [_handle]),
    "denoiser_pull": (ctypes.c_int, [_handle, ctypes.POINTER(ctypes.c_int32)]),
    "denoiser_waiting": (ctypes.c_int, [_handle, ctypes.POINTER(_Waiting)]),
    "denoiser_memory_need": (ctypes.c_int, [_handle, ctypes.POINTER(_MemoryNeed)]),
    "reflections_from_hits": (ctypes.c_int, [ctypes.POINTER(_Hits)]),
    "denoiser_statistics": (ctypes.c_int, [_handle, ctypes.POINTER(_Statistics)]),
    "denoiser_warning": (_text, [_handle]),
}


def _load():
    """The library that stands beside this file, and no other that the machine may have."""
    name = "libstillray.so.%d" % ABI_VERSION
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name)
    if not os.path.exists(path):
        raise ImportError(
            "stillray: %s is not in %s: this installation is incomplete; install the package again"
            % (name, os.path.dirname(path))
        )
    try:
        library = ctypes.CDLL(path)
    except OSError as error:
        raise ImportError("stillray: %s could not be loaded: %s" % (path, error)) from error
    for function, (result, arguments) in _FUNCTIONS.items():
        try:
            entry = getattr(library, "stillray_" + function)
        except AttributeError:
            raise ImportError(
                "stillray: %s has no function stillray_%s: it is of another version" % (path, function)
            ) from None
        entry.restype, entry.argtypes = result, arguments
    found = library.stillray_abi_version()
    if found != ABI_VERSION:
        raise ImportError(
            "stillray: %s has the ABI version %d, expected %d" % (path, found, ABI_VERSION)
        )
    return library


_library = _load()
__version__ = _library.stillray_version().decode()


def _check(code, handle=None):
    if code == _OK:
        return
    message = _library.stillray_error_message(handle).decode()
    if code == _INVALID_ARGUMENT:
        raise ValueError(message)
    if code == _OUT_OF_MEMORY:
        raise MemoryError(message)
    raise (Cancelled if code == _CANCELLED else Error)(message)


# ---- Tables --------------------------------------------------------------------------------------


class Parameter(NamedTuple):
    """One setting of a denoiser."""

    name: str
    help: str
    group: str
    unit: str
    type: str
    min: float
    max: float
    default: str
    choices: list

    def __repr__(self):
        return "<Parameter %s=%s>" % (self.name, self.default)


Parameter.__module__ = "stillray"
for _name, _doc in {
    "help": "one sentence",
    "group": "the stage that reads it",
    "unit": "'' if it has none",
    "type": "'float', 'int', 'flag', 'choice' or 'steps'",
    "default": "as text",
    "choices": "names, if type is 'choice'",
}.items():
    getattr(Parameter, _name).__doc__ = _doc


def _parameter_at(index):
    info = _ParameterInfo()
    _check(_library.stillray_parameter_at(index, ctypes.byref(info)))
    return Parameter(
        info.name.decode(),
        info.help.decode(),
        info.group.decode(),
        info.unit.decode(),
        _TYPE_NAMES[info.type],
        info.min,
        info.max,
        info.default_value.decode(),
        [info.choices[i].decode() for i in range(info.choice_count)],
    )


def parameters():
    """All settings, in the order of the documentation."""
    return [_parameter_at(i) for i in range(_library.stillray_parameter_count())]


def presets():
    """Names of the presets."""
    return [_library.stillray_preset_name(i).decode() for i in range(_library.stillray_preset_count())]


def inputs():
    """The images that a frame may have: what each means, by name."""
    found = {}
    for i in range(_library.stillray_input_count()):
        info = _InputInfo()
        _check(_library.stillray_input_at(i, ctypes.byref(info)))
        plural = "" if info.channels == 1 else "s"
        found[info.name.decode()] = "%d channel%s. %s" % (info.channels, plural, info.help.decode())
    return found


def _setting_text(value):
    """A setting as text: True is "on", [1, 2] is "1,2", 0.1 is "0.1"."""
    if isinstance(value, (bool, np.bool_)):
        return "on" if value else "off"
    if isinstance(value, (list, tuple)):
        return ",".join(map(_setting_text, value))
    return str(value)


# ---- Images --------------------------------------------------------------------------------------


def _arrays_of(images):
    """Arrays by name, without those that are None."""
    arrays = {}
    for name, value in images.items():
        if not isinstance(name, str):
            raise TypeError("names of images must be strings")
        if value is None:
            continue
        if not isinstance(value, np.ndarray):
            raise TypeError(
                "image '%s' is a %s, expected a NumPy array" % (name, type(value).__name__)
            )
        arrays[name] = value
    return arrays


_FORMATS = {np.dtype(np.float32): 1, np.dtype(np.float16): 2, np.dtype(np.uint32): 3}


def _describe(name, array, writeable):
    """The memory of an array; it must outlive the description."""
    if array.dtype not in _FORMATS:
        also = " or uint32" if name == "id" else ""
        raise TypeError(
            "image '%s' is of type %s, expected float32, float16%s" % (name, array.dtype, also)
        )
    if array.ndim not in (2, 3):
        raise ValueError(
            "image '%s' has the shape %s, expected (height, width) or (height, width, channels)"
            % (name, array.shape)
        )
    if writeable and not array.flags.writeable:
        raise ValueError("image '%s' is read-only" % name)
    for axis in range(array.ndim):
        if array.strides[axis] == 0 and array.shape[axis] > 1 and array.size > 0:
            raise ValueError(
                "image '%s' repeats values along axis %d (a broadcast view)" % (name, axis)
            )
        if array.shape[axis] > _LARGEST_SIDE:
            raise ValueError(
                "image '%s' has the shape %s, expected at most %d pixels to a side"
                % (name, array.shape, _LARGEST_SIDE)
            )
    deep = array.ndim == 3
    return _Image(
        array.ctypes.data,
        _FORMATS[array.dtype],
        array.shape[2] if deep else 1,
        array.shape[1],
        array.shape[0],
        array.strides[1],
        array.strides[0],
        array.strides[2] if deep else array.itemsize,
    )


def _has_three_channels(output):
    return output in ("colour", "temporal", "aliased") or output.startswith(
        ("atrous", "noisy.", "accumulated.", "filtered.")
    )


def _add_results(wanted, height, width, results):
    """Makes the arrays that are wanted and not there."""
    for name in wanted:
        if name not in results:
            channels = (3,) if _has_three_channels(name) else ()
            results[name] = np.empty((height, width) + channels, np.float32)


def _output_names(outputs):
    if outputs is None:
        return ["colour"]
    try:
        names = [] if isinstance(outputs, (str, bytes)) else list(outputs)
    except TypeError:
        names = [None]
    if isinstance(outputs, (str, bytes)) or not all(isinstance(name, str) for name in names):
        raise TypeError(
            'outputs is a %s, expected a list of names, such as ["colour"]' % type(outputs).__name__
        )
    return names


def _answer(outputs, results):
    """The result of a call: the picture, or all results by name if `outputs` are named."""
    return results["colour"] if outputs is None else results


def _as_bool(answer):
    if answer is None:
        return True
    if hasattr(type(answer), "__bool__"):
        return bool(answer)
    raise TypeError(
        "the progress function returned a %s, expected True, False or None" % type(answer).__name__
    )


def _as_text(name, value):
    if not isinstance(value, str):
        raise TypeError("%s is a %s, expected a str" % (name, type(value).__name__))
    if "\0" in value:
        raise ValueError("%s has a null character" % name)
    return value.encode()


def _as_int(name, value, limit):
    if isinstance(value, bool) or not hasattr(value, "__index__"):
        raise TypeError("%s is a %s, expected an int" % (name, type(value).__name__))
    number = value.__index__()
    if not -limit <= number < limit:
        raise TypeError("%s is %d, which is too large" % (name, number))
    return number


# ---- Reflections ---------------------------------------------------------------------------------


def _camera_of(camera):
    made = _Camera()
    for key in ("world_to_camera", "projection"):
        if key not in camera:
            raise ValueError("the camera has no '%s', expected 16 numbers" % key)
        numbers = np.asarray(camera[key], np.float64).ravel()
        if numbers.size != 16:
            raise ValueError(
                "'%s' of the camera has %d numbers, expected 16" % (key, numbers.size)
            )
        setattr(made, key, (ctypes.c_double * 16)(*numbers))
    return made


def reflections_from_hits(frame, hit_distance, camera, previous_camera):
    """Guides of what mirrors show, from the length of reflected rays.

        frame: arrays by name: 'depth', and, where known, 'roughness' (else neighbours must
            agree), 'normal' and 'id'; others are not used
        hit_distance: (height, width), from the first surface to what the ray met, in the
            unit of depth; >= 1e9 and infinity: the sky; 0, negative, NaN: not known
        camera, previous_camera: 'world_to_camera' and 'projection', 16 numbers each, row
            by row, or 4 x 4, as in the file of cameras (docs/cameras.md); other keys are
            not used

    Returns {'reflection_depth', 'reflection_motion'}, to add to the frame. Raises
    ValueError naming the image or the camera that is wrong.
    """
    arrays = _arrays_of(frame)
    if "depth" not in arrays:
        raise ValueError("image 'depth' is not given")
    shape = arrays["depth"].shape[:2]
    made = {
        "reflection_depth": np.empty(shape, np.float32),
        "reflection_motion": np.empty(shape + (2,), np.float32),
    }
    images = {k: arrays[k] for k in ("depth", "roughness", "normal", "id") if k in arrays}
    images.update(_arrays_of({"hit_distance": hit_distance}))
    described = {name: _describe(name, array, False) for name, array in images.items()}
    described.update({name: _describe(name, array, True) for name, array in made.items()})
    described["camera"] = _camera_of(camera)
    described["previous_camera"] = _camera_of(previous_camera)
    hits = _Hits()
    for name, value in described.items():
        setattr(hits, name, ctypes.pointer(value))
    _check(_library.stillray_reflections_from_hits(ctypes.byref(hits)))
    return made


# ---- The denoiser --------------------------------------------------------------------------------


class Denoiser:
    """Denoises one sequence, frame by frame, and holds its history.

    Denoiser(preset='default', threads=0, device='cpu', **settings)

        preset: one of stillray.presets()
        threads: 0 for one per processor; the picture is the same for any number
        device: 'cpu', 'vulkan', 'vulkan:N', or 'auto': a GPU where there is one, else the CPU
        settings: see stillray.parameters(), such as alpha_min=0.05, steps=[1, 2, 4],
            antialias='off'

    Other Python threads run while a frame is denoised. One denoiser works on one frame at a
    time; use one per thread and sequence.
    """

    _device = _denoiser = None

    def __init__(self, preset="default", threads=0, device="cpu", **settings):
        self._lock = threading.Lock()
        self._release = (_library.stillray_denoiser_release, _library.stillray_device_release)
        made = _handle()
        count, name = _as_int("threads", threads, 1 << 31), _as_text("device", device)
        _check(_library.stillray_device_create_on(ABI_VERSION, count, name, ctypes.byref(made)))
        self._device = made.value
        made = _handle()
        name = _as_text("preset", preset)
        _check(_library.stillray_denoiser_create(self._device, name, ctypes.byref(made)))
        self._denoiser = made.value
        self.set(**settings)

    def __del__(self):
        if self._denoiser:
            self._release[0](self._denoiser)
        if self._device:
            self._release[1](self._device)
        self._denoiser = self._device = None

    @contextlib.contextmanager
    def _use(self):
        """Other Python threads run while a frame is denoised; this denoiser is not theirs meanwhile."""
        if not self._lock.acquire(blocking=False):
            raise Error("this denoiser is at work on a frame: wait for it, or use one per thread")
        try:
            yield
        finally:
            self._lock.release()

    def _call(self, name, *arguments):
        function = getattr(_library, "stillray_denoiser_" + name)
        _check(function(self._denoiser, *arguments), self._denoiser)

    def set(self, **settings):
        """Changes settings from the next frame on, as in the constructor. Settings that
        contradict each other are reported by denoise()."""
        with self._use():
            for name, value in settings.items():
                self._call("set", _as_text("a setting", name), _as_text(name, _setting_text(value)))

    def set_preset(self, preset):
        """Sets all settings of a preset."""
        with self._use():
            self._call("set_preset", _as_text("preset", preset))

    @property
    def settings(self):
        """All settings, as text."""
        with self._use():
            found = {}
            for parameter in parameters():
                value = _text()
                self._call("get", parameter.name.encode(), ctypes.byref(value))
                found[parameter.name] = value.value.decode()
            return found

    @property
    def threads(self):
        """Number of threads."""
        return _library.stillray_device_threads(self._device)

    @property
    def device(self):
        """'cpu', or choice, name and driver of another device."""
        return _library.stillray_device_description(self._device).decode()

    @property
    def outputs(self):
        """Names of the results that denoise() can give with these settings."""
        with self._use():
            count = _library.stillray_denoiser_output_count(self._denoiser)
            return [
                _library.stillray_denoiser_output_name(self._denoiser, i).decode()
                for i in range(count)
            ]

    @property
    def statistics(self):
        """Of the last frame: values of light that were 'non_finite' or 'negative' and were
        treated as missing, pixels with 'bad_guides', 'memory_bytes', 'filter_ms'."""
        with self._use():
            found = _Statistics()
            self._call("statistics", ctypes.byref(found))
            return {name: getattr(found, name) for name, _ in _Statistics._fields_[1:]}

    def denoise(
        self, frame, outputs=None, out=None, jitter=(0.0, 0.0), progress=None, focal_pixels=0.0
    ):
        """Denoises the next frame of the sequence.

            frame: arrays by name, see stillray.inputs(). Light is needed (one or more of
                'direct_diffuse', ...), and 'motion' from the second frame on, unless the
                settings follow none. 'depth', 'normal' and 'albedo' keep edges and textures
                sharp. float32 or float16, (height, width) or (height, width, channels), any
                strides: nothing is copied.
            outputs: names of the results to return, see the property outputs;
                'variance' and 'history_length' steer adaptive samplers
            out: arrays by name to write results to; they may be the frame's own
            jitter: all rays went through pixel (x, y) at x + 0.5 + jitter[0],
                y + 0.5 + jitter[1]; other than (0, 0) it turns antialiasing in time on
            progress: called with 0..1; return False to cancel (raises stillray.Cancelled)
            focal_pixels: width / (2 tan(horizontal angle of view / 2)), which
                depth_weight='position' needs

        Returns the picture, float32 of (height, width, 3), or, if outputs is given, all
        results by name. A frame of another size restarts the history.

        Raises ValueError naming the image or setting that is wrong (history is then
        unchanged), TypeError for other types of arrays. Warns (RuntimeWarning) of images that
        say nothing, such as normals that are all zero.
        """
        with self._use():
            images = _arrays_of(frame)
            results = {} if out is None else _arrays_of(out)
            wanted = _output_names(outputs)
            with self._cleanup(images, results):
                self._give_inputs(images, jitter, focal_pixels)
                if images:
                    height, width = next(iter(images.values())).shape[:2]
                    _add_results(wanted, height, width, results)
                self._give_outputs(results)
                self._run(progress, "execute")
            return _answer(outputs, results)

    def push(self, frame, jitter=(0.0, 0.0), cut=None, index=None, focal_pixels=0.0):
        """Appends a frame to a sequence that is denoised with light of later frames too; its
        arrays are copied. denoise_sequence() pushes and pulls by itself.

            frame, jitter, focal_pixels: as for denoise(); besides 'next_motion', pixels: the
                point seen at p stands at p + next_motion(p) one frame later (else it is found
                from the next frame's motion)
            cut: True: the frame begins a shot; False: it does not; None: found by comparing
                surfaces
            index: number of the frame; counts up from 0 by itself

        Raises ValueError as denoise(); the sequence is then unchanged.
        """
        with self._use():
            images = _arrays_of(frame)
            with self._cleanup(images, {}):
                if index is not None:
                    self._call("set_frame_index", _as_int("index", index, 1 << 63))
                self._give_inputs(images, jitter, focal_pixels)
                self._call("push", _CUTS[None if cut is None else bool(cut)])

    def finish(self):
        """The sequence ends with the last frame that was pushed: all frames are ready."""
        with self._use():
            self._call("finish")

    def pull(self, outputs=None, out=None, progress=None):
        """Finishes the next frame of those that were pushed. Frames come in blocks of 16, each
        ready once 16 frames behind it are pushed or the sequence is finished.

            outputs, out, progress: as for denoise(); after cancelling, another call does the
                work again

        Returns None if no frame is ready, else as denoise().
        """
        with self._use():
            waiting = self._find_waiting()
            if waiting.ready == 0:
                return None
            results = {} if out is None else _arrays_of(out)
            _add_results(_output_names(outputs), waiting.height, waiting.width, results)
            with self._cleanup({}, results):
                self._give_outputs(results)
                self._run(progress, "pull", ctypes.byref(ctypes.c_int32()))
            return _answer(outputs, results)

    @property
    def waiting(self):
        """Number of frames that were pushed and not yet pulled."""
        with self._use():
            return self._find_waiting().frames

    def memory_need(self, frame, jitter=(0.0, 0.0)):
        """Bytes that a sequence of pushed frames like this one takes at most ('most'), in parts:
        'denoisers', 32 times 'per_frame', 16 times 'per_future'. Values do not matter."""
        with self._use():
            images = _arrays_of(frame)
            with self._cleanup(images, {}):
                self._give_inputs(images, jitter, 0.0)
                need = _MemoryNeed()
                self._call("memory_need", ctypes.byref(need))
            return {name: getattr(need, name) for name, _ in _MemoryNeed._fields_[1:]}

    def reset(self):
        """Forgets all history, as after a cut, and all frames that wait."""
        with self._use():
            self._call("reset")

    def save_history(self):
        """The whole history, to continue later with the same bits."""
        with self._use():
            size = _size()
            self._call("save_history", None, 0, ctypes.byref(size))
            buffer = ctypes.create_string_buffer(size.value)
            self._call("save_history", buffer, size, ctypes.byref(size))
            return buffer.raw[: size.value]

    def restore_history(self, history):
        """Continues from save_history(). Raises stillray.Error if the bytes are damaged or of
        other settings; history is then unchanged."""
        if not isinstance(history, bytes):
            raise TypeError("history is a %s, expected bytes" % type(history).__name__)
        with self._use():
            self._call("restore_history", history, len(history))

    # What a call gives to the library.

    def _find_waiting(self):
        waiting = _Waiting()
        self._call("waiting", ctypes.byref(waiting))
        return waiting

    def _give_inputs(self, images, jitter, focal_pixels):
        x, y = jitter
        self._call("set_jitter", x, y)
        self._call("set_focal_pixels", focal_pixels)
        for name, array in images.items():
            image = _describe(name, array, writeable=False)
            self._call("set_input", _as_text("an image's name", name), ctypes.byref(image))

    def _give_outputs(self, results):
        for name, array in results.items():
            image = _describe(name, array, writeable=True)
            self._call("set_output", _as_text("a result's name", name), ctypes.byref(image))

    @contextlib.contextmanager
    def _cleanup(self, images, results):
        """Takes away the descriptions of arrays that may be gone after the call."""
        try:
            yield
        finally:
            for name in images:
                _library.stillray_denoiser_set_input(self._denoiser, name.encode(), None)
            for name in results:
                _library.stillray_denoiser_set_output(self._denoiser, name.encode(), None)

    def _run(self, progress, function, *arguments):
        """Calls a function that works for long. ctypes releases the interpreter's lock meanwhile."""
        raised = []

        def report(_, fraction):
            try:
                return 0 if _as_bool(progress(fraction)) else 1
            except BaseException as error:  # raised again below: C cannot pass it on
                raised.append(error)
                return 1

        callback = _Progress() if progress is None else _Progress(report)
        self._call("set_progress", callback, None)
        try:
            self._call(function, *arguments)
        except Cancelled:
            if raised:
                raise raised[0] from None
            raise
        finally:
            _library.stillray_denoiser_set_progress(self._denoiser, _Progress(), None)
        warning = _library.stillray_denoiser_warning(self._denoiser).decode()
        if warning:
            warnings.warn(warning, RuntimeWarning, stacklevel=3)


Denoiser.__module__ = "stillray"
