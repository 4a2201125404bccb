// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Memory that other APIs import: one device reads the data that another one wrote.
#include "gpu/shared_memory.h"

#include <gmock/gmock.h>

#include "gpu/imported_bytes.h"
#include "gpu/vulkan_test.h"

namespace stillray::shared_memory_test {
namespace {

using ::testing::HasSubstr;

class SharedMemory : public test::OwnVulkanTest {
 protected:
  bool Offered() const { return device_ != nullptr && device_->context().sharing.offered; }
};

TEST_F(SharedMemory, AnotherDeviceReadsWhatWasCopied) {
  if (!Offered()) {
    GTEST_SKIP() << "the device shares no memory";
  }
  constexpr VkDeviceSize kBytes = 4 * 13 * 7;
  std::vector<uint8_t> written(kBytes);
  for (size_t i = 0; i < written.size(); ++i) {
    written[i] = static_cast<uint8_t>(i * 37 + i / 256);
  }
  const gpu::DeviceContext& c = device_->context();
  Result<std::unique_ptr<gpu::SharedBuffer>> buffer = gpu::SharedBuffer::Create(&c, kBytes);
  ASSERT_TRUE(buffer.ok()) << buffer.status().message();
  EXPECT_GE((*buffer)->memory_bytes(), kBytes);
  const auto write = [&] {
    const VkCommandBuffer commands = *device_->Begin();
    c.vk.CmdUpdateBuffer(commands, (*buffer)->buffer(), 0, kBytes, written.data());
    gpu::RecordRelease(c, commands, device_->queue_family(), **buffer);
    ASSERT_TRUE(device_->Run().ok());
  };
  write();
  auto other = *gpu::Device::Create(instance_, device_->info());
  const auto read = [&] {
    const Result<int> descriptor = (*buffer)->Export();
    EXPECT_TRUE(descriptor.ok()) << descriptor.status().message();
    return test::ImportedBytes(other.get(), *descriptor, (*buffer)->memory_bytes(), kBytes);
  };
  EXPECT_EQ(read(), written);
  std::swap(written.front(), written.back());
  write();
  EXPECT_EQ(read(), written) << "every descriptor shows the same memory";
}

TEST_F(SharedMemory, DevicesAreToldApart) {
  if (!Offered()) {
    GTEST_SKIP() << "the device shares no memory";
  }
  EXPECT_NE(device_->context().sharing.device, gpu::Uuid());
  EXPECT_NE(device_->context().sharing.driver, gpu::Uuid());
}

TEST_F(SharedMemory, SaysThatThereIsNone) {
  gpu::DeviceContext without = device_->context();
  without.sharing = {};
  const auto made = gpu::SharedBuffer::Create(&without, 64);
  EXPECT_EQ(made.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(made.status().message(), HasSubstr("shares no memory"));
}

}  // namespace
}  // namespace stillray::shared_memory_test
