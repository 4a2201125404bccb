// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/frame_maker.h"

#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/console.h"
#include "common/device_option.h"
#include "common/interrupt.h"
#include "core/check.h"
#include "core/nearest_names.h"
#include "render/lens.h"
#include "render/render_files.h"
#include "render/virtual_image.h"
#include "sequence/frame_loop.h"

namespace stillray {

namespace {

/// The cost of a frame's tracing, in samples per pixel.
double TraceWork(const RenderOptions& options, int64_t frame) {
  return SamplesPerPixel(options.render) +
         (options.WantsReference(frame) ? options.text.reference_spp : 0);
}

void PrintTracingOnCpu(const std::string& reason) {
  if (!reason.empty()) {
    PrintTo(stderr, "tracing on the CPU: {}\n", reason);
  }
}

}  // namespace

double FrameWork(const RenderOptions& options, int64_t frame) {
  return TraceWork(options, frame) + 4.0;
}

double WorkBefore(const RenderOptions& options, int64_t frame) {
  double work = 0;
  for (int64_t f = options.frames.first; f < frame; ++f) {
    work += FrameWork(options, f);
  }
  return work;
}

std::string FrameText(const RenderOptions& options, int64_t frame) {
  return fmt::format("frame {} of {}", frame, options.frames.last);
}

Status FrameMaker::FindCamera() {
  const std::string& wanted = options_.text.camera;
  if (wanted.empty()) {
    return Status::Ok();
  }
  std::vector<std::string> names;
  for (size_t i = 0; i < scene_.cameras.size(); ++i) {
    const std::string& name = scene_.cameras[i].name;
    if (name == wanted || std::to_string(i) == wanted) {
      camera_ = static_cast<int>(i);
      return Status::Ok();
    }
    names.push_back(name);
  }
  return Status::NotFound(fmt::format("--camera is '{}', the scene has: {}{}", wanted,
                                      fmt::join(names, ", "), DidYouMeanOneOf(wanted, names)));
}

Status FrameMaker::PrepareLens() {
  if (!options_.post.depth_of_field) {
    return Status::Ok();
  }
  const Lens lens = render::LensOf(scene_, options_.lens, camera_);
  const auto camera = static_cast<size_t>(camera_);
  const float yfov = camera < scene_.cameras.size() ? scene_.cameras[camera].yfov : Camera().yfov;
  lens_ = ThinLensOf(lens, yfov, options_.render.width, options_.render.height);
  if (!(lens_.radius > 0.0f)) {
    return Status::InvalidArgument(
        "--post dof needs a lens, expected --aperture RADIUS or f/N: the scene's camera is a "
        "pinhole");
  }
  return Status::Ok();
}

Status FrameMaker::Prepare(const RenderDevices& devices, bool ahead) {
  STILLRAY_RETURN_IF_ERROR(PrepareLens());
  STILLRAY_RETURN_IF_ERROR(MakeRenderer(devices));
  traces_ahead_ = devices.differ() && ahead;
  Result<Denoiser> denoiser = Denoiser::Create(options_.denoise, devices.filter);
  STILLRAY_RETURN_IF_ERROR(denoiser.status());
  denoiser_.emplace(std::move(denoiser.value()));
  return denoiser_->SetOutputs(options_.outputs);
}

/// Creates the renderer; with "auto", falls back to the CPU if the device cannot trace the scene.
Status FrameMaker::MakeRenderer(const RenderDevices& devices) {
  const std::string& chosen =
      options_.text.trace_device.empty() ? options_.text.device : options_.text.trace_device;
  TraceOptions options;
  options.way = options_.tracing_way;
  options.first_hits = options_.first_hits;
  options.textures = options_.textures;
  options.may_fall_back = chosen == "auto" && options.way != render::TracingWay::kHardware &&
                          options.textures != render::TextureWay::kSampled;
  options.keep_going = [] { return !Interrupted(); };
  RenderSettings settings = options_.render;
  on_device_ = !devices.differ();
  settings.on_device = on_device_;
  Result<std::unique_ptr<DeviceRenderer>> renderer =
      DeviceRenderer::Create(devices.tracer, scene_, settings, options);
  if (renderer.status().code() == StatusCode::kCancelled) {
    return Status(StatusCode::kCancelled, "stopped while the BVH was built");
  }
  STILLRAY_RETURN_IF_ERROR(renderer.status());
  renderer_ = std::move(renderer.value());
  place_ = renderer_->place();
  PrintTracingOnCpu(renderer_->TakeRemark());
  if (renderer_->on_device()) {
    PrintTo(stderr, "rays are traced {}\n", TracingWayText(devices.tracer, options));
  }
  return Status::Ok();
}

Status FrameMaker::RestoreHistory(const std::vector<uint8_t>& history, int64_t last) {
  STILLRAY_RETURN_IF_ERROR(denoiser_->RestoreHistory(history));
  last_filtered_ = last;
  return Status::Ok();
}

RenderMoment FrameMaker::MomentOf(int64_t number) const {
  RenderMoment moment;
  moment.frame_index = number;
  moment.seconds = options_.Seconds(number);
  moment.previous_seconds = options_.PreviousSeconds(number);
  moment.camera = camera_;
  return moment;
}

/// Callback that shows the progress of tracing a frame, as a fraction of its TraceWork.
RenderProgress FrameMaker::Shown(int64_t number, Progress* progress) const {
  return [this, number, progress](double part) {
    const double done = part * TraceWork(options_, number);
    const bool reference = done > SamplesPerPixel(options_.render);
    progress->Update(WorkBefore(options_, number) + done,
                     FrameText(options_, number) + (reference ? ", reference" : ""));
    return !Interrupted();
  };
}

/// \param progress  total progress of frame and reference
Status FrameMaker::Trace(int64_t number, const RenderProgress& progress, TracedFrame* traced) {
  const RenderMoment moment = MomentOf(number);
  const double work = TraceWork(options_, number);
  const double samples = SamplesPerPixel(options_.render);
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(renderer_->RenderFrame(
      moment, &traced->frame, [&](double part) { return progress(part * samples / work); }));
  traced->milliseconds = MillisecondsSince(start);
  traced->stages.clear();
  if (renderer_->on_device()) {
    traced->stages = TraceStages(renderer_->timings());
  }
  traced->reference = Image3();
  if (options_.WantsReference(number)) {
    const int spp = options_.text.reference_spp;
    STILLRAY_RETURN_IF_ERROR(renderer_->RenderReference(
        moment, spp, &traced->reference,
        [&](double part) { return progress((samples + part * spp) / work); }));
  }
  traced->renderer_bytes = renderer_->memory_bytes();
  traced->on_cpu = renderer_->TakeRemark();
  return Status::Ok();
}

/// Traces the frame, or waits for it, and starts tracing the next frame.
Status FrameMaker::TakeTraced(int64_t number, Progress* progress, RenderPicture* picture) {
  const RenderProgress shown = Shown(number, progress);
  if (ahead_.under_way()) {
    STILLRAY_CHECK_EQ(number, next_number_);
    STILLRAY_RETURN_IF_ERROR(ahead_.Take(shown));
    std::swap(picture->traced, next_);
  } else {
    STILLRAY_RETURN_IF_ERROR(Trace(number, shown, &picture->traced));
  }
  PrintTracingOnCpu(picture->traced.on_cpu);
  if (traces_ahead_ && number < options_.frames.last) {
    next_number_ = number + 1;
    ahead_.Start([this](const RenderProgress& going_on) {
      return Trace(
          next_number_, [&](double part) { return going_on(part) && !Interrupted(); }, &next_);
    });
  }
  return Status::Ok();
}

/// Denoises the frame. If the denoiser falls back to the CPU, later frames are rendered to host
/// memory; the current frame is traced again, since it may be lost with the device.
Status FrameMaker::Denoise(const RenderMoment& moment, Progress* progress, RenderPicture* picture) {
  Frame& frame = picture->traced.frame;
  const Status status = denoiser_->Denoise(frame, &picture->denoised);
  if (denoiser_->remark().empty() || !on_device_) {
    return status;
  }
  on_device_ = false;
  RenderSettings settings = renderer_->settings();
  settings.on_device = false;
  STILLRAY_RETURN_IF_ERROR(renderer_->SetSettings(settings));
  if (status.ok()) {
    return status;
  }
  STILLRAY_RETURN_IF_ERROR(
      renderer_->RenderFrame(moment, &frame, Shown(moment.frame_index, progress)));
  PrintTracingOnCpu(renderer_->TakeRemark());
  return denoiser_->Denoise(frame, &picture->denoised);
}

/// Downloads the frame here instead of on the writer's thread, which would wait for the device
/// while it traces the next frame.
Status FrameMaker::BringToHost(RenderPicture* picture) const {
  const Frame& frame = picture->traced.frame;
  picture->in_files = &frame;
  const uint32_t planes = PlanesInFiles(options_);
  if (frame.on_device == nullptr || planes == 0) {
    return Status::Ok();
  }
  const Clock::time_point start = Clock::now();
  const Result<const Frame*> brought = OnHost(frame, &picture->on_host, planes);
  STILLRAY_RETURN_IF_ERROR(brought.status());
  picture->in_files = *brought;
  picture->log.stages.push_back({"frame_to_host", MillisecondsSince(start)});
  return Status::Ok();
}

Status FrameMaker::ApplyPost(Image3* colour, RenderPicture* picture) const {
  if (!options_.post.any() || colour->empty()) {
    return Status::Ok();
  }
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(
      ApplyPostEffects(options_.post, lens_, picture->in_files->guides, colour));
  picture->log.stages.push_back({"post", MillisecondsSince(start)});
  return Status::Ok();
}

Status FrameMaker::Make(int64_t number, UnwrittenFrame* earlier, Progress* progress,
                        RenderPicture* picture) {
  const RenderMoment moment = MomentOf(number);
  picture->log = FrameLog();
  picture->log.frame = number;
  picture->log.seconds = moment.seconds;
  STILLRAY_RETURN_IF_ERROR(TakeTraced(number, progress, picture));
  picture->log.render_ms = picture->traced.milliseconds;
  picture->log.stages = picture->traced.stages;
  if (earlier != nullptr) {
    STILLRAY_RETURN_IF_ERROR(BringToHost(picture));
    STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->traced.reference, picture));
    picture->denoised = DenoisedFrame();
    picture->denoised.colour = std::move(earlier->colour);
    picture->denoised.images = std::move(earlier->images);
    return Status::Ok();
  }
  // Until the image is written, no saved state matches the history.
  history_is_whole_ = false;
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(Denoise(moment, progress, picture));
  TellFallBack(*denoiser_, &printed_fall_back_);
  picture->log.denoise_ms = MillisecondsSince(start);
  const std::vector<LoggedStage> filtered = LoggedStages(picture->denoised.timings);
  picture->log.stages.insert(picture->log.stages.end(), filtered.begin(), filtered.end());
  STILLRAY_RETURN_IF_ERROR(BringToHost(picture));
  STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->denoised.colour, picture));
  // The reference is also traced with a pinhole camera, hence it needs the same effects.
  STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->traced.reference, picture));
  history_is_whole_ = true;
  last_filtered_ = number;
  return Status::Ok();
}

}  // namespace stillray
