# SPDX-FileCopyrightText: the stillray developers
# SPDX-License-Identifier: Apache-2.0
"""8-bit PNG pictures with nothing but Python's standard library."""

import struct
import zlib


def _chunk(kind, data):
    return (struct.pack(">I", len(data)) + kind + data +
            struct.pack(">I", zlib.crc32(kind + data)))


def write_png(path, width, height, colour_at):
    """Writes a picture whose pixels are the (r, g, b) that colour_at(x, y) returns."""
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        for x in range(width):
            rows += bytes(colour_at(x, y))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) +
                   _chunk(b"IDAT", zlib.compress(bytes(rows))) + _chunk(b"IEND", b""))


class Picture:
    """A decoded RGB or RGBA picture that is not interlaced, as browsers make them."""

    def __init__(self, png):
        position = 8
        data = b""
        while position < len(png):
            (size,) = struct.unpack_from(">I", png, position)
            kind = png[position + 4:position + 8]
            body = png[position + 8:position + 8 + size]
            if kind == b"IHDR":
                self.width, self.height, depth, colour, _, _, interlace = struct.unpack(
                    ">IIBBBBB", body)
                if depth != 8 or colour not in (2, 6) or interlace:
                    raise ValueError(f"depth {depth}, colour type {colour}: not expected")
                self.channels = 3 if colour == 2 else 4
            elif kind == b"IDAT":
                data += body
            position += 12 + size
        self.rows = self._unfilter(zlib.decompress(data))

    def _unfilter(self, data):
        stride = self.width * self.channels
        previous = bytearray(stride)
        rows = []
        for y in range(self.height):
            start = y * (stride + 1)
            row = bytearray(data[start + 1:start + 1 + stride])
            self._unfilter_row(data[start], row, previous)
            rows.append(row)
            previous = row
        return rows

    def _unfilter_row(self, kind, row, above):
        step = self.channels
        if kind == 1:
            for i in range(step, len(row)):
                row[i] = (row[i] + row[i - step]) & 255
        elif kind == 2:
            for i, up in enumerate(above):
                row[i] = (row[i] + up) & 255
        elif kind == 3:
            for i, up in enumerate(above):
                left = row[i - step] if i >= step else 0
                row[i] = (row[i] + (left + up) // 2) & 255
        elif kind == 4:
            for i, up in enumerate(above):
                left, corner = (row[i - step], above[i - step]) if i >= step else (0, 0)
                estimate = left + up - corner
                distances = (abs(estimate - left), abs(estimate - up), abs(estimate - corner))
                nearest = distances.index(min(distances))
                row[i] = (row[i] + (left, up, corner)[nearest]) & 255

    def at(self, x, y):
        """(r, g, b) of a pixel."""
        start = round(x) * self.channels
        return tuple(self.rows[round(y)][start:start + 3])
