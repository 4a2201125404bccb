// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Uniform blocks of shaders as storage blocks. All tests of shaders on software drivers run such.
#include "gpu/uniform_blocks.h"

#include <gmock/gmock.h>

#include <array>
#include <cstdint>
#include <vector>

namespace shaders {
extern const std::uint32_t kDoubleValues[];
extern const std::size_t kDoubleValuesWords;
}  // namespace shaders

namespace stillray::uniform_blocks_test {
namespace {

using ::testing::ElementsAreArray;

constexpr uint32_t Operation(uint32_t code, uint32_t words) {
  return words << 16 | code;
}

constexpr std::array<uint32_t, 5> kHeader = {0x07230203, 0x00010300, 0, 20, 0};

std::vector<uint32_t> Module(std::initializer_list<std::vector<uint32_t>> instructions) {
  std::vector<uint32_t> words(kHeader.begin(), kHeader.end());
  for (const std::vector<uint32_t>& instruction : instructions) {
    words.insert(words.end(), instruction.begin(), instruction.end());
  }
  return words;
}

// A block %7 with one member in variable %9 of the storage class `block`, and an output %10.
const std::vector<uint32_t> kBinding = {Operation(71, 4), 9, 33, 2};
const std::vector<uint32_t> kBlock = {Operation(71, 3), 7, 2};
const std::vector<uint32_t> kStruct = {Operation(30, 3), 7, 6};
std::vector<uint32_t> Pointer(uint32_t storage_class) {
  return {Operation(32, 4), 8, storage_class, 7};
}
std::vector<uint32_t> Variable(uint32_t storage_class) {
  return {Operation(59, 4), 8, 9, storage_class};
}
const std::vector<uint32_t> kOutput = {Operation(59, 4), 11, 10, 3};

TEST(UniformBlocks, BecomeStorageBlocksThatAreOnlyRead) {
  const std::vector<uint32_t> uniform =
      Module({kBinding, kBlock, kStruct, Pointer(2), Variable(2), kOutput});
  const std::vector<uint32_t> only_read = {Operation(71, 3), 9, 24};
  const std::vector<uint32_t> storage =
      Module({only_read, kBinding, kBlock, kStruct, Pointer(12), Variable(12), kOutput});
  EXPECT_THAT(gpu::WithStorageBlocks(uniform), ElementsAreArray(storage));
  // Once they are, nothing is left to do.
  EXPECT_THAT(gpu::WithStorageBlocks(storage), ElementsAreArray(storage));
}

TEST(UniformBlocks, ShadersWithoutStayAsTheyAre) {
  const std::span<const uint32_t> code(shaders::kDoubleValues, shaders::kDoubleValuesWords);
  EXPECT_THAT(gpu::WithStorageBlocks(code), ElementsAreArray(code));
  EXPECT_THAT(gpu::WithStorageBlocks(kHeader), ElementsAreArray(kHeader));
}

TEST(UniformBlocks, WhatIsNoShaderStaysAsItIs) {
  const std::vector<uint32_t> none;
  EXPECT_THAT(gpu::WithStorageBlocks(none), ElementsAreArray(none));
  std::vector<uint32_t> cut = Module({kBinding, kBlock, kStruct, Pointer(2), Variable(2)});
  cut.pop_back();
  EXPECT_THAT(gpu::WithStorageBlocks(cut), ElementsAreArray(cut));
  const std::vector<uint32_t> endless = Module({Pointer(2), {Operation(59, 0), 8, 9, 2}});
  EXPECT_THAT(gpu::WithStorageBlocks(endless), ElementsAreArray(endless));
}

}  // namespace
}  // namespace stillray::uniform_blocks_test
