// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Limits on the sizes in the header of an image file, checked before memory is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "stillray/status.h"

namespace stillray::io {

/// Maximum width and height in pixels: a larger size is treated as damage or an attack.
inline constexpr int64_t kMaxSide = 32768;
/// Maximum bytes of one decoded image file, all channels together.
inline constexpr uint64_t kMaxDecodedBytes = uint64_t{8} << 30;
/// Maximum bytes of an image file on disk.
inline constexpr size_t kMaxFileBytes = size_t{4} << 30;

/// The largest expansion of deflate: a match of 258 bytes coded in 2 bits.
inline constexpr uint64_t kMaxDeflateRatio = 1032;

/// \return kUnsupported above kMaxSide, kBadData below 1
Status CheckImageSize(const std::string& name, int64_t width, int64_t height);

/// Rejects a file whose header states more pixels than its bytes can encode, so that a small file
/// cannot exhaust memory.
/// \param max_ratio  largest number of decoded bytes per byte of the file under its compression
Status CheckDecodedSize(const std::string& name, uint64_t decoded_bytes, uint64_t file_bytes,
                        uint64_t max_ratio);

}  // namespace stillray::io
