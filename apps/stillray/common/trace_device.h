// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on any device.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/log_parts.h"
#include "render/vulkan/tracing_way.h"
#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray {

struct TraceOptions {
  /// Tracing method on devices other than the CPU.
  render::TracingWay way = render::TracingWay::kAuto;
  render::FirstHits first_hits = render::FirstHits::kAuto;
  render::TextureWay textures = render::TextureWay::kAuto;
  /// Fall back to the CPU if the device cannot trace the scene, or fails.
  bool may_fall_back = true;
  /// Approximate duration of a submission to the device in milliseconds, for which other users of
  /// the device and cancelled calls wait.
  double submission_ms = 200;
  /// Called while DeviceRenderer::Create prepares the scene on the CPU; see Renderer::Create.
  KeepGoing keep_going;
};

/// A renderer on a device that falls back to the CPU if the device fails. Errors of settings or
/// scene, which would also occur on the CPU, are returned.
class DeviceRenderer final : public Renderer {
 public:
  /// \param device  may be the CPU
  /// \param scene   must outlive the renderer and must not change
  /// \return see Renderer::Create; also kUnsupported, unless it falls back: the device lacks a
  ///     feature, such as the method requested by `way`, or the scene does not fit into its memory
  static Result<std::unique_ptr<DeviceRenderer>> Create(const Device& device, const Scene& scene,
                                                        const RenderSettings& settings,
                                                        const TraceOptions& options = {});

  Status SetSettings(const RenderSettings& settings) override;
  const RenderSettings& settings() const override { return renderer_->settings(); }
  const RenderTimings& timings() const override { return renderer_->timings(); }
  size_t memory_bytes() const override { return renderer_->memory_bytes(); }

  /// Whether frames are currently traced on a device other than the CPU. Timings are then measured
  /// on the device, and are not sums over threads.
  bool on_device() const { return on_device_; }
  /// Description of the tracing device.
  const std::string& place() const { return place_; }
  /// The reason for a fallback to the CPU; empty without a fallback, and after the first call.
  std::string TakeRemark();

 private:
  Status TraceFrame(const RenderMoment& moment, Frame* frame,
                    const RenderProgress& progress) override;
  Status TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                        const RenderProgress& progress) override;
  DeviceRenderer(const Scene& scene, const TraceOptions& options)
      : scene_(scene), options_(options) {}
  Status MakeOnDevice(const Device& device, const RenderSettings& settings);
  Status MakeOnCpu(const RenderSettings& settings);
  bool FallsBack(const Status& status) const;
  template <typename Call>
  Status CallOrFallBack(const Call& call);

  const Scene& scene_;
  TraceOptions options_;
  std::unique_ptr<Renderer> renderer_;
  bool on_device_ = false;
  std::string place_;
  std::string remark_;
};

/// "--ray-tracing": auto, hardware or compute.
/// \return kInvalidArgument
Result<render::TracingWay> ParseTracingWay(const std::string& text);
/// "--first-hits": draw, trace or auto.
/// \return kInvalidArgument
Result<render::FirstHits> ParseFirstHits(const std::string& text);
/// "--textures": sampled, exact or auto.
/// \return kInvalidArgument
Result<render::TextureWay> ParseTextureWay(const std::string& text);
/// The methods for tracing rays and primary hits, for messages: "in compute shaders, first hits are
/// drawn"; empty for the CPU. Includes the reason if the driver supports ray tracing pipelines that
/// are not used.
std::string TracingWayText(const Device& device, const TraceOptions& options);

/// Enables the pipeline cache in the user's cache folder (gpu/pipeline_cache.h). Call it before the
/// first device is opened.
void KeepCompiledShaders();

/// Devices with ray tracing hardware, as "vulkan:N".
std::vector<std::string> RayTracingDevices();

/// The device times of a frame, for a renderer that is not on the CPU.
std::vector<LoggedStage> TraceStages(const RenderTimings& timings);

}  // namespace stillray
