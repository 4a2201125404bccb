// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Decoding of the picture formats that glTF textures come in.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stillray/status.h"

namespace stillray {

/// Largest width or height of a texture, in texels.
inline constexpr int kMaxTextureSide = 16384;

struct ImageInfo {
  enum class Format : uint8_t { kPng, kJpeg, kWebp };
  Format format = Format::kPng;
  int width = 0;
  int height = 0;
};

/// Reads the header only.
/// \return kBadData if the bytes are none of PNG, JPEG, WebP or claim a size that they cannot hold,
///         kUnsupported beyond kMaxTextureSide
Result<ImageInfo> InspectImage(std::span<const uint8_t> bytes);

/// Decodes to 8-bit RGBA, rows from the top: width * height * 4 bytes. Missing alpha is 255, grey
/// becomes red = green = blue, of 16-bit values the upper half is kept. Colour profiles are
/// ignored, as glTF asks. \return kBadData if the picture is damaged or ends early
Result<std::vector<uint8_t>> DecodeImage(std::span<const uint8_t> bytes, const ImageInfo& info);

}  // namespace stillray
