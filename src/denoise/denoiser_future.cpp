// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Light of the future: gathered while a sequence is played backward, merged as it is played
// forward.
#include <fmt/format.h>

#include "denoise/denoiser_impl.h"
#include "denoise/device_denoiser.h"
#include "denoise/frame_check.h"
#include "denoise/stage_timer.h"

namespace stillray {

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

/// The history of a signal, with the light of its future where that is known.
SignalHistory* Denoiser::Impl::MergeFuture(size_t signal, const FutureLight& future) {
  SignalHistory* history = &state.signals[signal];
  if (future.empty()) {
    return history;
  }
  merged.resize(groups.size());
  SignalHistory& both = merged[signal];
  if (both.length.width() != state.width || both.length.height() != state.height) {
    both = SignalHistory(state.width, state.height, false, false, border);
  }
  const StageTimer timer(&out->timings, "merge_future");
  stages->merge_future(*history, future.impl_->signals[signal], &both);
  return &both;
}

/// Whether light of the future was accumulated from frames like this one.
Status Denoiser::CheckFuture(const Frame& frame, const Settings& settings,
                             const FutureLight& future) {
  if (future.empty()) {
    return Status::Ok();
  }
  const std::vector<SignalHistory>& signals = future.impl_->signals;
  const size_t expected = GroupsOf(settings.signals, HasTransmission(frame)).size();
  const Image1& length = signals.front().length;
  if (signals.size() != expected || length.width() != frame.width ||
      length.height() != frame.height) {
    return Status::InvalidArgument(fmt::format(
        "frame {}: the light of its future has {} signals of {}x{}, expected {} of {}x{}",
        frame.index, signals.size(), length.width(), length.height(), expected, frame.width,
        frame.height));
  }
  return Status::Ok();
}

Status Denoiser::AccumulateOnDevice(const Frame& frame, FutureLight* future) {
  auto gathered = std::make_unique<FutureLight::Impl>();
  const Status status = device_->Accumulate(frame, &gathered->signals);
  if (FallsBack(status)) {
    return Accumulate(frame, future);
  }
  if (status.ok()) {
    future->impl_ = std::move(gathered);
  }
  return status;
}

Status Denoiser::Accumulate(const Frame& given, FutureLight* future) {
  STILLRAY_RETURN_IF_ERROR(CheckSize(given));
  Impl& d = *impl_;
  const Frame& whole = d.Complete(given);
  if (device_ != nullptr) {
    return AccumulateOnDevice(whole, future);
  }
  const Result<const Frame*> frame = OnHost(whole, &d.from_device);
  STILLRAY_RETURN_IF_ERROR(frame.status());
  DenoisedFrame counts;
  STILLRAY_RETURN_IF_ERROR(d.Begin(**frame, &counts));
  future->impl_ = std::make_unique<FutureLight::Impl>();
  d.GatherSignals([&](size_t i) {
    future->impl_->signals.push_back(d.ShortenedHistory(i));
    d.RunAccumulate(i);
  });
  d.state.has_history = d.settings.temporal;
  d.state.has_picture = false;
  d.has_result = false;
  d.frame = nullptr;
  d.out = nullptr;
  return Status::Ok();
}

}  // namespace stillray
