// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The interface of interface_example.comp, as its source declares it, and of damaged modules.
#include "gpu/spirv_interface.h"

#include <gmock/gmock.h>

#include <cstdint>
#include <string>
#include <vector>

namespace shaders {
extern const std::uint32_t kInterfaceExample[];
extern const std::size_t kInterfaceExampleWords;
}  // namespace shaders

namespace stillray::spirv_interface_test {
namespace {

using gpu::BindingKind;
using gpu::BlockMember;
using gpu::ShaderBinding;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<uint32_t> Code() {
  return {shaders::kInterfaceExample, shaders::kInterfaceExample + shaders::kInterfaceExampleWords};
}

gpu::ShaderInterface Read(const std::map<uint32_t, uint32_t>& constants = {}) {
  const std::vector<uint32_t> code = Code();
  const Result<gpu::ShaderInterface> read = gpu::ReadInterface(code, constants);
  EXPECT_TRUE(read.ok()) << read.status().message();
  return read.ok() ? *read : gpu::ShaderInterface();
}

/// "set.binding kind access texels format array"
std::string Text(const ShaderBinding& b) {
  const char* const kinds[] = {"sampled", "stored", "uniform", "buffer"};
  return std::to_string(b.set) + "." + std::to_string(b.binding) + " " +
         kinds[static_cast<int>(b.kind)] + " " + (b.reads ? "r" : "") + (b.writes ? "w" : "") +
         (b.texels.empty() ? "" : " " + b.texels) + (b.format.empty() ? "" : " " + b.format) +
         (b.is_array ? " array" : "");
}

std::string Text(const BlockMember& m) {
  std::string text =
      m.type + " " + std::to_string(m.offset) + "+" + std::to_string(m.bytes) + " at";
  for (const uint32_t index : m.path) {
    text += " " + std::to_string(index);
  }
  return text;
}

template <typename List>
std::vector<std::string> Texts(const List& list) {
  std::vector<std::string> texts;
  for (const auto& entry : list) {
    texts.push_back(Text(entry));
  }
  return texts;
}

TEST(SpirvInterface, HasTheBindingsThatTheEntryPointUses) {
  EXPECT_THAT(
      Texts(Read().bindings),
      ElementsAre("0.0 sampled r float", "0.1 sampled r uint array", "0.2 stored w uint rg32ui",
                  "0.3 stored rw float r16f array", "0.4 uniform r", "1.0 buffer r", "1.1 buffer w",
                  "1.2 buffer rw", "1.3 sampled r float"));
}

TEST(SpirvInterface, HasTheMembersOfBlocks) {
  const gpu::ShaderInterface interface = Read();
  ASSERT_EQ(interface.bindings.size(), 9u);
  // std140: a structure begins at a multiple of 16 bytes, and so does what follows it.
  EXPECT_THAT(Texts(interface.bindings[4].members),
              ElementsAre("int 0+4 at 0", "float 16+4 at 1 0", "float 20+4 at 1 1",
                          "int 24+4 at 1 2", "uint 28+4 at 1 3", "float 32+4 at 2"));
  EXPECT_THAT(Texts(interface.bindings[5].members),
              ElementsAre("vec2[3] 0+24 at 0", "float[] 24+0 at 1"));
  EXPECT_THAT(Texts(interface.bindings[6].members), ElementsAre("uvec4[] 0+0 at 0"));
  EXPECT_THAT(Texts(interface.push), ElementsAre("float 0+4 at 0", "int 4+4 at 1"));
}

TEST(SpirvInterface, HasConstantsWorkgroupsAndSharedMemory) {
  const gpu::ShaderInterface interface = Read();
  EXPECT_THAT(interface.local_size, ElementsAre(16u, 4u, 1u));
  ASSERT_EQ(interface.constants.size(), 3u);
  const auto expect = [&](size_t i, uint32_t id, const char* type, uint32_t value) {
    EXPECT_EQ(interface.constants[i].id, id);
    EXPECT_EQ(interface.constants[i].type, type);
    EXPECT_EQ(interface.constants[i].value, value);
  };
  expect(0, 0, "bool", 1);
  expect(1, 3, "int", 5);
  expect(2, 4, "float", 0x3fc00000);  // 1.5
  EXPECT_EQ(interface.shared_bytes, 4u * (5 + 2) * 16 + 4);
  EXPECT_EQ(Read({{3, 9}}).shared_bytes, 4u * (9 + 2) * 16 + 4);
}

TEST(SpirvInterface, DamagedModulesAreErrors) {
  const auto message = [](const std::vector<uint32_t>& code) {
    const Result<gpu::ShaderInterface> read = gpu::ReadInterface(code);
    EXPECT_FALSE(read.ok());
    return read.ok() ? "" : read.status().message();
  };
  EXPECT_THAT(message({}), HasSubstr("has no header"));
  std::vector<uint32_t> code = Code();
  code[0] = 1;
  EXPECT_THAT(message(code), HasSubstr("has no header"));
  code = Code();
  code.resize(7);  // the header, and a capability
  EXPECT_THAT(message(code), HasSubstr("has no entry point"));
  code = Code();
  code[5] = 0;
  EXPECT_THAT(message(code), HasSubstr("at word 5 has 0 words"));
  // Wherever a module is cut off: a message or an interface, and no access beyond it.
  for (size_t words = 5; words < Code().size(); ++words) {
    code = Code();
    code.resize(words);
    code.shrink_to_fit();
    const Result<gpu::ShaderInterface> read = gpu::ReadInterface(code);
    EXPECT_TRUE(read.ok() || !read.status().message().empty());
  }
}

}  // namespace
}  // namespace stillray::spirv_interface_test
