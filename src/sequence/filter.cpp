// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/filter.h"

#include <utility>

#include <fmt/format.h>

#include "io/aov_seen.h"
#include "sequence/byte_blocks.h"
#include "sequence/frame_loop.h"
#include "sequence/memory.h"

namespace stillray {
Status SequenceFilter::Prepare(const Device& device, size_t held, bool ahead,
                               FuturePass::Step step) {
  Result<Denoiser> denoiser = Denoiser::Create(settings_, device);
  STILLRAY_RETURN_IF_ERROR(denoiser.status());
  denoiser_.emplace(std::move(denoiser.value()));
  std::vector<std::string> outputs;
  if (view_.options.passes) {
    splitter_.emplace(settings_, device);
    outputs = PassSplitter::Outputs();
  }
  if (view_.options.denoise_alpha) {
    alpha_.emplace(settings_, device);
  }
  if (settings_.temporal) {
    outputs.emplace_back("disocclusion");
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->SetOutputs(outputs));
  if (view_.options.window == Window::kBoth) {
    Result<Denoiser> backward = Denoiser::Create(settings_, device);
    STILLRAY_RETURN_IF_ERROR(backward.status());
    future_.emplace(view_, std::move(backward.value()), held, ahead, std::move(step));
    if (alpha_) {
      Result<Denoiser> of_alpha = Denoiser::Create(SettingsOfAlpha(settings_), device);
      STILLRAY_RETURN_IF_ERROR(of_alpha.status());
      future_->AddAlpha(std::move(of_alpha.value()));
    }
  }
  return Status::Ok();
}

std::string SequenceFilter::NoteOf(Link link, const Frame& frame) const {
  switch (link) {
    case Link::kContinues:
      return "";
    case Link::kResized:
      return fmt::format("{} x {} pixels in place of {} x {}", frame.width, frame.height,
                         previous_->frame.width, previous_->frame.height);
    case Link::kCut:
      return "hardly anything of the frame before is found again, a cut";
    case Link::kGap:
      break;
  }
  return fmt::format("frames after {} are missing", previous_->frame.index);
}

Link SequenceFilter::LinkFrame(SequenceFrame* frame, FrameReport* report) {
  motion_was_seen_ = motion_was_seen_ || !IsStill(frame->frame.guides.motion);
  const Link link =
      settings_.temporal && previous_ ? LinkToPrevious(*previous_, view_, frame) : Link::kContinues;
  motion_was_seen_ = motion_was_seen_ || !IsStill(frame->frame.guides.motion);
  report->motion = MotionKindName(frame->origin.kind);
  report->motion_estimated = frame->origin.estimated;
  report->motion_unknown = frame->origin.unknown;
  if (link == Link::kContinues) {
    report->images_missing = io::LackOfImages(view_.layout, frame->images.missing);
  }
  if (link != Link::kContinues) {
    denoiser_->Reset();
    if (splitter_) {
      splitter_->Reset();
    }
    if (alpha_) {
      alpha_->Reset();
    }
    report->restarted = true;
  }
  return link;
}

Status SequenceFilter::Filter(SequenceFrame* frame, size_t at, FrameReport* report, Image3* colour,
                              std::vector<NewLayer>* layers) {
  const Clock::time_point start = Clock::now();
  const Link link = LinkFrame(frame, report);
  FutureLight future;
  FutureLight future_alpha;
  if (future_) {
    const Clock::time_point future_start = Clock::now();
    STILLRAY_RETURN_IF_ERROR(future_->Take(at, &future, &future_alpha));
    report->future_ms = MillisecondsSince(future_start);
  }
  const Status filtered = denoiser_->Denoise(frame->frame, future, &denoised_);
  if (!filtered.ok()) {
    return Status(filtered.code(), fmt::format("{}: {}", report->input, filtered.message()));
  }
  frames_ = at + 1;
  layers->clear();
  if (splitter_) {
    STILLRAY_RETURN_IF_ERROR(splitter_->Split(frame->frame, view_.layout, std::move(frame->parts),
                                              denoised_, &denoised_.colour, layers));
  }
  if (alpha_) {
    STILLRAY_RETURN_IF_ERROR(alpha_->Filter(frame->frame, future_alpha, &frame->alpha));
    NewLayer& layer = layers->emplace_back();
    layer.aov = Aov::kAlpha;
    layer.values[0] = std::move(frame->alpha);
  }
  report->without_history = settings_.temporal ? PartWithoutHistory(denoised_, frame->frame) : 1.0;
  report->denoise_ms = MillisecondsSince(start) - report->future_ms;
  report->missing_light = denoised_.non_finite + denoised_.negative;
  report->negative_light = denoised_.negative;
  report->bad_guides = denoised_.bad_guides;
  report->stages = LoggedStages(denoised_.timings);
  report->note = NoteOf(link, frame->frame);
  report->warning = denoised_.warning;
  *colour = std::move(denoised_.colour);
  return Status::Ok();
}

void SequenceFilter::Skip(SequenceFrame frame) {
  motion_was_seen_ = motion_was_seen_ || !IsStill(frame.frame.guides.motion);
  SetPrevious(std::move(frame));
}

void SequenceFilter::SetPrevious(SequenceFrame frame) {
  KeepGuidesOnly(&frame);
  previous_ = std::move(frame);
}

/// Blocks: the history of the radiance, then the histories of its parts and of alpha, if denoised.
Result<std::vector<uint8_t>> SequenceFilter::SaveHistory() const {
  std::vector<uint8_t> bytes;
  const auto append = [&](const Result<std::vector<uint8_t>>& history) {
    if (history.ok()) {
      AppendBlock(*history, &bytes);
    }
    return history.status();
  };
  STILLRAY_RETURN_IF_ERROR(append(denoiser_->SaveHistory()));
  if (splitter_) {
    STILLRAY_RETURN_IF_ERROR(append(splitter_->SaveHistory()));
  }
  if (alpha_) {
    STILLRAY_RETURN_IF_ERROR(append(alpha_->SaveHistory()));
  }
  return bytes;
}

Status SequenceFilter::RestoreHistory(std::span<const uint8_t> bytes, size_t frames,
                                      const std::string& name) {
  const Status cut_short = Status::BadData(name + " is damaged: its history is cut short");
  std::span<const uint8_t> light;
  std::span<const uint8_t> parts;
  std::span<const uint8_t> alpha;
  if (!TakeBlock(&bytes, &light) || (splitter_ && !TakeBlock(&bytes, &parts)) ||
      (alpha_ && !TakeBlock(&bytes, &alpha)) || !bytes.empty()) {
    return cut_short;
  }
  if (splitter_) {
    STILLRAY_RETURN_IF_ERROR(splitter_->RestoreHistory(parts));
  }
  if (alpha_) {
    STILLRAY_RETURN_IF_ERROR(alpha_->RestoreHistory(alpha));
  }
  STILLRAY_RETURN_IF_ERROR(denoiser_->RestoreHistory(light));
  frames_ = frames;
  return Status::Ok();
}

const std::string& SequenceFilter::remark() const {
  return denoiser_->remark().empty() && future_ ? future_->remark() : denoiser_->remark();
}

size_t SequenceFilter::memory_bytes() const {
  return denoiser_->memory_bytes() + (future_ ? future_->memory_bytes() : 0) +
         (splitter_ ? splitter_->memory_bytes() : 0) + (alpha_ ? alpha_->memory_bytes() : 0);
}

DeviceMemory SequenceFilter::device_memory() const {
  DeviceMemory sum = denoiser_->device_memory();
  if (future_) {
    AddDeviceMemory(future_->device_memory(), &sum);
  }
  if (splitter_) {
    AddDeviceMemory(splitter_->device_memory(), &sum);
  }
  if (alpha_) {
    AddDeviceMemory(alpha_->device_memory(), &sum);
  }
  return sum;
}

}  // namespace stillray
