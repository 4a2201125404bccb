// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A sequence of byte blocks, each preceded by its size: the parts of a history.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace stillray {

/// Appends the size of `block` as 8 bytes, and the block.
inline void AppendBlock(std::span<const uint8_t> block, std::vector<uint8_t>* bytes) {
  const uint64_t size = block.size();
  uint8_t raw[sizeof(size)];
  std::memcpy(raw, &size, sizeof(size));
  bytes->insert(bytes->end(), raw, raw + sizeof(size));
  bytes->insert(bytes->end(), block.begin(), block.end());
}

/// Removes a block and its size from the front. \return false if there is no complete block
inline bool TakeBlock(std::span<const uint8_t>* bytes, std::span<const uint8_t>* block) {
  uint64_t size = 0;
  if (bytes->size() < sizeof(size)) {
    return false;
  }
  std::memcpy(&size, bytes->data(), sizeof(size));
  *bytes = bytes->subspan(sizeof(size));
  if (size > bytes->size()) {
    return false;
  }
  *block = bytes->first(size);
  *bytes = bytes->subspan(size);
  return true;
}

}  // namespace stillray
