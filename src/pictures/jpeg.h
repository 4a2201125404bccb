// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// JPEG files in memory (stb_image, stb_image_write): reads baseline and progressive files, for
/// input images and textures; writes baseline files. Messages do not name the file; callers prepend
/// the name.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "stillray/status.h"

namespace stillray::pictures {

struct JpegHeader {
  int width = 0;
  int height = 0;
};

/// The size in the file's header; check it before decoding.
/// \return kBadData if the file is damaged, kUnsupported from 2 GiB on
Result<JpegHeader> ReadJpegHeader(std::span<const uint8_t> file);

using JpegPixels = std::unique_ptr<uint8_t, void (*)(void*)>;

/// Decodes to interleaved codes, rows from the top without padding.
/// \param channels  3 for RGB, 4 for RGBA with an alpha of 255
/// \param header    of this file
/// \return kBadData if the file is damaged or ends early
Result<JpegPixels> DecodeJpeg(std::span<const uint8_t> file, const JpegHeader& header,
                              int channels);

/// The largest width and height of a JPEG file (ITU-T T.81, B.2.2).
inline constexpr int kMaxJpegSide = 65535;

/// Encodes RGB as a baseline file in YCbCr without chroma subsampling.
/// \param rgb      width * height * 3 bytes, rows from the top
/// \param quality  91..100
/// \return kInternal if stb_image_write fails, kOutOfMemory
Result<std::string> EncodeJpeg(int width, int height, std::span<const uint8_t> rgb, int quality);

}  // namespace stillray::pictures
