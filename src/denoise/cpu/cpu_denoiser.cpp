// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/cpu_denoiser.h"

#include <utility>

#include "denoise/copy_image.h"
#include "denoise/cpu/history_bytes.h"
#include "denoise/cpu/pipeline.h"
#include "denoise/frame_check.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

void MakePicture(const Image3& like, Image3* to) {
  if (to->width() != like.width() || to->height() != like.height()) {
    *to = Image3(like.width(), like.height());
  }
}

class CpuDenoiser : public DenoiserBackend {
 public:
  CpuDenoiser(const Settings& settings, const StageTable& stages)
      : settings_(settings), stages_(stages) {}

  Status Denoise(const Frame& frame, std::span<const SignalHistory> future,
                 DenoisedFrame* out) override;
  Status Accumulate(const Frame& frame, std::vector<SignalHistory>* future) override;
  Status SetSettings(const Settings& settings) override;
  void SetResults(const Results& wanted) override { results_ = wanted; }
  Status ReadColour(Image3* colour) override;
  void SetOutputs(std::vector<std::string> names) override { outputs_ = std::move(names); }
  void Reset() override;
  size_t memory_bytes() const override { return history_.bytes() + work_.bytes(); }
  DeviceMemory device_memory() const override { return {}; }
  Result<std::vector<uint8_t>> SaveHistory() override { return HistoryToBytes(history_); }
  Status RestoreHistory(std::span<const uint8_t> bytes) override;

 private:
  struct Begun {
    FramePlan plan;
    OddValues odd;
  };
  Result<Begun> Begin(const Frame& frame, FrameFacts facts);
  SequenceProgress ProgressFor(const Frame& frame, const FrameFacts& facts) const;
  CpuPipeline PipelineOf(const FramePlan& plan) const;
  void HandOver(const FramePlan& plan, DenoisedFrame* out) const;

  Settings settings_;
  const StageTable& stages_;
  Results results_;
  std::vector<std::string> outputs_;
  History history_;
  FrameWork work_;
  bool has_result_ = false;  ///< history_.picture is the output of the last frame
  Frame from_device_;        ///< host copy of a frame on a device
};

/// The progress of the sequence, or of a new sequence if the history does not fit the frame.
SequenceProgress CpuDenoiser::ProgressFor(const Frame& frame, const FrameFacts& facts) const {
  if (history_.Fits(frame.width, frame.height, LayersOf(settings_, facts), LayoutOf(settings_))) {
    return history_.progress;
  }
  SequenceProgress progress;
  progress.jittered = history_.progress.jittered && history_.width == frame.width &&
                      history_.height == frame.height;
  return progress;
}

/// Checks the frame, makes its plan and allocates its memory. The history is unchanged on failure.
Result<CpuDenoiser::Begun> CpuDenoiser::Begin(const Frame& frame, FrameFacts facts) {
  const SequenceProgress progress = ProgressFor(frame, facts);
  const MotionUse use = UseOfMotion(settings_, IsJittered(facts), progress);
  STILLRAY_RETURN_IF_ERROR(CheckFrame(frame, settings_, use));
  Begun begun;
  begun.odd = FindOddValues(frame, use);
  facts.has_incomplete_guides = settings_.fill_guides && HasIncompleteGuides(frame);
  facts.samples_per_pixel = SamplesPerPixel(frame, &work_.row_sums);
  begun.plan = MakePlan(settings_, facts, progress);
  MakeRoom(begun.plan, frame.width, frame.height, &work_);
  if (FitHistory(begun.plan, frame.width, frame.height, work_.border(), &history_)) {
    has_result_ = false;
  }
  history_.progress = progress;
  return begun;
}

CpuPipeline CpuDenoiser::PipelineOf(const FramePlan& plan) const {
  const Fusion fusion = &stages_ == &kCpuStages ? ChooseFusion(plan, !outputs_.empty()) : Fusion();
  return {stages_, plan, fusion, outputs_};
}

Status CpuDenoiser::Denoise(const Frame& given, std::span<const SignalHistory> future,
                            DenoisedFrame* out) {
  const Result<const Frame*> host = OnHost(given, &from_device_);
  STILLRAY_RETURN_IF_ERROR(host.status());
  const Frame& frame = **host;
  FrameFacts facts = FactsOf(frame);
  facts.has_future = !future.empty();
  facts.is_displayed = results_.display || results_.shared;
  Result<Begun> begun = Begin(frame, facts);
  STILLRAY_RETURN_IF_ERROR(begun.status());
  const FramePlan& plan = begun->plan;
  out->timings.clear();
  out->images.clear();
  out->non_finite = out->negative = 0;
  Image3* colour = results_.colour ? &out->colour : nullptr;
  if (colour != nullptr) {
    MakePicture(work_.picture, colour);
  }
  RunFrame(PipelineOf(plan), frame, future, &history_, &work_, colour, out);
  history_.progress = plan.after;
  has_result_ = true;
  HandOver(plan, out);
  out->bad_guides += begun->odd.bad_guides;
  out->warning = std::move(begun->odd.warning);
  return Status::Ok();
}

/// Stores the requested forms of the output image other than `colour`.
void CpuDenoiser::HandOver(const FramePlan& plan, DenoisedFrame* out) const {
  if (!results_.colour) {
    out->colour = Image3();
  }
  out->shared.reset();
  if (!plan.runs.tonemap) {
    out->display.clear();
    return;
  }
  const StageTimer timer(&out->timings, "tonemap");
  const Image3& picture = history_.picture;
  out->display.resize(static_cast<size_t>(picture.width()) * static_cast<size_t>(picture.height()) *
                      3);
  cpu::Tonemap(picture, plan.tonemap, out->display.data());
}

Status CpuDenoiser::Accumulate(const Frame& given, std::vector<SignalHistory>* future) {
  const Result<const Frame*> host = OnHost(given, &from_device_);
  STILLRAY_RETURN_IF_ERROR(host.status());
  FrameFacts facts = FactsOf(**host);
  facts.is_backward = true;
  const Result<Begun> begun = Begin(**host, facts);
  STILLRAY_RETURN_IF_ERROR(begun.status());
  RunBackward(PipelineOf(begun->plan), **host, &history_, &work_, future);
  history_.progress = begun->plan.after;
  has_result_ = false;
  return Status::Ok();
}

Status CpuDenoiser::SetSettings(const Settings& settings) {
  const bool begins_anew = NeedsNewHistory(settings_, settings);
  settings_ = settings;
  if (begins_anew) {
    Reset();
  }
  return Status::Ok();
}

Status CpuDenoiser::ReadColour(Image3* colour) {
  if (!has_result_) {
    return Status::NotFound("there is no finished frame to read");
  }
  MakePicture(history_.picture, colour);
  CopyImage(history_.picture, colour);
  return Status::Ok();
}

void CpuDenoiser::Reset() {
  history_.progress = SequenceProgress();
  history_.held = HeldGuides();
}

Status CpuDenoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  Result<History> restored = HistoryFromBytes(bytes, settings_);
  if (!restored.ok()) {
    return restored.status();
  }
  history_ = std::move(restored.value());
  history_.progress.fed_back = true;  // possibly; the saved bytes do not contain it
  has_result_ = false;
  return Status::Ok();
}

}  // namespace

std::unique_ptr<DenoiserBackend> MakeCpuDenoiser(const Settings& settings, Backend implementation) {
  return std::make_unique<CpuDenoiser>(
      settings, implementation == Backend::kReference ? kReferenceStages : kCpuStages);
}

}  // namespace stillray
