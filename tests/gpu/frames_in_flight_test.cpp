// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// A renderer that records frames while earlier ones are unfinished, with views that live for one
// frame, and what it passes to its denoiser beside frames.
#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/mirror_frames.h"
#include "gpu/renderer_test.h"
#include "stillray/vulkan.h"
#include "stillray/vulkan.hpp"

namespace stillray::frames_in_flight_test {
namespace {

namespace watched = test::watched;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kWidth = test::kRendererWidth;
constexpr int kHeight = test::kRendererHeight;

using test::Slot;

class FramesInFlight : public test::RendererTest {};

std::vector<Frame> BusyFrames(int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) {
    frames.push_back(test::MakeBusyFrame(kWidth, kHeight, i));
  }
  return frames;
}

TEST_F(FramesInFlight, ThreeAtATimeWithFreshViewsForEach) {
  constexpr int kFrames = 200;
  constexpr int kSettled = 20;
  Prepare(BusyFrames(6), 3);
  const VulkanOptions o = options("default", 3);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  for (int i = 0; i < kFrames + 3; ++i) {
    SCOPED_TRACE(i);
    Slot& slot = slots_[static_cast<size_t>(i) % slots_.size()];
    if (slot.expected.has_value()) {
      Wait(&slot);
      ASSERT_NO_FATAL_FAILURE(ExpectPicture(slot, *slot.expected));
      slot.expected.reset();
    }
    if (i >= kFrames) {
      continue;
    }
    DenoisedFrame expected;
    ASSERT_TRUE(host.Denoise(HostFrame(i), &expected).ok());
    slot.expected = std::move(expected.colour);
    ASSERT_NO_FATAL_FAILURE(Begin(&slot));
    watched::forbidden_calls = 0;
    const Status recorded = made->Record(slot.commands, FreshFrame(i, &slot));
    ASSERT_TRUE(recorded.ok()) << recorded.message();
    EXPECT_TRUE(i < kSettled || watched::forbidden_calls == 0);
    ReadBack(slot.commands, slot);
    ASSERT_NO_FATAL_FAILURE(Submit(&slot));
  }
  EXPECT_EQ(made->timings().empty(), !o.timestamps);
}

// Without frames_in_flight sets are kept by view: their number is not limited, only their memory.
TEST_F(FramesInFlight, ViewsThatAreKeptMayBeMany) {
  constexpr int kFrames = 600;
  Prepare({test::MakeBusyFrame(kWidth, kHeight, 0)}, 1);
  VulkanOptions o = options("temporal", 0);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Slot& slot = slots_.front();
  for (int i = 0; i < kFrames; ++i) {
    const VulkanFrame frame = FreshFrame(i, &slot);
    Begin(&slot);
    const Status recorded = made->Record(slot.commands, frame);
    ASSERT_TRUE(recorded.ok()) << "frame " << i << ": " << recorded.message();
    ASSERT_EQ(vk().EndCommandBuffer(slot.commands), VK_SUCCESS);
  }
  EXPECT_TRUE(made->ForgetImages().ok());
}

TEST_F(FramesInFlight, TwoFramesMayBeInOneCommandBuffer) {
  Prepare(BusyFrames(4), 2);
  for (const int in_flight : {0, 2}) {
    const VulkanOptions o = options("svgf", in_flight);
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
    Slot& first = slots_[0];
    for (int i = 0; i < 6; i += 2) {
      DenoisedFrame expected[2];
      Begin(&first);
      for (int k = 0; k < 2; ++k) {
        ASSERT_TRUE(host.Denoise(HostFrame(i + k), &expected[k]).ok());
        Slot& slot = slots_[static_cast<size_t>(k)];
        const Status recorded = made->Record(first.commands, FreshFrame(i + k, &slot));
        ASSERT_TRUE(recorded.ok()) << recorded.message();
        ReadBack(first.commands, slot);
      }
      Submit(&first);
      ASSERT_EQ(vk().WaitForFences(handle(), 1, &first.fence, VK_TRUE, UINT64_MAX), VK_SUCCESS);
      ASSERT_EQ(vk().ResetFences(handle(), 1, &first.fence), VK_SUCCESS);
      ExpectPicture(slots_[0], expected[0].colour);
      ExpectPicture(slots_[1], expected[1].colour);
      ASSERT_TRUE(made->ForgetImages().ok());
      DestroyViews(&slots_[0]);
      DestroyViews(&slots_[1]);
    }
  }
}

/// Commands that were recorded since the last reset.
int TakeCommands() {
  return watched::dispatches.exchange(0) + watched::barriers.exchange(0) +
         watched::other_commands.exchange(0);
}

// Every descriptor set of the first three frames fails once, of the layers' too.
TEST_F(FramesInFlight, AFrameThatFailsLeavesCommandsAndHistoryAsTheyWere) {
  std::vector<Frame> frames;
  for (int i = 0; i < 3; ++i) {
    frames.push_back(test::MakeMirrors(kWidth, kHeight, i, false));
    frames.back().samples = Image1();
  }
  Prepare(frames, 1);
  VulkanOptions o = options("default", 2);
  o.virtual_guides = true;
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(made.ok()) << made.status().message();
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  int failed = 0;
  for (int i = 0; i < 3; ++i) {
    Slot& slot = slots_.front();
    const VulkanFrame frame = FreshFrame(i, &slot);
    Begin(&slot);
    for (int calls = 1;; ++calls) {
      watched::failing_set_call = 1;
      TakeCommands();
      const Status recorded = made->Record(slot.commands, frame);
      watched::failing_set_call = 0;
      if (recorded.ok()) {
        break;  // no set was missing any more
      }
      ++failed;
      EXPECT_EQ(recorded.code(), StatusCode::kOutOfMemory) << recorded.message();
      EXPECT_THAT(recorded.message(), HasSubstr("allocating a descriptor set"));
      EXPECT_EQ(TakeCommands(), 0);
      ASSERT_LT(calls, 1000);
      // The next attempt gets one set further.
      watched::failing_set_call = 2;
      const bool finished = made->Record(slot.commands, frame).ok();
      EXPECT_EQ(finished, watched::failing_set_call != 0);
      watched::failing_set_call = 0;
      if (finished) {
        break;
      }
    }
    DenoisedFrame expected;
    ASSERT_TRUE(host.Denoise(HostFrame(i), &expected).ok());
    ReadBack(slot.commands, slot);
    Submit(&slot);
    Wait(&slot);
    ExpectPicture(slot, expected.colour);
  }
  EXPECT_GT(failed, 40);
}

TEST_F(FramesInFlight, TimesAreThoseOfTheNewestFinishedFrame) {
  if (!device_->has_timestamps()) {
    GTEST_SKIP() << "the queue measures no times";
  }
  Prepare(BusyFrames(2), 2);
  Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), options("svgf", 2));
  ASSERT_TRUE(made.ok()) << made.status().message();
  EXPECT_THAT(made->timings(), IsEmpty());
  for (int i = 0; i < 2; ++i) {
    Slot& slot = slots_[static_cast<size_t>(i)];
    Begin(&slot);
    ASSERT_TRUE(made->Record(slot.commands, FreshFrame(i, &slot)).ok());
    EXPECT_EQ(made->timings().empty(), i == 0);  // while the second is not even submitted
    Submit(&slot);
    Wait(&slot);
    EXPECT_THAT(made->timings(), Not(IsEmpty()));
  }
}

