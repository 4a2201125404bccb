// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "gpu/uniform_blocks.h"

#include <cstddef>

namespace stillray::gpu {
namespace {

// Numbers of the SPIR-V specification, sections "Instructions", "Storage Class" and "Decoration".
constexpr size_t kHeaderWords = 5;
constexpr uint32_t kOpTypePointer = 32;
constexpr uint32_t kOpVariable = 59;
constexpr uint32_t kOpDecorate = 71;
constexpr uint32_t kOpMemberDecorate = 72;
constexpr uint32_t kUniform = 2;
constexpr uint32_t kStorageBuffer = 12;
constexpr uint32_t kNonWritable = 24;

}  // namespace

std::vector<uint32_t> WithStorageBlocks(std::span<const uint32_t> code) {
  std::vector<uint32_t> words(code.begin(), code.end());
  std::vector<uint32_t> read_only;  // decorations that mark the variables read-only
  size_t decorations = 0;           // offset of the first decoration
  size_t length = 0;
  for (size_t at = kHeaderWords; at < words.size(); at += length) {
    length = words[at] >> 16;
    if (length == 0 || length > words.size() - at) {
      return {code.begin(), code.end()};
    }
    const uint32_t operation = words[at] & 0xffffu;
    if (operation == kOpTypePointer && length == 4 && words[at + 2] == kUniform) {
      words[at + 2] = kStorageBuffer;
    } else if (operation == kOpVariable && length >= 4 && words[at + 3] == kUniform) {
      words[at + 3] = kStorageBuffer;
      read_only.insert(read_only.end(), {3u << 16 | kOpDecorate, words[at + 2], kNonWritable});
    } else if ((operation == kOpDecorate || operation == kOpMemberDecorate) && decorations == 0) {
      decorations = at;
    }
  }
  if (decorations != 0) {  // any variable with a binding is decorated
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(decorations), read_only.begin(),
                 read_only.end());
  }
  return words;
}

}  // namespace stillray::gpu
