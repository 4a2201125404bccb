// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Compiled shaders are kept between runs, and damaged files are not given to drivers.
#include "gpu/pipeline_cache.h"

#include <gmock/gmock.h>

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "gpu/vulkan_test.h"

namespace stillray::pipeline_cache_test {
namespace {

using ::testing::IsEmpty;

using Bytes = std::vector<uint8_t>;

VkPhysicalDeviceProperties SomeDevice() {
  VkPhysicalDeviceProperties device = {};
  device.vendorID = 0x10de;
  device.deviceID = 0x2330;
  for (uint8_t i = 0; i < VK_UUID_SIZE; ++i) {
    device.pipelineCacheUUID[i] = i;
  }
  return device;
}

/// What a driver returns: the header that Vulkan defines, and something.
Bytes DataOf(const VkPhysicalDeviceProperties& device) {
  const uint32_t words[] = {32, 1, device.vendorID, device.deviceID};
  Bytes data(40, 7);
  std::memcpy(data.data(), words, sizeof(words));
  std::memcpy(data.data() + sizeof(words), device.pipelineCacheUUID, VK_UUID_SIZE);
  return data;
}

TEST(PipelineCache, FilesOfThisDriverAreReadWhole) {
  const VkPhysicalDeviceProperties device = SomeDevice();
  const Bytes data = DataOf(device);
  const Bytes file = gpu::PackPipelineCache(data);
  EXPECT_EQ(gpu::UnpackPipelineCache(file, device), data);
  for (size_t length = 0; length < file.size(); ++length) {
    EXPECT_THAT(gpu::UnpackPipelineCache({file.data(), length}, device), IsEmpty()) << length;
  }
  for (size_t at = 0; at < file.size(); ++at) {
    Bytes damaged = file;
    damaged[at] ^= 1;
    EXPECT_THAT(gpu::UnpackPipelineCache(damaged, device), IsEmpty()) << at;
  }
}

TEST(PipelineCache, FilesOfOthersAreIgnored) {
  const Bytes file = gpu::PackPipelineCache(DataOf(SomeDevice()));
  VkPhysicalDeviceProperties other = SomeDevice();
  other.deviceID = 1;
  EXPECT_THAT(gpu::UnpackPipelineCache(file, other), IsEmpty());
  other = SomeDevice();
  other.vendorID = 1;
  EXPECT_THAT(gpu::UnpackPipelineCache(file, other), IsEmpty());
  other = SomeDevice();
  other.pipelineCacheUUID[15] = 0;  // another version of the driver
  EXPECT_THAT(gpu::UnpackPipelineCache(file, other), IsEmpty());
}

TEST(PipelineCache, TheFolderIsThatOfTheUsersCaches) {
  const char* const home = std::getenv("HOME");
  const std::string kept = home != nullptr ? home : "";
  setenv("XDG_CACHE_HOME", "/tmp/cache", 1);
  EXPECT_EQ(gpu::UserCacheFolder(), "/tmp/cache/stillray");
  setenv("XDG_CACHE_HOME", "relative", 1);
  setenv("HOME", "/home/someone", 1);
  EXPECT_EQ(gpu::UserCacheFolder(), "/home/someone/.cache/stillray");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(gpu::UserCacheFolder(), "");
  if (home != nullptr) {
    setenv("HOME", kept.c_str(), 1);
  }
}

class KeptPipelines : public test::OwnVulkanTest {
 protected:
  std::shared_ptr<gpu::Device> Open() {
    return gpu::Device::Create(instance_, device_->info()).value();
  }
};

TEST_F(KeptPipelines, ADeviceBeginsWithTheFileOfTheLastOne) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("stillray_cache_" + std::to_string(::getpid()));
  gpu::SetPipelineCacheFolder(folder / "new");
  EXPECT_EQ(Open()->pipeline_cache().loaded_bytes(), 0u);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "new")) {
    files.push_back(entry.path());
  }
  ASSERT_EQ(files.size(), 1u);
  EXPECT_GE(Open()->pipeline_cache().loaded_bytes(), 32u);
  std::filesystem::resize_file(files[0], 20);
  EXPECT_EQ(Open()->pipeline_cache().loaded_bytes(), 0u);
  EXPECT_GE(Open()->pipeline_cache().loaded_bytes(), 32u);  // written again
  gpu::SetPipelineCacheFolder("/proc/no/such");             // nothing can be written there
  EXPECT_EQ(Open()->pipeline_cache().loaded_bytes(), 0u);
  gpu::SetPipelineCacheFolder({});
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stillray::pipeline_cache_test