TEST_F(FramesInFlight, SharedPipelinesAreMadeOnceAndOutliveTheirMaker) {
  Prepare(BusyFrames(2), 1);
  VulkanOptions o = options("svgf", 1);
  std::optional<VulkanDenoiser> first(std::move(VulkanDenoiser::Create(context(), o).value()));
  watched::pipeline_calls = 0;
  o.share_with = &*first;
  Result<VulkanDenoiser> second = VulkanDenoiser::Create(context(), o);
  ASSERT_TRUE(second.ok()) << second.status().message();
  EXPECT_EQ(watched::pipeline_calls, 0);
  first.reset();
  Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
  for (int i = 0; i < 2; ++i) {
    RunOne(&*second, &host, i);
  }
}

/// An allocator of a renderer: parts of one large block per memory type, from its second half on.
struct PoolOfTheRenderer {
  const gpu::DeviceContext* context = nullptr;
  int allocated = 0;
  int freed = 0;
  VkResult result = VK_SUCCESS;

  static VkResult Allocate(void* user, const VkMemoryRequirements* need, VulkanMemoryBlock* block) {
    auto* self = static_cast<PoolOfTheRenderer*>(user);
    if (self->result != VK_SUCCESS) {
      return self->result;
    }
    uint32_t type = 0;
    while ((need->memoryTypeBits >> type & 1u) == 0) {
      ++type;
    }
    EXPECT_EQ(need->memoryTypeBits, 1u << type);
    VkMemoryAllocateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    block->offset = 16 * need->alignment;
    info.allocationSize = block->offset + need->size;
    info.memoryTypeIndex = type;
    ++self->allocated;
    block->handle = self;
    return self->context->vk.AllocateMemory(self->context->device, &info, nullptr, &block->memory);
  }
  static void Free(void* user, const VulkanMemoryBlock* block) {
    auto* self = static_cast<PoolOfTheRenderer*>(user);
    EXPECT_EQ(block->handle, self);
    ++self->freed;
    self->context->vk.FreeMemory(self->context->device, block->memory, nullptr);
  }
};

