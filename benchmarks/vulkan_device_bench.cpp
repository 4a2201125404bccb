// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "benchmarks/vulkan_device_bench.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/random.h"
#include "denoise/vulkan/frame_download.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/frame_upload.h"

namespace stillray::vulkan {
namespace {

constexpr int kWarmUp = 8;

/// Slanted planes and a curved one, lit by sparse samples, under a camera that moves by a quarter
/// of a pixel per frame.
Frame MakeFrame(int width, int height) {
  Frame f;
  f.width = width;
  f.height = height;
  for (const SignalKind kind : {SignalKind::kDirectDiffuse, SignalKind::kIndirectDiffuse,
                                SignalKind::kDirectSpecular, SignalKind::kIndirectSpecular}) {
    f.signals.push_back({kind, Image3(width, height), Image1()});
  }
  f.guides.depth = Image1(width, height);
  f.guides.normal = Image3(width, height);
  f.guides.albedo = Image3(width, height);
  f.guides.specular_albedo = Image3(width, height);
  f.guides.motion = Image2(width, height);
  f.guides.id = Plane<uint32_t>(width, height);
  f.guides.motion[0].Fill(0.25f);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(width);
      const float v = static_cast<float>(y) / static_cast<float>(height);
      const int part = x * 6 / width + 2 * (y * 3 / height);
      const float bend = part % 3 == 1 ? 2.0f * u : 0.3f * static_cast<float>(part % 5);
      f.guides.depth(x, y) =
          1 / (0.1f + 0.05f * static_cast<float>(part % 4) + 0.1f * u + 0.2f * v);
      f.guides.normal[0](x, y) = std::sin(bend);
      f.guides.normal[2](x, y) = std::cos(bend);
      f.guides.id(x, y) = static_cast<uint32_t>(part + 1);
      for (int c = 0; c < 3; ++c) {
        f.guides.albedo[c](x, y) = 0.3f + 0.1f * static_cast<float>((x / 16 + y / 16 + c) % 4);
        f.guides.specular_albedo[c](x, y) = 0.04f;
      }
      for (size_t s = 0; s < f.signals.size(); ++s) {
        const float random = UniformFloat(
            HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)),
                        static_cast<uint32_t>(s)));
        for (int c = 0; c < 3; ++c) {
          f.signals[s].radiance[c](x, y) = random < 0.25f ? 1.0f + 0.5f * static_cast<float>(c) : 0;
        }
      }
    }
  }
  return f;
}

/// A copy between two buffers of the device, timed.
class CopyBench {
 public:
  explicit CopyBench(const gpu::DeviceContext* context)
      : context_(context), arena_(context), times_(context) {}

  /// \param bytes  read and written in all
  Status Create(uint64_t bytes) {
    size_ = bytes / 2 / 16 * 16;
    const auto add = [&](const gpu::Buffer** buffer) {
      const Result<const gpu::Buffer*> added =
          arena_.AddBuffer(size_, 0, gpu::BufferPlace::kDevice);
      STILLRAY_RETURN_IF_ERROR(added.status());
      *buffer = *added;
      return Status::Ok();
    };
    STILLRAY_RETURN_IF_ERROR(add(&from_));
    STILLRAY_RETURN_IF_ERROR(add(&to_));
    STILLRAY_RETURN_IF_ERROR(arena_.Allocate());
    return times_.Create(2);
  }

  void Record(VkCommandBuffer commands) {
    times_.Begin(commands);
    times_.Mark(commands, "copy");
    const VkBufferCopy region = {0, 0, size_};
    context_->vk.CmdCopyBuffer(commands, from_->buffer, to_->buffer, 1, &region);
    VkMemoryBarrier barrier = {};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
    barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
    context_->vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                    VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, nullptr, 0,
                                    nullptr);
    times_.End(commands);
  }

  double Read() const {
    const std::vector<gpu::DeviceTime> times = times_.Read();
    return times.empty() ? 0 : times.front().milliseconds;
  }

 private:
  const gpu::DeviceContext* context_;
  gpu::Arena arena_;
  gpu::Timestamps times_;
  VkDeviceSize size_ = 0;
  const gpu::Buffer* from_ = nullptr;
  const gpu::Buffer* to_ = nullptr;
};

