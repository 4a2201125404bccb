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
#include "core/nearest_names.h"
#include "render/lens.h"
#include "render/render_files.h"
#include "render/virtual_image.h"
#include "sequence/frame_loop.h"

namespace stillray {

double FrameWork(const RenderOptions& options, int64_t frame) {
  return SamplesPerPixel(options.render) + 4.0 +
         (options.WantsReference(frame) ? options.text.reference_spp : 0);
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

Status FrameMaker::Prepare(const Device& device) {
  STILLRAY_RETURN_IF_ERROR(PrepareLens());
  STILLRAY_RETURN_IF_ERROR(MakeRenderer(device));
  Result<Denoiser> denoiser = Denoiser::Create(options_.denoise, device);
  STILLRAY_RETURN_IF_ERROR(denoiser.status());
  denoiser_.emplace(std::move(denoiser.value()));
  return denoiser_->SetOutputs(options_.outputs);
}

/// Whether frames have virtual guides that the denoiser or a file uses.
bool FrameMaker::NeedsVirtualGuides() const {
  const bool used = options_.denoise.virtual_roughness > 0 || PlanesInFiles(options_) == kAllPlanes;
  return used && render::FramesShowImages(scene_, options_.render, camera_);
}

/// With --device auto, the CPU traces if the device cannot.
Status FrameMaker::MakeRenderer(const Device& device) {
  TraceOptions options;
  options.way = options_.tracing_way;
  options.first_hits = options_.first_hits;
  options.may_fall_back =
      options_.text.device == "auto" && options.way != render::TracingWay::kHardware;
  options.keep_going = [] { return !Interrupted(); };
  RenderSettings settings = options_.render;
  // The denoiser is on the same device, but frames there have no virtual guides.
  settings.on_device = !NeedsVirtualGuides();
  Result<std::unique_ptr<DeviceRenderer>> renderer =
      DeviceRenderer::Create(device, scene_, settings, options);
  if (renderer.status().code() == StatusCode::kCancelled) {
    return Status(StatusCode::kCancelled, "stopped while the BVH was built");
  }
  STILLRAY_RETURN_IF_ERROR(renderer.status());
  renderer_ = std::move(renderer.value());
  PrintTracingOnCpu();
  if (renderer_->on_device()) {
    PrintTo(stderr, "rays are traced {}\n", TracingWayText(device, options));
  }
  return Status::Ok();
}

void FrameMaker::PrintTracingOnCpu() {
  if (const std::string remark = renderer_->TakeRemark(); !remark.empty()) {
    PrintTo(stderr, "tracing on the CPU: {}\n", remark);
  }
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

RenderProgress FrameMaker::Shown(int64_t number, Progress* progress) const {
  return [this, number, progress](double part) {
    progress->Update(WorkBefore(options_, number) + part * SamplesPerPixel(options_.render),
                     FrameText(options_, number));
    return !Interrupted();
  };
}

Status FrameMaker::RenderReference(const RenderMoment& moment, Progress* progress,
                                   Image3* reference) {
  const int64_t number = moment.frame_index;
  const double before = WorkBefore(options_, number) + SamplesPerPixel(options_.render);
  const int spp = options_.text.reference_spp;
  return renderer_->RenderReference(moment, spp, reference, [&](double part) {
    progress->Update(before + part * spp, FrameText(options_, number) + ", reference");
    return !Interrupted();
  });
}

Status FrameMaker::Trace(const RenderMoment& moment, Progress* progress, RenderPicture* picture) {
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(
      renderer_->RenderFrame(moment, &picture->frame, Shown(moment.frame_index, progress)));
  PrintTracingOnCpu();
  picture->log.render_ms = MillisecondsSince(start);
  if (renderer_->on_device()) {
    picture->log.stages = TraceStages(renderer_->timings());
  }
  picture->reference = Image3();
  return options_.WantsReference(moment.frame_index)
             ? RenderReference(moment, progress, &picture->reference)
             : Status::Ok();
}

/// If the denoiser falls back to the CPU, later frames are rendered to the host; this one is traced
/// again, as it may be lost with the device.
Status FrameMaker::Denoise(const RenderMoment& moment, Progress* progress, RenderPicture* picture) {
  const Status status = denoiser_->Denoise(picture->frame, &picture->denoised);
  if (denoiser_->remark().empty() || !renderer_->settings().on_device) {
    return status;
  }
  RenderSettings settings = renderer_->settings();
  settings.on_device = false;
  STILLRAY_RETURN_IF_ERROR(renderer_->SetSettings(settings));
  if (status.ok()) {
    return status;
  }
  STILLRAY_RETURN_IF_ERROR(
      renderer_->RenderFrame(moment, &picture->frame, Shown(moment.frame_index, progress)));
  PrintTracingOnCpu();
  return denoiser_->Denoise(picture->frame, &picture->denoised);
}

/// Not on the writer's thread, which would have to wait for the device while that traces the next
/// frame.
Status FrameMaker::BringToHost(RenderPicture* picture) const {
  picture->in_files = &picture->frame;
  const uint32_t planes = PlanesInFiles(options_);
  if (picture->frame.on_device == nullptr || planes == 0) {
    return Status::Ok();
  }
  const Clock::time_point start = Clock::now();
  const Result<const Frame*> brought = OnHost(picture->frame, &picture->on_host, planes);
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
  STILLRAY_RETURN_IF_ERROR(Trace(moment, progress, picture));
  if (earlier != nullptr) {
    STILLRAY_RETURN_IF_ERROR(BringToHost(picture));
    STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->reference, picture));
    picture->denoised = DenoisedFrame();
    picture->denoised.colour = std::move(earlier->colour);
    picture->denoised.images = std::move(earlier->images);
    return Status::Ok();
  }
  // Until its picture is written, no saved state matches the history.
  history_is_whole_ = false;
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(Denoise(moment, progress, picture));
  TellFallBack(*denoiser_, &printed_fall_back_);
  picture->log.denoise_ms = MillisecondsSince(start);
  const std::vector<LoggedStage> filtered = LoggedStages(picture->denoised.timings);
  picture->log.stages.insert(picture->log.stages.end(), filtered.begin(), filtered.end());
  STILLRAY_RETURN_IF_ERROR(BringToHost(picture));
  STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->denoised.colour, picture));
  // It is traced through a pinhole too: with the same effects it stays a reference.
  STILLRAY_RETURN_IF_ERROR(ApplyPost(&picture->reference, picture));
  history_is_whole_ = true;
  last_filtered_ = number;
  return Status::Ok();
}

}  // namespace stillray
