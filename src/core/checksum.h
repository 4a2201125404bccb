// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A checksum that finds damage by accident, not by intent.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>

namespace stillray {

/// The checksum of no bytes.
inline constexpr uint64_t kEmptyChecksum = 0xcbf29ce484222325u;

/// FNV-1a, by words of eight bytes in the byte order of the machine. A change within one word
/// always changes the result. \param sum  of the bytes before; these must be a multiple of eight
/// where sums are to be the same
///             as in one call
inline uint64_t AddToChecksum(std::span<const uint8_t> bytes, uint64_t sum = kEmptyChecksum) {
  for (size_t at = 0; at < bytes.size(); at += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof(word), bytes.size() - at));
    sum = (sum ^ word) * 0x100000001b3u;
    sum ^= sum >> 32;  // the upper bits of words count for the lower ones of the sum
  }
  return sum;
}

}  // namespace stillray