void Add(const std::vector<gpu::DeviceTime>& times, double copy, DeviceBenchResult* result) {
  double whole = 0;
  for (const gpu::DeviceTime& time : times) {
    auto at = std::find_if(result->stages.begin(), result->stages.end(),
                           [&](const auto& stage) { return stage.name == time.name; });
    if (at == result->stages.end()) {
      result->stages.push_back({std::string(time.name), {}});
      at = result->stages.end() - 1;
    }
    at->ms.push_back(time.milliseconds);
    whole += time.milliseconds;
  }
  result->whole.push_back(whole);
  result->copy.push_back(copy);
}

}  // namespace

Result<DeviceBenchResult> RunDeviceBench(const std::shared_ptr<gpu::Device>& device,
                                         const DeviceBenchOptions& o) {
  if (!device->has_timestamps()) {
    return Status::Unsupported(
        fmt::format("{}: the device measures no times", device->info().name));
  }
  const gpu::DeviceContext* context = &device->context();
  PipelineOptions options = {
      o.settings,
      o.width,
      o.height,
      false,
      o.precision == DevicePrecision::kFloat ? Storage::kFloat : Storage::kHalf,
      true};
  Result<std::unique_ptr<FramePipeline>> pipeline = FramePipeline::Create(context, options);
  STILLRAY_RETURN_IF_ERROR(pipeline.status());
  const Frame frame = MakeFrame(o.width, o.height);
  FrameFacts facts = FactsOf(frame);
  Result<std::unique_ptr<FrameUpload>> upload =
      FrameUpload::Create(context, o.width, o.height, facts);
  STILLRAY_RETURN_IF_ERROR(upload.status());
  STILLRAY_RETURN_IF_ERROR((*upload)->Write(frame));
  const Result<std::unique_ptr<FrameDownload>> download =
      FrameDownload::Create(context, o.width, o.height);
  STILLRAY_RETURN_IF_ERROR(download.status());
  FrameInputs images = (*upload)->inputs();
  (*download)->ShowTo(&images);

  DeviceBenchResult result;
  result.signals = static_cast<int>((*pipeline)->groups().size());
  result.copy_bytes_per_pixel = kLeastSharedBytes + kLeastSignalBytes * result.signals;
  result.copy_bytes = static_cast<uint64_t>(result.copy_bytes_per_pixel) *
                      static_cast<uint64_t>(o.width) * static_cast<uint64_t>(o.height);
  CopyBench copy(context);
  STILLRAY_RETURN_IF_ERROR(copy.Create(result.copy_bytes));
  for (int i = 0; i < kWarmUp + o.repeats; ++i) {
    const Result<VkCommandBuffer> commands = device->Begin();
    STILLRAY_RETURN_IF_ERROR(commands.status());
    if (i == 0) {
      (*upload)->Record(*commands);
      (*download)->RecordUse(*commands);
    }
    facts.index = i;
    const FramePlan plan = MakePlan(o.settings, facts, (*pipeline)->progress());
    STILLRAY_RETURN_IF_ERROR((*pipeline)->Record(*commands, plan, facts, images, nullptr));
    copy.Record(*commands);
    STILLRAY_RETURN_IF_ERROR(device->Run());
    if (i >= kWarmUp) {
      Add((*pipeline)->times(), copy.Read(), &result);
    }
  }
  const gpu::MemoryUse use = (*pipeline)->memory();
  result.memory = {use.allocations, use.resources, use.bytes, use.largest};
  return result;
}

}  // namespace stillray::vulkan
