// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "common/trace_device.h"

#include <utility>

#include <fmt/format.h>

#include "core/nearest_names.h"
#ifdef STILLRAY_WITH_VULKAN
#include "denoise/vulkan/host_denoiser.h"
#include "gpu/instance.h"
#include "render/vulkan/gpu_accel.h"
#include "render/vulkan/vulkan_renderer.h"
#endif

namespace stillray {

Result<std::unique_ptr<DeviceRenderer>> DeviceRenderer::Create(const Device& device,
                                                               const Scene& scene,
                                                               const RenderSettings& settings,
                                                               const TraceOptions& options) {
  std::unique_ptr<DeviceRenderer> made(new DeviceRenderer(scene, options));
  const Status on_device = made->MakeOnDevice(device, settings);
  if (made->FallsBack(on_device)) {
    made->remark_ = on_device.message();
  } else {
    STILLRAY_RETURN_IF_ERROR(on_device);
  }
  if (made->renderer_ == nullptr && options.way == render::TracingWay::kHardware) {
    return Status::Unsupported(
        "--ray-tracing is 'hardware', but the CPU traces: stillray info --devices lists the others "
        "for --device or --trace-device");
  }
  if (made->renderer_ == nullptr && options.textures == render::TextureWay::kSampled) {
    return Status::Unsupported(
        "--textures is 'sampled', but the CPU traces: --device or --trace-device chooses another");
  }
  if (made->renderer_ == nullptr) {
    STILLRAY_RETURN_IF_ERROR(made->MakeOnCpu(settings));
  }
  made->options_.keep_going = nullptr;  // its captured references may become invalid
  return made;
}

/// Creates the renderer on the device; no effect if the device is the CPU.
Status DeviceRenderer::MakeOnDevice(const Device& device, const RenderSettings& settings) {
  on_device_ = false;
#ifdef STILLRAY_WITH_VULKAN
  const auto backend = std::dynamic_pointer_cast<vulkan::VulkanBackend>(BackendOf(device));
  if (backend != nullptr) {
    on_device_ = true;
    render::VulkanRenderOptions options;
    options.way = options_.way;
    options.first_hits = options_.first_hits;
    options.textures = options_.textures;
    options.submission_ms = options_.submission_ms;
    Result<std::unique_ptr<Renderer>> made =
        render::CreateVulkanRenderer(scene_, settings, backend->device(), options);
    STILLRAY_RETURN_IF_ERROR(made.status());
    renderer_ = std::move(*made);
    place_ = device.description();
  }
#else
  static_cast<void>(device);  // without Vulkan there is only the CPU
  static_cast<void>(settings);
#endif
  return Status::Ok();
}

Status DeviceRenderer::MakeOnCpu(const RenderSettings& settings) {
  Result<std::unique_ptr<Renderer>> made = Renderer::Create(scene_, settings, options_.keep_going);
  STILLRAY_RETURN_IF_ERROR(made.status());
  renderer_ = std::move(*made);
  on_device_ = false;
  place_ = Device().description();
  return Status::Ok();
}

bool DeviceRenderer::FallsBack(const Status& status) const {
  return !status.ok() && on_device_ && options_.may_fall_back &&
         status.code() != StatusCode::kCancelled && status.code() != StatusCode::kInvalidArgument;
}

/// \param call  call of the renderer, repeated on the CPU if the device fails
template <typename Call>
Status DeviceRenderer::CallOrFallBack(const Call& call) {
  const Status status = call();
  if (!FallsBack(status)) {
    return status;
  }
  remark_ = status.message();
  STILLRAY_RETURN_IF_ERROR(MakeOnCpu(RenderSettings(renderer_->settings())));
  return call();
}

Status DeviceRenderer::SetSettings(const RenderSettings& settings) {
  return CallOrFallBack([&] { return renderer_->SetSettings(settings); });
}

Status DeviceRenderer::TraceFrame(const RenderMoment& moment, Frame* frame,
                                  const RenderProgress& progress) {
  return CallOrFallBack([&] { return renderer_->RenderFrame(moment, frame, progress); });
}

Status DeviceRenderer::TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                                      const RenderProgress& progress) {
  return CallOrFallBack(
      [&] { return renderer_->RenderReference(moment, spp, radiance, progress); });
}

