// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A renderer that denoises in command buffers of its own, several of which may be pending.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "gpu/device_test.h"
#include "gpu/embedded_frame.h"
#include "gpu/put_on_device.h"
#include "gpu/watched_device.h"
#include "stillray/vulkan.hpp"

namespace stillray::test {

/// The largest frames.
inline constexpr int kRendererWidth = 45;
inline constexpr int kRendererHeight = 26;

/// A frame that is being recorded, or is pending.
struct Slot {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkFence fence = VK_NULL_HANDLE;
  const gpu::Image* colour = nullptr;
  const gpu::Buffer* bytes = nullptr;
  std::vector<VkImageView> views;  ///< of its frame alone
  std::optional<Image3> expected;
};

/// A renderer with command buffers of its own. Its frames lie on the device before they begin.
class RendererTest : public DeviceTest {
 protected:
  void TearDown() override {
    if (device_ != nullptr) {
      vk().DeviceWaitIdle(handle());
      for (Slot& slot : slots_) {
        DestroyViews(&slot);
        vk().DestroyFence(handle(), slot.fence, nullptr);
      }
      if (pool_ != VK_NULL_HANDLE) {
        vk().DestroyCommandPool(handle(), pool_, nullptr);
      }
    }
    slots_.clear();
    on_device_.clear();
    arena_.reset();
    DeviceTest::TearDown();
  }

  const gpu::DeviceFunctions& vk() const { return device_->context().vk; }
  VkDevice handle() const { return device_->context().device; }
  VulkanContext context() const {
    return {instance_->handle(), device_->context().physical, handle(),
            watched::Watch(instance_->get_instance_proc_addr())};
  }
  VulkanOptions options(std::string_view preset, int frames_in_flight) const {
    VulkanOptions o;
    o.settings = PresetSettings(preset).value();
    o.width = kRendererWidth;
    o.height = kRendererHeight;
    o.timestamps = device_->has_timestamps();
    o.frames_in_flight = frames_in_flight;
    return o;
  }

  /// Puts frames on the device, and makes slots with an output each.
  void Prepare(const std::vector<Frame>& frames, size_t slot_count) {
    constexpr size_t kBytes = size_t{kRendererWidth} * kRendererHeight * 4 * sizeof(float);
    for (const Frame& f : frames) {
      host_.push_back(f);
      on_device_.push_back(PutOnDevice(device_, f));
    }
    VkCommandPoolCreateInfo pool = {};
    pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    pool.queueFamilyIndex = device_->queue_family();
    ASSERT_EQ(vk().CreateCommandPool(handle(), &pool, nullptr, &pool_), VK_SUCCESS);
    vk().GetDeviceQueue(handle(), device_->queue_family(), 0, &queue_);
    arena_ = std::make_unique<gpu::Arena>(&device_->context());
    slots_.resize(slot_count);
    for (Slot& slot : slots_) {
      slot.colour =
          *arena_->AddImage(VK_FORMAT_R32G32B32A32_SFLOAT, kRendererWidth, kRendererHeight, 0);
      slot.bytes = *arena_->AddBuffer(kBytes, 0, gpu::BufferPlace::kDownload);
      VkCommandBufferAllocateInfo info = {};
      info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
      info.commandPool = pool_;
      info.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
      info.commandBufferCount = 1;
      ASSERT_EQ(vk().AllocateCommandBuffers(handle(), &info, &slot.commands), VK_SUCCESS);
      VkFenceCreateInfo fence = {};
      fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
      ASSERT_EQ(vk().CreateFence(handle(), &fence, nullptr, &slot.fence), VK_SUCCESS);
    }
    ASSERT_TRUE(arena_->Allocate().ok());
    const gpu::FairLock lock = device_->Lock();
    const Result<VkCommandBuffer> commands = device_->Begin();
    ASSERT_TRUE(commands.ok());
    arena_->RecordFirstUse(*commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_ACCESS_SHADER_WRITE_BIT);
    ASSERT_TRUE(device_->Run().ok());
  }

