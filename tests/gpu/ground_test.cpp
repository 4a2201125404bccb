// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Devices, memory, pipelines, timestamps, and the messages for missing features.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "gpu/memory.h"
#include "gpu/pipeline.h"
#include "gpu/timestamps.h"
#include "gpu/vulkan_test.h"

namespace shaders {
extern const std::uint32_t kDoubleValues[];
extern const std::size_t kDoubleValuesWords;
}  // namespace shaders

namespace stillray::ground_test {
namespace {

using gpu::Arena;
using gpu::Buffer;
using gpu::BufferPlace;
using gpu::DeviceInfo;
using gpu::Image;
using ::testing::HasSubstr;

DeviceInfo MakeInfo(const char* name, bool is_gpu, Status usable = Status::Ok()) {
  DeviceInfo info;
  info.name = name;
  info.is_gpu = is_gpu;
  info.usable = std::move(usable);
  return info;
}

TEST(Loader, SaysThatThereIsNone) {
  gpu::InstanceOptions options;
  options.loader = "libno_such_vulkan.so.1";
  const auto made = gpu::Instance::Create(options);
  ASSERT_FALSE(made.ok());
  EXPECT_EQ(made.status().code(), StatusCode::kUnsupported);
  EXPECT_THAT(made.status().message(), HasSubstr("libno_such_vulkan.so.1 is not on this machine"));
}

TEST(Loader, RefusesAnotherLibrary) {
  const Result<gpu::GlobalFunctions> opened = gpu::OpenLoader("libm.so.6");
  ASSERT_FALSE(opened.ok());
  EXPECT_THAT(opened.status().message(), HasSubstr("libm.so.6 has no vkGetInstanceProcAddr"));
}

TEST(ChooseDevice, TakesHardwareBeforeSoftware) {
  const std::vector<DeviceInfo> devices = {MakeInfo("software", false), MakeInfo("card", true)};
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan")->name, "card");
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan:0")->name, "software");
}

TEST(ChooseDevice, TakesDiscreteGpusBeforeIntegratedOnes) {
  std::vector<DeviceInfo> devices = {MakeInfo("software", false), MakeInfo("integrated", true),
                                     MakeInfo("virtual", true), MakeInfo("card", true),
                                     MakeInfo("second card", true)};
  devices[0].rank = 1;
  devices[1].rank = 2;
  devices[2].rank = 3;
  devices[3].rank = devices[4].rank = 4;
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan")->name, "card");
  devices.resize(3);
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan")->name, "virtual");
  devices.resize(2);
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan")->name, "integrated");
}

TEST(Timestamps, CountersThatBeginAgainAreUnderstood) {
  EXPECT_EQ(gpu::TicksBetween(10, 25, 64), 15u);
  EXPECT_EQ(gpu::TicksBetween(0xffffffff0u, 5, 36), 21u);       // 2^36 - 16, then 5
  EXPECT_EQ(gpu::TicksBetween(3, 0xabc000000000007u, 36), 4u);  // undefined bits above
  EXPECT_EQ(gpu::TicksBetween(~uint64_t{0}, 1, 64), 2u);
}

TEST(ChooseDevice, TakesWhatWorksBeforeHardware) {
  const std::vector<DeviceInfo> devices = {MakeInfo("old", true, Status::Unsupported("too old")),
                                           MakeInfo("software", false)};
  EXPECT_EQ(gpu::ChooseDevice(devices, "vulkan")->name, "software");
  EXPECT_THAT(gpu::ChooseDevice(devices, "vulkan:0").status().message(), HasSubstr("too old"));
}

TEST(ChooseDevice, NamesWhatIsWrong) {
  const std::vector<DeviceInfo> devices = {MakeInfo("card", true)};
  EXPECT_EQ(gpu::ChooseDevice({}, "vulkan").status().code(), StatusCode::kNotFound);
  EXPECT_THAT(gpu::ChooseDevice(devices, "vulkan:1").status().message(),
              HasSubstr("'vulkan:1', but this machine has vulkan:0 to vulkan:0"));
  for (const char* bad : {"vulkan:", "vulkan:x", "vulkan:-1", "vulkan:1x", "cuda", "",
                          "vulkan:99999999999999999999"}) {
    EXPECT_THAT(gpu::ChooseDevice(devices, bad).status().message(),
                HasSubstr("expected auto, cpu, vulkan or vulkan:N"))
        << bad;
  }
}

TEST(Errors, AreSentences) {
  const Status lost = gpu::ToStatus(VK_ERROR_DEVICE_LOST, "submitting work");
  EXPECT_EQ(lost.code(), StatusCode::kUnsupported);
  EXPECT_EQ(lost.message(),
            "Vulkan: submitting work: the device was lost (the driver reset it or it was removed) "
            "(-4)");
  EXPECT_EQ(gpu::ToStatus(VK_ERROR_OUT_OF_DEVICE_MEMORY, "x").code(), StatusCode::kOutOfMemory);
  EXPECT_TRUE(gpu::ToStatus(VK_SUCCESS, "x").ok());
}

using Ground = test::OwnVulkanTest;

TEST_F(Ground, DevicesHaveNames) {
  const Result<std::vector<DeviceInfo>> devices = instance_->ListDevices();
  ASSERT_TRUE(devices.ok());
  for (const DeviceInfo& device : *devices) {
    EXPECT_FALSE(device.name.empty());
    EXPECT_FALSE(device.driver.empty());
    EXPECT_GT(device.memory_bytes, 0u);
  }
}

TEST_F(Ground, ValidationIsListening) {
  if (!validates_) {
    GTEST_SKIP() << "the validation layer is not installed";
  }
  // A buffer of no bytes is an error that only the layer sees.
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkBuffer buffer = VK_NULL_HANDLE;
  const gpu::DeviceContext& context = device_->context();
  if (context.vk.CreateBuffer(context.device, &info, nullptr, &buffer) == VK_SUCCESS) {
    context.vk.DestroyBuffer(context.device, buffer, nullptr);
  }
  EXPECT_FALSE(messages_->Take().empty());
}

TEST_F(Ground, ObjectsLeftBehindAreReported) {
  if (!validates_) {
    GTEST_SKIP() << "the validation layer is not installed";
  }
  const gpu::DeviceContext& context = device_->context();
  VkFenceCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
  VkFence fence = VK_NULL_HANDLE;
  ASSERT_EQ(context.vk.CreateFence(context.device, &info, nullptr, &fence), VK_SUCCESS);
  device_.reset();
  EXPECT_FALSE(messages_->Take().empty());
}

TEST_F(Ground, ArenaTellsItsNeedBeforehandAndTakesNoMore) {
  Arena arena(&device_->context());
  ASSERT_TRUE(arena.AddImage(VK_FORMAT_R16G16B16A16_SFLOAT, 33, 17, 3).ok());
  ASSERT_TRUE(arena.AddImage(VK_FORMAT_R32_UINT, 1, 1, 1).ok());
  ASSERT_TRUE(arena.AddBuffer(1000, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, BufferPlace::kDevice).ok());
  const gpu::MemoryUse before = arena.Need();
  ASSERT_TRUE(arena.Allocate().ok());
  const gpu::MemoryUse after = arena.Need();
  EXPECT_EQ(before.bytes, after.bytes);
  EXPECT_EQ(after.allocations, 1u);
  EXPECT_EQ(after.resources, 3u);
  EXPECT_GE(after.largest, 33u * 17u * 3u * 8u);
  EXPECT_GE(after.bytes, after.largest + 1000);
  EXPECT_EQ(arena.Allocate().code(), StatusCode::kInternal);
}

// Blocks are complete: their bytes are those of the allocations and of the ranges between these.
TEST_F(Ground, ArenasAreCountedWhileTheyLive) {
  const MemoryBlocks before = CountedBlocks(MemoryPlace::kDevice);
  {
    Arena arena(&device_->context());
    for (const VkDeviceSize bytes : {100, 5000, 300}) {
      ASSERT_TRUE(arena.AddBuffer(bytes, 0, gpu::BufferPlace::kDevice).ok());
    }
    EXPECT_EQ(CountedBlocks(MemoryPlace::kDevice), before);
    const gpu::MemoryUse need = arena.Need();
    ASSERT_TRUE(arena.Allocate().ok());
    const MemoryBlocks with = CountedBlocks(MemoryPlace::kDevice);
    EXPECT_EQ(with.blocks, before.blocks + need.allocations);
    EXPECT_EQ(with.allocations, before.allocations + 3);
    EXPECT_EQ(with.block_bytes, before.block_bytes + need.bytes);
    EXPECT_GE(with.allocated_bytes, before.allocated_bytes + 5400);
    EXPECT_GE(with.largest_allocation, 5000u);
    const uint64_t unused =
        with.block_bytes - with.allocated_bytes - (before.block_bytes - before.allocated_bytes);
    EXPECT_EQ(unused > 0, with.unused_ranges > before.unused_ranges);
    EXPECT_LE(with.largest_unused, std::max<uint64_t>(unused, before.largest_unused));
  }
  EXPECT_EQ(CountedBlocks(MemoryPlace::kDevice), before);
}

TEST_F(Ground, TooMuchMemoryIsAnError) {
  Arena arena(&device_->context());
  // Far more than any machine has, in images that are allowed each.
  for (int i = 0; i < 2048; ++i) {
    ASSERT_TRUE(arena.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, 8192, 8192, 2).ok());
  }
  EXPECT_GT(arena.Need().bytes, uint64_t{1} << 41);
  const Status status = arena.Allocate();
  EXPECT_EQ(status.code(), StatusCode::kOutOfMemory);
  EXPECT_THAT(status.message(), HasSubstr("MB, the device has"));
}

void Barrier(const gpu::DeviceContext& c, VkCommandBuffer commands) {
  VkMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
  c.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                          VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                          &barrier, 0, nullptr, 0, nullptr);
}