std::string DeviceRenderer::TakeRemark() {
  return std::exchange(remark_, {});
}

Result<render::TracingWay> ParseTracingWay(const std::string& text) {
  if (text == "auto") {
    return render::TracingWay::kAuto;
  }
  if (text == "hardware") {
    return render::TracingWay::kHardware;
  }
  if (text == "compute") {
    return render::TracingWay::kCompute;
  }
  constexpr std::string_view kWays[] = {"auto", "hardware", "compute"};
  return Status::InvalidArgument(
      fmt::format("--ray-tracing is '{}', expected auto, hardware or compute{}", text,
                  DidYouMean(text, kWays)));
}

Result<render::FirstHits> ParseFirstHits(const std::string& text) {
  if (text == "auto") {
    return render::FirstHits::kAuto;
  }
  if (text == "draw") {
    return render::FirstHits::kDraw;
  }
  if (text == "trace") {
    return render::FirstHits::kTrace;
  }
  constexpr std::string_view kWays[] = {"auto", "draw", "trace"};
  return Status::InvalidArgument(fmt::format("--first-hits is '{}', expected auto, draw or trace{}",
                                             text, DidYouMean(text, kWays)));
}

Result<render::TextureWay> ParseTextureWay(const std::string& text) {
  if (text == "auto") {
    return render::TextureWay::kAuto;
  }
  if (text == "exact") {
    return render::TextureWay::kExact;
  }
  if (text == "sampled") {
    return render::TextureWay::kSampled;
  }
  constexpr std::string_view kWays[] = {"auto", "exact", "sampled"};
  return Status::InvalidArgument(fmt::format(
      "--textures is '{}', expected auto, exact or sampled{}", text, DidYouMean(text, kWays)));
}

std::string TracingWayText(const Device& device, const TraceOptions& options) {
#ifdef STILLRAY_WITH_VULKAN
  const auto backend = std::dynamic_pointer_cast<vulkan::VulkanBackend>(BackendOf(device));
  if (backend != nullptr) {
    const gpu::DeviceInfo& info = backend->device()->info();
    const Result<bool> hardware = render::UsesHardware(*backend->device(), options.way);
    const bool by_hardware = hardware.ok() && *hardware;
    const bool emulated = info.is_gpu && info.ray_tracing.offered && !render::TracesByUnits(info);
    std::string text = by_hardware ? "by hardware" : "in compute shaders";
    if (emulated && !by_hardware && options.way == render::TracingWay::kAuto) {
      text += " (the driver offers no ray queries: it emulates ray tracing pipelines)";
    }
    const bool draws =
        render::DrawsFirstHits(info, options.first_hits) && backend->device()->can_draw();
    text += draws ? ", first hits are drawn" : ", first hits too";
    return text + (render::SamplesTextures(info, options.textures) ? ", textures are sampled" : "");
  }
#else
  static_cast<void>(device);
  static_cast<void>(options);
#endif
  return {};
}

void KeepCompiledShaders() {
#ifdef STILLRAY_WITH_VULKAN
  gpu::SetPipelineCacheFolder(gpu::UserCacheFolder());
#endif
}

std::vector<std::string> RayTracingDevices() {
  std::vector<std::string> found;
#ifdef STILLRAY_WITH_VULKAN
  const Result<std::shared_ptr<gpu::Instance>> instance = gpu::Instance::Create();
  if (!instance.ok()) {
    return found;
  }
  const Result<std::vector<gpu::DeviceInfo>> devices = (*instance)->ListDevices();
  if (!devices.ok()) {
    return found;
  }
  for (const gpu::DeviceInfo& info : *devices) {
    if (info.usable.ok() && info.ray_tracing.offered) {
      found.push_back(fmt::format("vulkan:{}", info.index));
    }
  }
#endif
  return found;
}

std::vector<LoggedStage> TraceStages(const RenderTimings& timings) {
  return {{"trace_guides", timings.primary_ms},       {"trace_shading", timings.shade_ms},
          {"trace_shadow_rays", timings.shadow_ms},   {"trace_bounce_rays", timings.bounce_ms},
          {"trace_virtual_guides", timings.image_ms}, {"trace_copy", timings.copy_ms}};
}

}  // namespace stillray