TEST_F(FramesInFlight, MemoryComesFromTheRenderersAllocator) {
  Prepare(BusyFrames(2), 1);
  PoolOfTheRenderer pool = {&device_->context()};
  VulkanContext with_allocator = context();
  with_allocator.allocator = {&pool, &PoolOfTheRenderer::Allocate, &PoolOfTheRenderer::Free};
  const VulkanOptions o = options("svgf", 1);
  {
    watched::memory_calls = 0;
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(with_allocator, o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    EXPECT_EQ(watched::memory_calls, 0u);
    EXPECT_EQ(static_cast<uint32_t>(pool.allocated), made->memory().allocations);
    Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
    for (int i = 0; i < 2; ++i) {
      RunOne(&*made, &host, i);
    }
    EXPECT_EQ(pool.freed, 0);
  }
  EXPECT_EQ(pool.freed, pool.allocated);
  pool.result = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  EXPECT_EQ(VulkanDenoiser::Create(with_allocator, o).status().code(), StatusCode::kOutOfMemory);
  with_allocator.allocator.free = nullptr;
  EXPECT_THAT(VulkanDenoiser::Create(with_allocator, o).status().message(),
              HasSubstr("one of the functions allocate and free"));
}

TEST_F(FramesInFlight, PipelinesAreKeptInTheRenderersCache) {
  VkPipelineCacheCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
  VkPipelineCache cache = VK_NULL_HANDLE;
  ASSERT_EQ(vk().CreatePipelineCache(handle(), &info, nullptr, &cache), VK_SUCCESS);
  VulkanContext with_cache = context();
  with_cache.pipeline_cache = cache;
  watched::pipeline_cache = VK_NULL_HANDLE;
  EXPECT_TRUE(VulkanDenoiser::Create(with_cache, options("svgf", 0)).ok());
  EXPECT_EQ(watched::pipeline_cache.load(), cache);
  vk().DestroyPipelineCache(handle(), cache, nullptr);
}

TEST_F(FramesInFlight, StagesAreLabelledForDebuggers) {
  if (!validates_) {
    GTEST_SKIP() << "VK_EXT_debug_utils is enabled with the validation layer only";
  }
  Prepare(BusyFrames(1), 1);
  VulkanOptions o = options("svgf", 1);
  for (const bool labels : {false, true}) {
    o.debug_labels = labels;
    Result<VulkanDenoiser> made = VulkanDenoiser::Create(context(), o);
    ASSERT_TRUE(made.ok()) << made.status().message();
    watched::labels.clear();
    Denoiser host = MakeDenoiser(o.settings, DevicePrecision::kHalf);
    RunOne(&*made, &host, 0);
    EXPECT_EQ(watched::labels.empty(), !labels);
  }
  EXPECT_THAT(watched::labels, Contains("stillray: atrous1"));
  EXPECT_THAT(watched::labels, Contains("stillray: remodulate"));
  for (size_t i = 0; i < watched::labels.size(); ++i) {  // each ends before the next one begins
    EXPECT_EQ(watched::labels[i].empty(), i % 2 == 1) << i;
  }
}

TEST_F(FramesInFlight, InC) {
  Prepare(BusyFrames(3), 1);
  PoolOfTheRenderer pool = {&device_->context()};
  struct InC {
    static VkResult Allocate(void* user, const VkMemoryRequirements* need,
                             stillray_vulkan_memory_block* block) {
      VulkanMemoryBlock got;
      const VkResult result = PoolOfTheRenderer::Allocate(user, need, &got);
      *block = {got.memory, got.offset, got.handle};
      return result;
    }
    static void Free(void* user, const stillray_vulkan_memory_block* block) {
      const VulkanMemoryBlock given = {block->memory, block->offset, block->handle};
      PoolOfTheRenderer::Free(user, &given);
    }
  };
  const VulkanContext cpp = context();
  stillray_vulkan_context c = STILLRAY_VULKAN_CONTEXT_INIT;
  c.instance = cpp.instance;
  c.physical_device = cpp.physical_device;
  c.device = cpp.device;
  c.get_instance_proc_addr = cpp.get_instance_proc_addr;
  c.allocator = {&pool, &InC::Allocate, &InC::Free};
  stillray_vulkan_options o = STILLRAY_VULKAN_OPTIONS_INIT;
  o.preset = "svgf";
  o.width = kWidth;
  o.height = kHeight;
  o.timestamps = device_->has_timestamps() ? 1 : 0;
  o.frames_in_flight = 1;
  stillray_vulkan_denoiser* first = nullptr;
  ASSERT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &o, &first), STILLRAY_OK)
      << stillray_vulkan_error_message(nullptr);
  EXPECT_GT(pool.allocated, 0);
  watched::pipeline_calls = 0;
  o.share_with = first;
  stillray_vulkan_denoiser* second = nullptr;
  ASSERT_EQ(stillray_vulkan_create(STILLRAY_ABI_VERSION, &c, &o, &second), STILLRAY_OK);
  EXPECT_EQ(watched::pipeline_calls, 0);
  stillray_vulkan_release(first);
  Slot& slot = slots_.front();
  for (int i = 0; i < 3; ++i) {  // all images are others in every frame
    const VulkanFrame frame = FreshFrame(i, &slot);
    stillray_vulkan_frame in_c = STILLRAY_VULKAN_FRAME_INIT;
    const auto put = [&](int at, const VulkanImage& image) {
      in_c.images[at] = {image.view, image.layout};
    };
    for (int k = 0; k < 4; ++k) {
      put(STILLRAY_VULKAN_DIRECT_DIFFUSE + k, frame.lights[k]);
    }
    put(STILLRAY_VULKAN_DEPTH, frame.depth);
    put(STILLRAY_VULKAN_NORMAL, frame.normal);
    put(STILLRAY_VULKAN_MOTION, frame.motion);
    put(STILLRAY_VULKAN_ALBEDO, frame.albedo);
    put(STILLRAY_VULKAN_SPECULAR_ALBEDO, frame.specular_albedo);
    put(STILLRAY_VULKAN_COLOUR, frame.colour);
    Begin(&slot);
    EXPECT_EQ(stillray_vulkan_record(second, slot.commands, &in_c), STILLRAY_OK)
        << stillray_vulkan_error_message(second);
    Submit(&slot);
    Wait(&slot);
  }
  const size_t stages = stillray_vulkan_stage_times(second, nullptr, 0);
  EXPECT_EQ(stages > 0, o.timestamps != 0);
  std::vector<stillray_vulkan_stage_time> times(stages);
  EXPECT_EQ(stillray_vulkan_stage_times(second, times.data(), stages), stages);
  double sum = 0;
  for (const stillray_vulkan_stage_time& time : times) {
    EXPECT_THAT(std::string(time.name), Not(IsEmpty()));
    sum += time.milliseconds;
  }
  if (stages > 0) {
    EXPECT_DOUBLE_EQ(stillray_vulkan_filter_ms(second), sum);
  }
  EXPECT_EQ(stillray_vulkan_stage_times(nullptr, nullptr, 0), 0u);
  stillray_vulkan_release(second);
  EXPECT_EQ(pool.freed, pool.allocated);
}

TEST_F(FramesInFlight, SaysWhatIsWrong) {
  VulkanOptions o = options("svgf", -1);
  EXPECT_EQ(VulkanDenoiser::Create(context(), o).status().message(),
            "frames_in_flight is -1, expected 0 to 64");
  o.frames_in_flight = 65;
  EXPECT_THAT(VulkanDenoiser::Create(context(), o).status().message(), HasSubstr("is 65"));
}

}  // namespace
}  // namespace stillray::frames_in_flight_test
