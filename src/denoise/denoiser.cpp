// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Common to all backends: checks, fallback to the CPU, names of outputs. The stages of a frame are
// in cpu/pipeline.cpp and vulkan/frame_pipeline.cpp (with frame_filter.cpp).
#include "stillray/denoise.hpp"

#include <utility>

#include <fmt/format.h>

#include "core/guides.h"
#include "core/second_moments.h"
#include "denoise/backend.h"
#include "denoise/cpu/cpu_denoiser.h"
#include "denoise/cpu/history_bytes.h"
#include "denoise/frame_check.h"
#include "denoise/layered_denoiser.h"
#include "denoise/output_names.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/signal_groups.h"
#include "denoise/stages/tonemap.h"

namespace stillray {

struct FutureLight::Impl {
  std::vector<SignalHistory> signals;
};

struct Denoiser::Impl {
  Settings settings;
  std::unique_ptr<DenoiserBackend> backend;
  bool is_cpu = true;
  bool may_fall_back = false;  ///< to the CPU, until a frame is finished
  bool is_automatic = false;   ///< the device was chosen by "auto"
  std::string remark;
  Results results;
  std::vector<std::string> outputs;
  Frame completed;  ///< copy of a frame that lacked inputs, with substitutes

  const Frame& Complete(const Frame& given);
  Status CheckFuture(const Frame& frame, std::span<const SignalHistory> future) const;
  void FallBack(std::string why);
  template <typename Call>
  Status RunOrFallBack(const Call& call);
};

/// Returns the frame itself if it has all inputs, else a copy with substitutes for missing guides
/// and second moments. Without limit_history, as in the published filters, noise is measured over
/// time alone, and second moments are not estimated.
const Frame& Denoiser::Impl::Complete(const Frame& given) {
  if (given.on_device != nullptr) {
    return given;
  }
  const bool lacks_moments = settings.limit_history && LacksSecondMoments(given);
  if (!lacks_moments && HasGuides(given, settings.demodulate)) {
    return given;
  }
  completed = given;
  FillMissingGuides(settings.demodulate, &completed);
  // Invalid frames are reported by the backend.
  if (lacks_moments && CheckFrame(completed, settings, MotionUse()).ok()) {
    EstimateSecondMoments(&completed);
  }
  return completed;
}

/// Checks that the light of future frames has the signals and the size of this frame.
Status Denoiser::Impl::CheckFuture(const Frame& frame,
                                   std::span<const SignalHistory> future) const {
  if (future.empty()) {
    return Status::Ok();
  }
  const size_t expected = GroupsOf(settings.signals, HasTransmission(frame)).size();
  const Image1& length = future.front().length;
  if (future.size() != expected || length.width() != frame.width ||
      length.height() != frame.height) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: the light of its future has {} signals of {}x{}, expected {} of {}x{}",
        frame.index, future.size(), length.width(), length.height(), expected, frame.width,
        frame.height));
  }
  return Status::Ok();
}

void Denoiser::Impl::FallBack(std::string why) {
  remark = std::move(why);
  backend = MakeCpuDenoiser(settings);
  backend->SetResults(results);
  backend->SetOutputs(outputs);
  is_cpu = true;
  may_fall_back = false;
}

/// Runs the call, and again on the CPU if a device chosen by "auto" fails before the first frame is
/// finished. An invalid argument is not a failure of the device.
template <typename Call>
Status Denoiser::Impl::RunOrFallBack(const Call& call) {
  const Status status = call();
  if (may_fall_back && !status.ok() && status.code() != StatusCode::kInvalidArgument) {
    FallBack(status.message());
    return call();
  }
  may_fall_back = may_fall_back && !status.ok();
  return status;
}

Denoiser::Denoiser(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Denoiser::Denoiser(Denoiser&&) noexcept = default;
Denoiser& Denoiser::operator=(Denoiser&&) noexcept = default;
Denoiser::~Denoiser() = default;

Result<Denoiser> Denoiser::Create(const Settings& settings, Backend backend) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  auto impl = std::make_unique<Impl>();
  impl->settings = settings;
  impl->backend = MakeCpuDenoiser(settings, backend);
  return Denoiser(std::move(impl));
}

Result<Denoiser> Denoiser::Create(const Settings& settings, const Device& device,
                                  DevicePrecision precision) {
  Result<Denoiser> made = Create(settings);
  if (!made.ok() || device.is_cpu()) {
    return made;
  }
  const Status has_all_stages = CheckDeviceSettings(settings);
  if (!has_all_stages.ok() && device.impl_->may_fall_back) {
    made->impl_->remark = has_all_stages.message();
    return made;
  }
  STILLRAY_RETURN_IF_ERROR(has_all_stages);
  Result<std::unique_ptr<DenoiserBackend>> on_device =
      device.impl_->backend->CreateDenoiser(settings, precision);
  STILLRAY_RETURN_IF_ERROR(on_device.status());
  Impl& d = *made->impl_;
  d.backend =
      MakeLayeredDenoiser(settings, precision, device.impl_->backend, std::move(on_device.value()));
  d.is_cpu = false;
  d.may_fall_back = device.impl_->may_fall_back;
  d.is_automatic = device.impl_->may_fall_back;
  return made;
}

Status Denoiser::Denoise(const Frame& frame, DenoisedFrame* out) {
  return Denoise(frame, FutureLight(), out);
}

