# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""The structs of the C API, for ctypes."""

import ctypes


class _Image(ctypes.Structure):
    _fields_ = [
        ("data", ctypes.c_void_p),
        ("format", ctypes.c_int32),
        ("channels", ctypes.c_int32),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("pixel_stride", ctypes.c_ssize_t),
        ("row_stride", ctypes.c_ssize_t),
        ("channel_stride", ctypes.c_ssize_t),
    ]


class _Growing(ctypes.Structure):
    """A struct that begins with its size, and may get more members in later versions."""

    def __init__(self):
        super().__init__(struct_size=ctypes.sizeof(self))


class _InputInfo(_Growing):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("name", ctypes.c_char_p),
        ("help", ctypes.c_char_p),
        ("channels", ctypes.c_int32),
    ]


class _ParameterInfo(_Growing):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("name", ctypes.c_char_p),
        ("help", ctypes.c_char_p),
        ("group", ctypes.c_char_p),
        ("unit", ctypes.c_char_p),
        ("type", ctypes.c_int),
        ("min", ctypes.c_double),
        ("max", ctypes.c_double),
        ("default_value", ctypes.c_char_p),
        ("choices", ctypes.POINTER(ctypes.c_char_p)),
        ("choice_count", ctypes.c_size_t),
    ]


class _Camera(ctypes.Structure):
    _fields_ = [("world_to_camera", ctypes.c_double * 16), ("projection", ctypes.c_double * 16)]


class _Hits(_Growing):
    _fields_ = [("struct_size", ctypes.c_size_t)] + [
        (name, ctypes.POINTER(_Camera if "camera" in name else _Image))
        for name in (
            "depth",
            "hit_distance",
            "roughness",
            "normal",
            "id",
            "camera",
            "previous_camera",
            "reflection_depth",
            "reflection_motion",
        )
    ]


class _Waiting(_Growing):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("frames", ctypes.c_size_t),
        ("ready", ctypes.c_int32),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("index", ctypes.c_int64),
    ]


class _MemoryNeed(_Growing):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("denoisers", ctypes.c_size_t),
        ("per_future", ctypes.c_size_t),
        ("per_frame", ctypes.c_size_t),
        ("most", ctypes.c_size_t),
    ]


class _Statistics(_Growing):
    _fields_ = [
        ("struct_size", ctypes.c_size_t),
        ("non_finite", ctypes.c_int64),
        ("negative", ctypes.c_int64),
        ("bad_guides", ctypes.c_int64),
        ("memory_bytes", ctypes.c_size_t),
        ("filter_ms", ctypes.c_double),
    ]
