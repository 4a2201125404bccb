// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A checksum that detects accidental damage, not tampering.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>

namespace stillray {

/// The checksum of an empty range.
inline constexpr uint64_t kEmptyChecksum = 0xcbf29ce484222325u;

/// FNV-1a over words of eight bytes in the machine's byte order. Changing a single word always
/// changes the result.
/// \param sum  checksum of the preceding bytes. Splitting a range gives an equal sum only if every
///     part but the last is a multiple of eight bytes.
inline uint64_t AddToChecksum(std::span<const uint8_t> bytes, uint64_t sum = kEmptyChecksum) {
  for (size_t at = 0; at < bytes.size(); at += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof(word), bytes.size() - at));
    sum = (sum ^ word) * 0x100000001b3u;
    sum ^= sum >> 32;  // carries the high bits of a word into the low bits of the sum
  }
  return sum;
}

}  // namespace stillray
