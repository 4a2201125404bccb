# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Plain OpenEXR files, with the colour alone, of multilayer ones; without bpy.

Blender's sequencer cannot read multilayer files. The values stay as they are, bit for bit. Needs
NumPy, which Blender has.
"""
import os
import struct
import threading
import zlib

from . import exr_header

try:
    import numpy
except ImportError:  # a Blender on a Python without it; the rest of the add-on works
    numpy = None

_SIZES = {0: 4, 1: 2, 2: 4}  # bytes of integers, halves and floats
_ZIP = {2: 1, 3: 16}  # lines per chunk of ZIPS and ZIP
_LINES = 16


def undo_zip(data):
    """The bytes that ZIP and ZIPS pack: differences of bytes, even ones before odd ones."""
    packed = numpy.frombuffer(zlib.decompress(data), numpy.uint8)
    order = numpy.cumsum(packed, dtype=numpy.uint8)
    order[1::2] ^= 128  # minus 128 for each byte after the first
    result = numpy.empty_like(order)
    half = (len(order) + 1) // 2
    result[0::2], result[1::2] = order[:half], order[half:]
    return result


def do_zip(values):
    order = numpy.concatenate([values[0::2], values[1::2]])
    packed = order.copy()
    packed[1:] = order[1:] - order[:-1] + numpy.uint8(128)
    return zlib.compress(packed.tobytes(), 4)


def _channel_table(part):
    """[(name, type)] in the order of the file."""
    value, at, table = part.attributes["channels"][1], 0, []
    while value[at] != 0:
        end = value.index(b"\0", at)
        kind, _, x_step, y_step = struct.unpack_from("<iIii", value, end + 1)
        if x_step != 1 or y_step != 1:
            raise exr_header.ExrError("subsampled channels")
        table.append((value[at:end].decode("utf-8", "replace"), kind))
        at = end + 17
    return table


def _find_colour(header, layer):
    """(index of the part, prefix of the names) of the pass Combined."""
    wanted = [layer + ".Combined."] if layer else [
        name[:-1] for name in header.channels if name.endswith(".Combined.R")]
    for index, part in enumerate(header.parts):
        for prefix in wanted:
            for name in part.channels:
                full = name if name.startswith(prefix) or not header.multi_part else \
                    f"{part.text('name')}.{name}"
                if full == prefix + "R":
                    return index, name[:-1]
    raise exr_header.ExrError(f"there is no pass {wanted[0] + 'R' if wanted else 'Combined'}")


class _Reader:
    def __init__(self, stream, header, index):
        self._stream = stream
        self._multi_part = header.multi_part
        self.part = header.parts[index]
        x0, y0, x1, y1 = struct.unpack("<4i", self.part.attributes["dataWindow"][1])
        self.y0, self.width, self.height = y0, x1 - x0 + 1, y1 - y0 + 1
        self._compression = self.part.attributes["compression"][1][0]
        self.table = _channel_table(self.part)
        self._row = self.width * sum(_SIZES[kind] for _, kind in self.table)
        first = sum(part.chunks for part in header.parts[:index])
        stream.seek(header.end + 8 * first)
        self._offsets = struct.unpack(f"<{self.part.chunks}Q", stream.read(8 * self.part.chunks))

    def columns(self, name):
        at = 0
        for other, kind in self.table:
            if other == name:
                return slice(at * self.width, (at + _SIZES[kind]) * self.width), kind
            at += _SIZES[kind]
        return None, None

    def rows(self):
        """All lines, as bytes, one chunk after the other."""
        lines = {0: 1, **_ZIP}.get(self._compression)
        if lines is None:
            raise exr_header.ExrError("only files with the codec ZIP, ZIPS or none can be read: "
                                      "set it in Output, or with Prepare")
        result = numpy.empty((self.height, self._row), numpy.uint8)
        for offset in self._offsets:
            self._stream.seek(offset + (4 if self._multi_part else 0))
            y, size = struct.unpack("<ii", self._stream.read(8))
            data = self._stream.read(size)
            count = min(lines, self.height - (y - self.y0))
            if count <= 0 or y < self.y0 or len(data) < size:
                raise exr_header.ExrError("the file is damaged")
            stored = size == count * self._row
            values = numpy.frombuffer(data, numpy.uint8) if stored else undo_zip(data)
            result[y - self.y0:y - self.y0 + count] = values.reshape(count, self._row)
        return result


def _attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def _write(file, channels, part, height, y0):
    """channels: [(name, type, rows of bytes)], sorted by name."""
    listed = b"".join(name.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, 1, 1)
                      for name, kind, _ in channels) + b"\0"
    header = struct.pack("<ii", 20000630, 2) + _attribute("channels", "chlist", listed)
    header += _attribute("compression", "compression", b"\3")
    for name, kind, fallback in (("dataWindow", "box2i", None), ("displayWindow", "box2i", None),
                                 ("lineOrder", "lineOrder", b"\0"),
                                 ("pixelAspectRatio", "float", struct.pack("<f", 1)),
                                 ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
                                 ("screenWindowWidth", "float", struct.pack("<f", 1))):
        known = part.attributes[name][1] if name in part.attributes else fallback
        header += _attribute(name, kind, b"\0" if name == "lineOrder" else known)
    header += b"\0"
    rows = numpy.concatenate([values for _, _, values in channels], axis=1)
    chunks = []
    for y in range(0, height, _LINES):
        plain = rows[y:y + _LINES].reshape(-1)
        packed = do_zip(plain)
        data = packed if len(packed) < len(plain) else plain.tobytes()
        chunks.append(struct.pack("<ii", y0 + y, len(data)) + data)
    at, offsets = len(header) + 8 * len(chunks), []
    for chunk in chunks:
        offsets.append(at)
        at += len(chunk)
    temporary = f"{file}.{os.getpid()}.tmp"
    with open(temporary, "wb") as stream:
        stream.write(header + struct.pack(f"<{len(offsets)}Q", *offsets) + b"".join(chunks))
    os.replace(temporary, file)


def flatten(source, target, layer=""):
    """Writes the pass Combined of a view layer as R, G, B and A. Raises ExrError or OSError."""
    if numpy is None:
        raise exr_header.ExrError("this Blender has no NumPy")
    header = exr_header.read(source)
    if header.tiled or header.deep:
        raise exr_header.ExrError("tiled and deep files cannot be read")
    index, prefix = _find_colour(header, layer)
    with open(source, "rb") as stream:
        try:
            reader = _Reader(stream, header, index)
            rows = reader.rows()
        except (struct.error, zlib.error, ValueError, KeyError) as error:
            raise exr_header.ExrError(str(error)) from error
    channels = []
    for letter in "ABGR":
        columns, kind = reader.columns(prefix + letter)
        if columns is not None:
            channels.append((letter, kind, rows[:, columns]))
    _write(target, channels, reader.part, reader.height, reader.y0)


class FlattenJob:
    """Flattens a sequence in a thread; the interface of job.Job. Files that are newer than their
    source stay."""

    def __init__(self, names, frames, target, layer=""):
        self.names, self.frames, self.target, self.layer = names, frames, target, layer
        self.state, self.error = "new", ""
        self._done = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._result = ""

    def start(self):
        os.makedirs(self.target.folder, exist_ok=True)
        self.state = "running"
        self._thread.start()

    def _is_new(self, frame):
        try:
            return os.path.getmtime(self.target.file(frame)) >= os.path.getmtime(
                self.names.file(frame))
        except OSError:
            return False

    def _run(self):
        try:
            for frame in self.frames:
                if self._stop.is_set():
                    self._result = "cancelled"
                    return
                if not self._is_new(frame):
                    flatten(self.names.file(frame), self.target.file(frame), self.layer)
                self._done += 1
            self._result = "finished"
        except (OSError, ValueError) as error:
            self.error = f"{self.names.name(self.frames[self._done])}: {error}"
            self._result = "failed"

    def poll(self):
        if self.state == "running" and not self._thread.is_alive():
            self.state = self._result or "failed"
        return self.state

    def cancel(self):
        self._stop.set()

    def detach(self):
        self._stop.set()

    def wait(self):
        self._thread.join()
        return self.poll()

    @property
    def fraction(self):
        return self._done / max(len(self.frames), 1)

    def status(self):
        return f"Writing plain frames: {self._done} of {len(self.frames)}"
