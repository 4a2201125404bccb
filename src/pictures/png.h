// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// PNG files in memory (libspng, libdeflate), for input images, textures, previews and the report.
/// Messages do not name the file; callers prepend the name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stillray/status.h"

namespace stillray::pictures {

struct PngHeader {
  uint32_t width = 0;
  uint32_t height = 0;
  int bit_depth = 0;  ///< of a channel, or of a palette index
};

/// The size in the file's header; check it before allocating the pixels. The rest of the file is
/// not read.
/// \return kBadData if the bytes do not begin with the header of a PNG file
Result<PngHeader> ReadPngHeader(std::span<const uint8_t> file);

/// Interleaved channels, rows from the top without padding; 16-bit codes in the machine's order.
enum class PngPixels : uint8_t {
  kRgb8,   ///< alpha is dropped
  kRgba8,  ///< missing alpha is 255, or 0 for the transparent colour
  kRgba16  ///< missing alpha is 65535
};

/// Decodes to the channels of \p layout: grey becomes red = green = blue, of 16-bit codes kRgb8 and
/// kRgba8 keep the upper half. Colour profiles are ignored.
/// \param pixels  `size` bytes: exactly the size of width * height pixels
/// \return kBadData if the file is damaged, ends early, or its pixels take another size
Status DecodePng(std::span<const uint8_t> file, PngPixels layout, void* pixels, size_t size);

/// Encodes 8-bit RGB as a file marked as sRGB.
/// \param rgb  width * height * 3 bytes, rows from the top
/// \return kOutOfMemory
Result<std::string> EncodePng(int width, int height, std::span<const uint8_t> rgb);

/// Encodes one palette index per pixel as a file marked as sRGB.
/// \param indices  width * height, rows from the top
Result<std::string> EncodePalettePng(int width, int height, std::span<const uint8_t> indices,
                                     std::span<const std::array<uint8_t, 3>, 256> palette);

}  // namespace stillray::pictures