Status Denoiser::Denoise(const Frame& given, const FutureLight& future, DenoisedFrame* out) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(given));
  const Frame& frame = impl_->Complete(given);
  const std::span<const SignalHistory> known =
      future.empty() ? std::span<const SignalHistory>() : future.impl_->signals;
  STILLRAY_RETURN_IF_ERROR(impl_->CheckFuture(frame, known));
  return impl_->RunOrFallBack([&] { return impl_->backend->Denoise(frame, known, out); });
}

Status Denoiser::Accumulate(const Frame& given, FutureLight* future) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(given));
  const Frame& frame = impl_->Complete(given);
  auto gathered = std::make_unique<FutureLight::Impl>();
  STILLRAY_RETURN_IF_ERROR(
      impl_->RunOrFallBack([&] { return impl_->backend->Accumulate(frame, &gathered->signals); }));
  future->impl_ = std::move(gathered);
  return Status::Ok();
}

Status Denoiser::SetSettings(const Settings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateSettings(settings));
  const Status has_all_stages = impl_->is_cpu ? Status::Ok() : CheckDeviceSettings(settings);
  if (!has_all_stages.ok() && impl_->is_automatic) {
    impl_->FallBack(has_all_stages.message());
  } else {
    STILLRAY_RETURN_IF_ERROR(has_all_stages);
  }
  STILLRAY_RETURN_IF_ERROR(impl_->backend->SetSettings(settings));
  impl_->settings = settings;
  return Status::Ok();
}

const Settings& Denoiser::settings() const {
  return impl_->settings;
}

const std::string& Denoiser::remark() const {
  return impl_->remark;
}

void Denoiser::SetResults(const Results& wanted) {
  impl_->results = wanted;
  impl_->backend->SetResults(wanted);
}

Status Denoiser::ReadColour(Image3* colour) {
  return impl_->backend->ReadColour(colour);
}

std::vector<std::string> Denoiser::OutputNames(const Settings& settings) {
  std::vector<std::string> names = {"temporal"};
  for (int level = 1; level <= settings.steps.count; ++level) {
    names.push_back(fmt::format("atrous{}", level));
  }
  names.insert(names.end(), {"aliased", "disocclusion"});
  std::vector<std::string> kinds = {
      "noisy",   "accumulated", "filtered", "variance", "smoothed_variance", "filtered_variance",
      "history", "alpha",       "limit",    "ratio",    "moment_mean",       "moment_variance"};
  for (int level = 1; level <= settings.steps.count; ++level) {
    kinds.push_back(fmt::format("weights{}", level));
  }
  for (const std::string& kind : kinds) {
    for (const SignalGroup& group : GroupsOf(settings.signals, true)) {
      names.push_back(fmt::format("{}.{}", kind, group.name));
    }
  }
  return names;
}

Status Denoiser::SetOutputs(const std::vector<std::string>& names) {
  const std::vector<std::string> known = OutputNames(impl_->settings);
  std::vector<std::string> wanted;
  for (const std::string& name : names) {
    if (!AddOutputs(known, name, &wanted)) {
      return Status::InvalidArgument(
          fmt::format("unknown output '{}'; outputs are: {}", name, fmt::join(known, ", ")));
    }
  }
  impl_->backend->SetOutputs(wanted);
  impl_->outputs = std::move(wanted);
  return Status::Ok();
}

void Denoiser::Reset() {
  impl_->backend->Reset();
}

size_t Denoiser::memory_bytes() const {
  return impl_->backend->memory_bytes();
}

DeviceMemory Denoiser::device_memory() const {
  return impl_->backend->device_memory();
}

Result<std::vector<uint8_t>> Denoiser::SaveHistory() const {
  return impl_->backend->SaveHistory();
}

/// With device "auto", the history of a sequence that was denoised on the CPU is restored there.
Status Denoiser::RestoreHistory(std::span<const uint8_t> bytes) {
  if (!impl_->is_cpu && impl_->may_fall_back && IsHistoryOfCpu(bytes)) {
    impl_->FallBack("the saved history was made on the CPU");
  }
  const Status status = impl_->backend->RestoreHistory(bytes);
  // From here on the CPU cannot replace the device: it cannot read the device's history.
  impl_->may_fall_back = impl_->may_fall_back && !status.ok();
  return status;
}

FutureLight::FutureLight() = default;
FutureLight::FutureLight(FutureLight&&) noexcept = default;
FutureLight& FutureLight::operator=(FutureLight&&) noexcept = default;
FutureLight::~FutureLight() = default;

bool FutureLight::empty() const {
  return impl_ == nullptr;
}

size_t FutureLight::bytes() const {
  size_t sum = 0;
  if (impl_ != nullptr) {
    for (const SignalHistory& signal : impl_->signals) {
      sum += signal.bytes();
    }
  }
  return sum;
}

std::vector<uint8_t> ToDisplay(const Image3& colour, float exposure, Tonemap curve, float dither,
                               int64_t frame) {
  std::vector<uint8_t> bytes(static_cast<size_t>(colour.width()) *
                             static_cast<size_t>(colour.height()) * 3);
  cpu::Tonemap(colour, TonemapOf(exposure, curve, dither, frame), bytes.data());
  return bytes;
}

}  // namespace stillray
