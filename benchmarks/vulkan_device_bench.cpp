// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "benchmarks/vulkan_device_bench.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "benchmarks/copy_bench.h"
#include "benchmarks/packed_inputs.h"
#include "core/clock.h"
#include "core/random.h"
#include "denoise/vulkan/frame_download.h"
#include "denoise/vulkan/frame_pipeline.h"
#include "denoise/vulkan/frame_upload.h"
#include "gpu/shader_folder.h"

namespace stillray::vulkan {
namespace {

/// Warm-up frames, which fill histories and allocate descriptor sets.
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

/// Approximate duration of a submission: waiting for the device and starting it take some 0.1 ms,
/// and the device lowers its clock while idle.
constexpr double kSubmissionMs = 20;
constexpr int kMostFramesOfASubmission = 64;

/// Input and output images of the frames.
struct Images {
  std::unique_ptr<FrameUpload> upload;
  std::unique_ptr<FrameDownload> download;
  std::unique_ptr<PackedInputs> packed;

  void Record(VkCommandBuffer commands) {
    if (packed != nullptr) {
      packed->Record(commands);
    } else {
      upload->Record(commands);
      download->RecordUse(commands);
    }
  }
  FrameInputs Inputs() const {
    FrameInputs inputs = packed != nullptr ? packed->inputs() : upload->inputs();
    if (packed == nullptr) {
      download->ShowTo(&inputs);
    }
    return inputs;
  }
};

Result<Images> MakeImages(const gpu::DeviceContext* context, const Frame& frame,
                          BenchInputs inputs) {
  Images images;
  if (inputs == BenchInputs::kPacked) {
    Result<std::unique_ptr<PackedInputs>> packed = PackedInputs::Create(context, frame);
    STILLRAY_RETURN_IF_ERROR(packed.status());
    images.packed = std::move(*packed);
    return images;
  }
  Result<std::unique_ptr<FrameUpload>> upload =
      FrameUpload::Create(context, frame.width, frame.height, FactsOf(frame));
  STILLRAY_RETURN_IF_ERROR(upload.status());
  STILLRAY_RETURN_IF_ERROR((*upload)->Write(frame));
  Result<std::unique_ptr<FrameDownload>> download =
      FrameDownload::Create(context, frame.width, frame.height);
  STILLRAY_RETURN_IF_ERROR(download.status());
  STILLRAY_RETURN_IF_ERROR((*download)->Prepare(Results()));
  images.upload = std::move(*upload);
  images.download = std::move(*download);
  return images;
}

/// Denoises one frame repeatedly.
class FrameLoop {
 public:
  FrameLoop(gpu::Device* device, const DeviceBenchOptions& options)
      : device_(device),
        options_(options),
        list_(&device->context()),
        copy_(&device->context()),
        times_(&device->context()) {}

  Status Create(DeviceBenchResult* result) {
    const DeviceBenchOptions& o = options_;
    const gpu::DeviceContext* context = &device_->context();
    const PipelineOptions options = {
        o.settings,
        o.width,
        o.height,
        false,
        o.precision == DevicePrecision::kFloat ? Storage::kFloat : Storage::kHalf,
        true};
    Result<std::unique_ptr<FramePipeline>> pipeline = FramePipeline::Create(context, options);
    STILLRAY_RETURN_IF_ERROR(pipeline.status());
    pipeline_ = std::move(*pipeline);
    const Frame frame = MakeFrame(o.width, o.height);
    facts_ = FactsOf(frame);
    Result<Images> images = MakeImages(context, frame, o.inputs);
    STILLRAY_RETURN_IF_ERROR(images.status());
    images_ = std::move(*images);
    result->signals = static_cast<int>(pipeline_->groups().size());
    result->copy_bytes_per_pixel = kLeastSharedBytes + kLeastSignalBytes * result->signals;
    result->copy_bytes = static_cast<uint64_t>(result->copy_bytes_per_pixel) *
                         static_cast<uint64_t>(o.width) * static_cast<uint64_t>(o.height);
    STILLRAY_RETURN_IF_ERROR(copy_.Create(result->copy_bytes));
    return times_.Create(3);
  }

