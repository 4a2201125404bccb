// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Shaders of a folder in place of those in the program.
#include "gpu/shader_folder.h"

#include <gmock/gmock.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "gpu/shared_pipelines.h"
#include "gpu/vulkan_test.h"

namespace shaders {
extern const std::uint32_t kDoubleValues[];
extern const std::size_t kDoubleValuesWords;
}  // namespace shaders

namespace stillray::shader_folder_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ShaderFolder : public test::OwnVulkanTest {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("stillray_shaders_" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder_);
    setenv(gpu::kShaderFolderVariable, folder_.c_str(), 1);
    test::OwnVulkanTest::SetUp();
  }
  void TearDown() override {
    unsetenv(gpu::kShaderFolderVariable);
    std::filesystem::remove_all(folder_);
    test::OwnVulkanTest::TearDown();
  }

  static std::span<const uint32_t> Embedded() {
    return {shaders::kDoubleValues, shaders::kDoubleValuesWords};
  }
  void Write(std::span<const uint32_t> words, size_t bytes) const {
    std::ofstream file(folder_ / "DoubleValues.spv", std::ios::binary);
    file.write(reinterpret_cast<const char*>(words.data()), static_cast<std::streamsize>(bytes));
  }
  /// The message of making the pipeline; empty: it was made.
  std::string Make() const {
    gpu::DescriptorSets sets(&device_->context());
    const VkDescriptorSetLayout layout = *sets.Layout({1, 1, 0, 0});
    return gpu::Pipeline::Create(&device_->context(),
                                 {"double_values", Embedded(), {&layout, 1}, sizeof(float), {}})
        .status()
        .message();
  }

  std::filesystem::path folder_;
};

TEST_F(ShaderFolder, WithoutAFileTheEmbeddedShaderIsUsed) {
  EXPECT_THAT(*gpu::ReplacementOf(Embedded()), IsEmpty());
  EXPECT_THAT(gpu::ReplacedShaders(), IsEmpty());
  EXPECT_EQ(Make(), "");
  unsetenv(gpu::kShaderFolderVariable);
  EXPECT_THAT(*gpu::ReplacementOf(Embedded()), IsEmpty());
}

TEST_F(ShaderFolder, AFileReplacesTheShaderOfItsName) {
  std::vector<uint32_t> words(Embedded().begin(), Embedded().end());
  words[2] = 12345;  // the generator, which has no meaning
  Write(words, words.size() * 4);
  EXPECT_EQ(*gpu::ReplacementOf(Embedded()), words);
  EXPECT_THAT(gpu::ReplacedShaders(), ElementsAre("DoubleValues"));
  EXPECT_EQ(Make(), "");
}

// The code decides which pipelines are shared, not the name.
TEST_F(ShaderFolder, AFileThatChangesMakesAnotherPipeline) {
  const auto created = [&] { return device_->context().pipelines->created(); };
  std::vector<uint32_t> words(Embedded().begin(), Embedded().end());
  EXPECT_EQ(Make(), "");
  EXPECT_EQ(created(), 1u);
  Write(words, words.size() * 4);  // the same as the program's
  EXPECT_EQ(Make(), "");
  EXPECT_EQ(created(), 1u);
  for (const uint32_t generator : {12345u, 54321u}) {
    words[2] = generator;
    Write(words, words.size() * 4);
    EXPECT_EQ(Make(), "");
  }
  EXPECT_EQ(created(), 3u);
  std::filesystem::remove(folder_ / "DoubleValues.spv");
  EXPECT_EQ(Make(), "");
  EXPECT_EQ(created(), 3u);
}

TEST_F(ShaderFolder, DamageIsAnError) {
  std::vector<uint32_t> words(Embedded().begin(), Embedded().end());
  Write(words, 13);
  EXPECT_THAT(Make(), HasSubstr("DoubleValues.spv has 13 bytes, expected SPIR-V: whole words"));
  Write(words, words.size() * 4 - 4);
  EXPECT_THAT(Make(), HasSubstr("is damaged: its last word is"));
  Write(words, words.size() * 4 / 2);
  EXPECT_THAT(Make(), HasSubstr("DoubleValues.spv is damaged: "));
  std::vector<uint32_t> longer = words;
  longer.back() = 0x00020038;  // an instruction of two words, of which one is there
  Write(longer, longer.size() * 4);
  EXPECT_THAT(Make(), HasSubstr("is damaged: the instruction at word"));
  words[0] = 0x7f454c46;
  Write(words, words.size() * 4);
  EXPECT_THAT(Make(), HasSubstr("begins with 0x7f454c46, expected SPIR-V: 0x07230203"));
  EXPECT_EQ(gpu::ReplacementOf(Embedded()).status().code(), StatusCode::kBadData);
}

TEST_F(ShaderFolder, AMissingFolderIsAnError) {
  setenv(gpu::kShaderFolderVariable, "/no/such/folder", 1);
  EXPECT_THAT(Make(), HasSubstr("STILLRAY_SHADER_DIR is '/no/such/folder', expected a folder"));
  EXPECT_EQ(gpu::ReplacementOf(Embedded()).status().code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace stillray::shader_folder_test
