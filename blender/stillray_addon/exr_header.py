# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Headers of OpenEXR files, without bpy: names of channels, and whether a file is complete.

Format: "OpenEXR File Layout" of the OpenEXR project. Scan lines only, which is what Blender writes;
tiled parts count as complete.
"""
import os
import struct

_MAGIC = 20000630
_TILED, _DEEP, _MULTI_PART = 0x200, 0x800, 0x1000
# Scan lines per chunk by the number of the compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44,
# B44A, DWAA, DWAB.
_LINES = (1, 1, 1, 16, 32, 16, 32, 32, 32, 256)
_MAX_HEADER = 16 << 20


class ExrError(ValueError):
    pass


class Part:
    def __init__(self):
        self.attributes = {}
        self.channels = []

    def text(self, name):
        _, value = self.attributes.get(name, ("", b""))
        return value.decode("utf-8", "replace")

    @property
    def lines(self):
        x0, y0, x1, y1 = struct.unpack("<4i", self.attributes["dataWindow"][1])
        return y1 - y0 + 1

    @property
    def chunks(self):
        if "chunkCount" in self.attributes:
            return struct.unpack("<i", self.attributes["chunkCount"][1])[0]
        compression = self.attributes["compression"][1][0]
        if compression >= len(_LINES):
            raise ExrError(f"compression {compression} is unknown")
        return -(-self.lines // _LINES[compression])


class Header:
    def __init__(self, parts, tiled, deep, multi_part, end):
        self.parts = parts
        self.tiled = tiled
        self.deep = deep
        self.multi_part = multi_part
        self.end = end  # bytes

    @property
    def channels(self):
        """Names of all channels. In files with several parts the part's name comes first unless the
        channel has it."""
        names = []
        for part in self.parts:
            prefix = part.text("name")
            for channel in part.channels:
                known = not self.multi_part or not prefix or channel.startswith(prefix + ".")
                names.append(channel if known else f"{prefix}.{channel}")
        return names

    @property
    def view_layers(self):
        """View layers that Blender wrote, by their pass Combined."""
        layers = []
        for name in self.channels:
            layer, found, _ = name.rpartition(".Combined.")
            if found and layer not in layers and layer != "Composite":
                layers.append(layer)
        return layers


def _string(data, at):
    end = data.find(b"\0", at)
    if end < 0:
        raise ExrError("the header ends too early")
    return data[at:end], end + 1


def _channels(value):
    names, at = [], 0
    while at < len(value) and value[at] != 0:
        name, at = _string(value, at)
        names.append(name.decode("utf-8", "replace"))
        at += 16
    return names


def _part(data, at):
    part = Part()
    while True:
        name, at = _string(data, at)
        if not name:
            return part, at
        kind, at = _string(data, at)
        if at + 4 > len(data):
            raise ExrError("the header ends too early")
        size = struct.unpack_from("<i", data, at)[0]
        at += 4
        if size < 0 or at + size > len(data):
            raise ExrError("the header ends too early")
        value = data[at:at + size]
        at += size
        part.attributes[name.decode("utf-8", "replace")] = (kind, value)
        if name == b"channels":
            part.channels = _channels(value)


def parse(data):
    if len(data) < 8 or struct.unpack_from("<i", data)[0] != _MAGIC:
        raise ExrError("not an OpenEXR file")
    version = struct.unpack_from("<I", data, 4)[0]
    multi_part = bool(version & _MULTI_PART)
    parts, at = [], 8
    while True:
        part, at = _part(data, at)
        if not part.attributes:
            break
        parts.append(part)
        if not multi_part:
            break
    for part in parts:
        if "dataWindow" not in part.attributes or "compression" not in part.attributes:
            raise ExrError("the header lacks dataWindow or compression")
    return Header(parts, bool(version & _TILED), bool(version & _DEEP), multi_part, at)


def read(file):
    with open(file, "rb") as stream:
        return parse(stream.read(_MAX_HEADER))


def fault(file):
    """Why a file is not a complete OpenEXR file, or "". Reads header and table of chunks."""
    try:
        size = os.path.getsize(file)
        header = read(file)
        if header.tiled or header.deep:
            return ""
        count = sum(part.chunks for part in header.parts)
        with open(file, "rb") as stream:
            stream.seek(header.end)
            table = stream.read(8 * count)
            if len(table) < 8 * count:
                return "it is cut off"
            last = max(struct.unpack(f"<{count}Q", table), default=0)
            if 0 in struct.unpack(f"<{count}Q", table):
                return "it was not written to its end"
            begin = last + (8 if header.multi_part else 4)
            stream.seek(begin)
            length = stream.read(4)
        if len(length) < 4 or begin + 4 + struct.unpack("<i", length)[0] > size:
            return "it is cut off"
        return ""
    except (OSError, ExrError, struct.error) as error:
        return str(error)
