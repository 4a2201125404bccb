# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""Reads and writes EXR files as stillray does, as NumPy arrays; reads its PNG files, and writes small
ones.
"""
import struct
import zlib

import numpy as np

EXR_MAGIC = b"\x76\x2f\x31\x01"
NOT_FLAT, LONG_NAMES = 0x1a, 0x04  # of the second byte of the version: tiles, deep, parts; names > 31
EXR_TYPES = [np.dtype("<u4"), np.dtype("<f2"), np.dtype("<f4")]
NONE, ZIPS, ZIP = 0, 2, 3  # compressions of EXR; stillray writes ZIP
LINES = {NONE: 1, ZIPS: 1, ZIP: 16}  # per block


def _entries(data):
    """Name, type and bytes of each attribute of the first header, and where it ends."""
    at, found = 8, []
    while data[at] != 0:
        name_end = data.index(b"\0", at)
        type_end = data.index(b"\0", name_end + 1)
        size = struct.unpack_from("<i", data, type_end + 1)[0]
        start = type_end + 5
        found.append((data[at:name_end].decode(), data[name_end + 1:type_end].decode(), data[start:start + size]))
        at = start + size
    return found, at + 1


def _attributes(data):
    """Name to bytes of the first header, and where it ends."""
    found, end = _entries(data)
    return {name: content for name, _, content in found}, end


def read_texts(path):
    """The text attributes of an EXR file."""
    return {name: content.decode() for name, kind, content in _entries(path.read_bytes())[0] if kind == "string"}


def _channels(data):
    at, found = 0, []
    while data[at] != 0:
        end = data.index(b"\0", at)
        found.append((data[at:end].decode(), EXR_TYPES[struct.unpack_from("<i", data, end + 1)[0]]))
        at = end + 17
    return found


def _undo_zip(block, size):
    if len(block) == size:  # stored as it is where compression does not pay
        return block
    coded = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    coded[1:] -= 128
    plain = (np.cumsum(coded) & 255).astype(np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = plain[:half], plain[half:]
    return out.tobytes()


def read_exr(path):
    """Channel name to an array (height, width), of a file with one part, scanlines, and ZIP, ZIPS or no
    compression.
    """
    data = path.read_bytes()
    if data[:5] != EXR_MAGIC + b"\2" or data[5] & NOT_FLAT:
        raise ValueError(f"{path}: expected an EXR file with one part and scanlines")
    attributes, at = _attributes(data)
    compression = attributes["compression"][0]
    if compression not in LINES:
        raise ValueError(f"{path}: compression {compression}, expected none (0), ZIPS (2) or ZIP (3)")
    block_lines = LINES[compression]
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(attributes["channels"])
    line_bytes = sum(dtype.itemsize for _, dtype in channels) * width
    planes = {name: np.empty((height, width), dtype) for name, dtype in channels}
    blocks = (height + block_lines - 1) // block_lines
    for offset in struct.unpack_from(f"<{blocks}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(block_lines, y1 + 1 - y)
        block = _undo_zip(data[offset + 8:offset + 8 + size], lines * line_bytes)
        where = 0
        for line in range(y - y0, y - y0 + lines):
            for name, dtype in channels:
                planes[name][line] = np.frombuffer(block, dtype, width, where)
                where += dtype.itemsize * width
    return planes


def _do_zip(raw):
    plain = np.frombuffer(raw, np.uint8)
    coded = np.concatenate([plain[0::2], plain[1::2]]).astype(np.int16)
    coded[1:] = coded[1:] - coded[:-1] + 128
    packed = zlib.compress((coded & 255).astype(np.uint8).tobytes(), 4)
    return packed if len(packed) < len(raw) else raw


def write_exr(path, planes, texts=None):
    """\param planes  channel name to an array (height, width): uint32, float16 or float32
    \param texts   text attributes, by name
    """
    names = sorted(planes)
    height, width = planes[names[0]].shape
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(
        name.encode() + b"\0" + struct.pack("<iB3xii", EXR_TYPES.index(planes[name].dtype), 0, 1, 1)
        for name in names) + b"\0"
    texts = [(name, "string", text.encode()) for name, text in (texts or {}).items()]
    flags = LONG_NAMES if max(len(name) for name in names + [text[0] for text in texts]) > 31 else 0
    header = EXR_MAGIC + bytes([2, flags, 0, 0]) + b"".join(
        f"{name}\0{kind}\0".encode() + struct.pack("<i", len(content)) + content
        for name, kind, content in [
            ("channels", "chlist", channels), ("compression", "compression", bytes([ZIP])),
            ("dataWindow", "box2i", box), ("displayWindow", "box2i", box),
            ("lineOrder", "lineOrder", b"\0"), ("pixelAspectRatio", "float", struct.pack("<f", 1)),
            ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
            ("screenWindowWidth", "float", struct.pack("<f", 1))] + texts) + b"\0"
    blocks = []
    for top in range(0, height, LINES[ZIP]):
        lines = range(top, min(top + LINES[ZIP], height))
        raw = b"".join(planes[name][line].tobytes() for line in lines for name in names)
        packed = _do_zip(raw)
        blocks.append(struct.pack("<ii", top, len(packed)) + packed)
    offsets, at = [], len(header) + 8 * len(blocks)
    for block in blocks:
        offsets.append(at)
        at += len(block)
    path.write_bytes(header + struct.pack(f"<{len(offsets)}Q", *offsets) + b"".join(blocks))


def layer(planes, name, letters="RGB"):
    """(height, width, letters) as float32 of the channels NAME.LETTER, or None without them."""
    names = [f"{name}.{letter}" if name else letter for letter in letters]
    if any(n not in planes for n in names):
        return None
    return np.stack([planes[n].astype(np.float32) for n in names], axis=2)


def _filtered_rows(rows, step):
    """Each row under the PNG filter with the smallest sum of absolute differences."""
    above = np.zeros_like(rows)
    above[1:] = rows[:-1]
    left, corner = np.zeros_like(rows), np.zeros_like(rows)
    left[:, step:], corner[:, step:] = rows[:, :-step], above[:, :-step]
    a, b, c = (x.astype(np.int16) for x in (left, above, corner))
    near = np.abs(np.stack([b - c, a - c, a + b - 2 * c]))
    paeth = np.where((near[0] <= near[1]) & (near[0] <= near[2]), a,
                     np.where(near[1] <= near[2], b, c)).astype(np.uint8)
    predicted = [np.zeros_like(rows), left, above, ((a + b) // 2).astype(np.uint8), paeth]
    coded = np.stack([rows - p for p in predicted])
    cost = np.abs(coded.view(np.int8).astype(np.int32)).sum(axis=2)
    best = cost.argmin(axis=0)
    chosen = coded[best, np.arange(len(rows))]
    return np.concatenate([best[:, None].astype(np.uint8), chosen], axis=1).tobytes()


def write_png(path, picture):
    """\\param picture  (height, width, 3) uint8"""
    height, width, _ = picture.shape
    rows = np.ascontiguousarray(picture).reshape(height, width * 3)
    coded = min((zlib.compress(raw, 9) for raw in (
        _filtered_rows(rows, 3), np.insert(rows, 0, 0, axis=1).tobytes())), key=len)

    def chunk(kind, content):
        return (struct.pack(">I", len(content)) + kind + content +
                struct.pack(">I", zlib.crc32(kind + content)))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", coded) +
                     chunk(b"IEND", b""))


def _undo_filter(kind, row, above, step):
    out = bytearray(row)
    for i in range(len(out)):
        a = out[i - step] if i >= step else 0
        b = above[i]
        c = above[i - step] if i >= step else 0
        p = a + b - c
        paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
        out[i] = (out[i] + (0, a, b, (a + b) // 2, paeth)[kind]) & 255
    return out


def read_png(path):
    """(height, width, 3) uint8 of an RGB file of eight bits."""
    data, at, content = path.read_bytes(), 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height, *form = struct.unpack_from(">IIBBBBB", data, at + 8)
        elif kind == b"IDAT":
            content += data[at + 8:at + 8 + size]
        at += size + 12
    if form[:2] != [8, 2] or form[4] != 0:
        raise ValueError(f"{path}: expected an RGB file of eight bits, not interlaced")
    raw, stride = zlib.decompress(content), width * 3 + 1
    above, rows = bytes(width * 3), []
    for y in range(height):
        line = raw[y * stride:(y + 1) * stride]
        above = _undo_filter(line[0], line[1:], above, 3)
        rows.append(bytes(above))
    return np.frombuffer(b"".join(rows), np.uint8).reshape(height, width, 3)