void ToGeneral(const gpu::DeviceContext& c, VkCommandBuffer commands, const Image& image) {
  VkImageMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  barrier.dstAccessMask = VK_ACCESS_MEMORY_WRITE_BIT | VK_ACCESS_MEMORY_READ_BIT;
  barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image.image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  c.vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                          VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0, nullptr, 1,
                          &barrier);
}

TEST_F(Ground, PipelineComputesAndIsTimed) {
  constexpr int kWidth = 19;
  constexpr int kHeight = 5;
  constexpr int kValues = kWidth * kHeight * 2 * 4;
  const gpu::DeviceContext& c = device_->context();
  Arena arena(&c);
  const Image* from = *arena.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight, 2);
  const Image* to = *arena.AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, kWidth, kHeight, 2);
  const Buffer* up = *arena.AddBuffer(kValues * 4, 0, BufferPlace::kUpload);
  const Buffer* down = *arena.AddBuffer(kValues * 4, 0, BufferPlace::kDownload);
  ASSERT_TRUE(arena.Allocate().ok());
  gpu::DescriptorSets sets(&c);
  const gpu::SetShape shape = {1, 1, 0, 0};
  ASSERT_TRUE(sets.CreatePool(2, {2, 2, 0, 0}, 2).ok());
  const VkDescriptorSetLayout layout = *sets.Layout(shape);
  const uint32_t factor = 3;
  const Result<gpu::Pipeline> pipeline =
      gpu::Pipeline::Create(&c, {"double_values",
                                 {shaders::kDoubleValues, shaders::kDoubleValuesWords},
                                 {&layout, 1},
                                 sizeof(float),
                                 {&factor, 1}});
  ASSERT_TRUE(pipeline.ok()) << pipeline.status().message();
  const Result<VkDescriptorSet> set = sets.Find(shape, {{from->view, to->view}, {}, {}});
  ASSERT_TRUE(set.ok());
  EXPECT_EQ(*sets.Find(shape, {{from->view, to->view}, {}, {}}), *set);  // found again
  EXPECT_NE(*sets.Find(shape, {{to->view, from->view}, {}, {}}), *set);
  // The first pool is full.
  const Result<VkDescriptorSet> third = sets.Find(shape, {{to->view, to->view}, {}, {}});
  ASSERT_TRUE(third.ok()) << third.status().message();
  EXPECT_EQ(*sets.Find(shape, {{from->view, to->view}, {}, {}}), *set);
  // Sets of a frame are other ones with each use, and the same ones for the next frame there.
  std::vector<VkDescriptorSet> of_frame[3];
  for (uint32_t i = 0; i < 3; ++i) {
    sets.BeginFrame(i);
    for (int use = 0; use < 2; ++use) {
      of_frame[i].push_back(*sets.FindForFrame(shape, {{from->view, to->view}, {}, {}}));
    }
  }
  EXPECT_EQ(std::set<VkDescriptorSet>(
                {*set, *third, of_frame[0][0], of_frame[0][1], of_frame[1][0], of_frame[1][1]})
                .size(),
            6u);
  EXPECT_EQ(of_frame[2], of_frame[0]);

  auto* values = static_cast<float*>(up->mapped);
  for (int i = 0; i < kValues; ++i) {
    values[i] = static_cast<float>(i);
  }
  ASSERT_TRUE(arena.Flush().ok());
  gpu::Timestamps times(&c);
  ASSERT_TRUE(times.Create(8).ok());
  const Result<VkCommandBuffer> commands = device_->Begin();
  ASSERT_TRUE(commands.ok());
  ToGeneral(c, *commands, *from);
  ToGeneral(c, *commands, *to);
  times.Begin(*commands);
  VkBufferImageCopy region = {};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 2};
  region.imageExtent = {kWidth, kHeight, 1};
  times.Mark(*commands, "copy");
  c.vk.CmdCopyBufferToImage(*commands, up->buffer, from->image, VK_IMAGE_LAYOUT_GENERAL, 1,
                            &region);
  Barrier(c, *commands);
  times.Mark(*commands, "compute");
  const float offset = 0.5f;
  c.vk.CmdBindPipeline(*commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->handle());
  c.vk.CmdBindDescriptorSets(*commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline->layout(), 0, 1,
                             &*set, 0, nullptr);
  c.vk.CmdPushConstants(*commands, pipeline->layout(), VK_SHADER_STAGE_COMPUTE_BIT, 0,
                        sizeof(offset), &offset);
  c.vk.CmdDispatch(*commands, 3, 1, 2);
  Barrier(c, *commands);
  times.Mark(*commands, "copy");
  c.vk.CmdCopyImageToBuffer(*commands, to->image, VK_IMAGE_LAYOUT_GENERAL, down->buffer, 1,
                            &region);
  Barrier(c, *commands);
  times.End(*commands);
  EXPECT_TRUE(device_->Run().ok());
  ASSERT_TRUE(arena.Invalidate().ok());
  const auto* results = static_cast<const float*>(down->mapped);
  for (int i = 0; i < kValues; ++i) {
    ASSERT_EQ(results[i], 6 * static_cast<float>(i) + 0.5f) << i;
  }
  if (device_->has_timestamps()) {
    const std::vector<gpu::DeviceTime> read = times.Read();
    ASSERT_EQ(read.size(), 2u);
    EXPECT_EQ(read[0].name, "copy");
    EXPECT_EQ(read[1].name, "compute");
    EXPECT_GT(read[0].milliseconds + read[1].milliseconds, 0);
  }
}

}  // namespace
}  // namespace stillray::ground_test
