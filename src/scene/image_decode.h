// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Decoders of the image formats of glTF textures.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stillray/status.h"

namespace stillray {

/// Maximum width or height of a texture, in texels.
inline constexpr int kMaxTextureSide = 16384;

struct ImageInfo {
  enum class Format : uint8_t { kPng, kJpeg, kWebp };
  Format format = Format::kPng;
  int width = 0;
  int height = 0;
};

/// Reads the header only.
/// \return kBadData if the bytes are not PNG, JPEG or WebP or specify a size that cannot be stored
///     in so few bytes, kUnsupported beyond kMaxTextureSide
Result<ImageInfo> InspectImage(std::span<const uint8_t> bytes);

/// Decodes to 8-bit RGBA, rows from the top: width * height * 4 bytes. Missing alpha is 255, grey
/// is replicated to red, green and blue, 16-bit values are truncated to their upper byte. Colour
/// profiles are ignored, as glTF requires. \return kBadData if the image is damaged or truncated
Result<std::vector<uint8_t>> DecodeImage(std::span<const uint8_t> bytes, const ImageInfo& info);

}  // namespace stillray
