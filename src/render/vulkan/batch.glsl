// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Image positions of a batch's pixels. Needs trace_shared.h, `batch` and `listed_pixels`.
uvec2 PixelOf(uint number) {
  if (batch.listed != 0u) {
    uint at = listed_pixels[number];
    return uvec2(at & 0xffffu, at >> 16);
  }
  uint width = uint(batch.width);
  return uvec2(uint(batch.x) + ColumnInBatch(width, number),
               uint(batch.y) + RowInBatch(width, number));
}
