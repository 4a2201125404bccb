// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The decoders behind ReadImage, one per format. All are safe on any bytes; `name` is the file's
/// name in messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray::io {

/// Rows of an image that a task decodes at once.
inline constexpr int kDecodedRows = 64;

/// PNG of any kind as linear RGB; values are decoded as sRGB, regardless of colour chunks.
Result<Image3> DecodePng(const uint8_t* data, size_t size, const std::string& name);

/// Baseline and progressive JPEG as linear RGB.
Result<Image3> DecodeJpeg(const uint8_t* data, size_t size, const std::string& name);

/// Radiance RGBE, flat or run-length encoded, as the radiance before EXPOSURE was multiplied in.
/// Rows must run along x.
Result<Image3> DecodeHdr(const uint8_t* data, size_t size, const std::string& name);

/// Linear values of the 256 sRGB codes.
const std::array<float, 256>& SrgbTable8();

}  // namespace stillray::io