  /// A view that lives as long as the slot's frame.
  VulkanImage FreshView(const gpu::Image& image, Slot* slot) const {
    VkImageViewCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    info.image = image.image;
    info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    info.format = image.format;
    info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageView view = VK_NULL_HANDLE;
    EXPECT_EQ(vk().CreateImageView(handle(), &info, nullptr, &view), VK_SUCCESS);
    slot->views.push_back(view);
    return {view, VK_IMAGE_LAYOUT_GENERAL};
  }
  void DestroyViews(Slot* slot) const {
    for (const VkImageView view : slot->views) {
      vk().DestroyImageView(handle(), view, nullptr);
    }
    slot->views.clear();
  }

  Frame HostFrame(int index) const {
    Frame f = host_[static_cast<size_t>(index) % host_.size()];
    f.index = index;
    return f;
  }
  /// Frame `index` of the sequence in fresh views. \param slot  of its output
  VulkanFrame FreshFrame(int index, Slot* slot) const {
    const Frame& there = on_device_[static_cast<size_t>(index) % on_device_.size()];
    VulkanFrame frame =
        EmbeddedFrame(HostFrame(index), *gpu::FrameOn(*device_, there),
                      [&](const gpu::Image& image) { return FreshView(image, slot); });
    frame.colour = FreshView(*slot->colour, slot);
    frame.width = there.width;
    frame.height = there.height;
    return frame;
  }

  void Begin(Slot* slot) const {
    VkCommandBufferBeginInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    ASSERT_EQ(vk().BeginCommandBuffer(slot->commands, &info), VK_SUCCESS);
  }
  /// Records the copy of an output. \param commands  of any slot
  void ReadBack(VkCommandBuffer commands, const Slot& slot) const {
    gpu::MemoryBarrier(device_->context(), commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                       VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_READ_BIT);
    const VkBufferImageCopy region = WholeImage(*slot.colour);
    vk().CmdCopyImageToBuffer(commands, slot.colour->image, VK_IMAGE_LAYOUT_GENERAL,
                              slot.bytes->buffer, 1, &region);
    gpu::MemoryBarrier(device_->context(), commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                       VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                       VK_ACCESS_HOST_READ_BIT);
  }
  void Submit(Slot* slot) const {
    ASSERT_EQ(vk().EndCommandBuffer(slot->commands), VK_SUCCESS);
    VkSubmitInfo submit = {};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &slot->commands;
    ASSERT_EQ(vk().QueueSubmit(queue_, 1, &submit, slot->fence), VK_SUCCESS);
  }
  void Wait(Slot* slot) const {
    ASSERT_EQ(vk().WaitForFences(handle(), 1, &slot->fence, VK_TRUE, UINT64_MAX), VK_SUCCESS);
    ASSERT_EQ(vk().ResetFences(handle(), 1, &slot->fence), VK_SUCCESS);
    DestroyViews(slot);
  }
  void ExpectPicture(const Slot& slot, const Image3& expected) const {
    ASSERT_TRUE(arena_->Invalidate().ok());
    const Image3 found = Picture(slot, expected[0].width(), expected[0].height());
    ASSERT_TRUE(SameBits(found, expected));
  }
  /// The finished picture of a slot.
  static Image3 Picture(const Slot& slot, int width, int height) {
    const auto* pixels = static_cast<const float*>(slot.bytes->mapped);
    Image3 picture(width, height);
    for (int c = 0; c < 3; ++c) {
      FillImage(&picture[c],
                [&](int x, int y) { return pixels[4 * (y * kRendererWidth + x) + c]; });
    }
    return picture;
  }

  /// One frame, submitted and finished: expects the picture of `host`.
  void RunOne(VulkanDenoiser* denoiser, Denoiser* host, int index) {
    Slot& slot = slots_.front();
    DenoisedFrame expected;
    ASSERT_TRUE(host->Denoise(HostFrame(index), &expected).ok());
    Begin(&slot);
    const Status recorded = denoiser->Record(slot.commands, FreshFrame(index, &slot));
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    ReadBack(slot.commands, slot);
    Submit(&slot);
    Wait(&slot);
    ExpectPicture(slot, expected.colour);
  }

  std::vector<Frame> host_;
  std::vector<Frame> on_device_;
  std::unique_ptr<gpu::Arena> arena_;
  std::vector<Slot> slots_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
};

}  // namespace stillray::test