  /// Runs `frames` frames and copies in one submission.
  Status Run(int frames) {
    const Result<VkCommandBuffer> commands = device_->Begin();
    STILLRAY_RETURN_IF_ERROR(commands.status());
    if (facts_.index == 0) {
      images_.Record(*commands);
    }
    const FrameInputs inputs = images_.Inputs();
    // Stages are measured only in the last frame: their timestamps make the device wait between
    // stages.
    const int measured = std::max(frames - 1, 1);
    times_.Begin(*commands);
    times_.Mark(*commands, "frames");
    for (int i = 0; i < frames; ++i) {
      if (i == measured) {
        times_.Mark(*commands, "stages");
      }
      pipeline_->MeasureStages(i == frames - 1);
      const FramePlan plan = MakePlan(options_.settings, facts_, pipeline_->progress());
      STILLRAY_RETURN_IF_ERROR(pipeline_->Record(&list_, plan, facts_, inputs, nullptr));
      list_.Record(*commands);
      ++facts_.index;
    }
    times_.End(*commands);
    copy_.Record(*commands, frames);
    frames_ = measured;
    return device_->Run();
  }

  /// Milliseconds of one frame of the last submission.
  double FrameMs() const {
    const std::vector<gpu::DeviceTime> times = times_.Read();
    return times.empty() ? 0 : times.front().milliseconds / frames_;
  }

  void AddTo(DeviceBenchResult* result) const {
    for (const gpu::DeviceTime& time : pipeline_->times()) {
      auto at = std::find_if(result->stages.begin(), result->stages.end(),
                             [&](const auto& stage) { return stage.name == time.name; });
      if (at == result->stages.end()) {
        result->stages.push_back({std::string(time.name), {}});
        at = result->stages.end() - 1;
      }
      at->ms.push_back(time.milliseconds);
    }
    const CopyTimes copy = copy_.Read();
    result->whole.push_back(FrameMs());
    result->transfer_copy.push_back(copy.transfer);
    result->compute_copy.push_back(copy.compute);
  }

  gpu::MemoryUse memory() const { return pipeline_->memory(); }

 private:
  gpu::Device* device_;
  const DeviceBenchOptions& options_;
  gpu::CommandList list_;
  std::unique_ptr<FramePipeline> pipeline_;
  Images images_;
  FrameFacts facts_;
  CopyBench copy_;
  gpu::Timestamps times_;
  int frames_ = 1;
};

}  // namespace

Result<DeviceBenchResult> RunDeviceBench(const std::shared_ptr<gpu::Device>& device,
                                         const DeviceBenchOptions& o) {
  if (!device->has_timestamps()) {
    return Status::Unsupported(
        fmt::format("{}: the device measures no times", device->info().name));
  }
  DeviceBenchResult result;
  result.replaced_shaders = gpu::ReplacedShaders();
  FrameLoop loop(device.get(), o);
  STILLRAY_RETURN_IF_ERROR(loop.Create(&result));
  const Clock::time_point start = Clock::now();
  for (int i = 0; i < kWarmUp || MillisecondsSince(start) < o.warm_up_ms;) {
    STILLRAY_RETURN_IF_ERROR(loop.Run(result.frames_of_a_submission));
    i += result.frames_of_a_submission;
    const double frame_ms = std::max(loop.FrameMs(), 1e-3);
    result.frames_of_a_submission =
        std::clamp(static_cast<int>(kSubmissionMs / frame_ms), 1, kMostFramesOfASubmission);
  }
  for (int i = 0; i < o.repeats; ++i) {
    STILLRAY_RETURN_IF_ERROR(loop.Run(result.frames_of_a_submission));
    loop.AddTo(&result);
  }
  const gpu::MemoryUse use = loop.memory();
  result.memory = {use.allocations, use.resources, use.bytes, use.largest};
  return result;
}

}  // namespace stillray::vulkan
