// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/alpha.h"

#include <algorithm>
#include <utility>

#include "core/pixels.h"
#include "core/second_moments.h"
#include "io/fill_depth.h"

namespace stillray {

Settings SettingsOfAlpha(Settings settings) {
  settings.signals = SignalGrouping::kSingle;
  settings.demodulate = false;
  settings.firefly = Firefly::kOff;
  return settings;
}

Frame FrameOfAlpha(const Frame& frame, const Image1& alpha) {
  Frame coverage;
  coverage.width = frame.width;
  coverage.height = frame.height;
  coverage.index = frame.index;
  coverage.jitter_x = frame.jitter_x;
  coverage.jitter_y = frame.jitter_y;
  coverage.focal_pixels = frame.focal_pixels;
  coverage.guides = frame.guides;
  coverage.guides.albedo = Image3();
  coverage.guides.specular_albedo = Image3();
  coverage.guides.transmission_albedo = Image3();
  coverage.samples = frame.samples;
  coverage.confidence = frame.confidence;
  Signal& signal = coverage.signals.emplace_back();
  for (int c = 0; c < 3; ++c) {
    signal.radiance[c] = alpha;
  }
  EstimateSecondMoments(&coverage);
  return coverage;
}

AlphaFilter::AlphaFilter(const Settings& settings, const Device& device)
    : settings_(SettingsOfAlpha(settings)), device_(device) {}

Status AlphaFilter::Prepare() {
  if (!denoiser_) {
    Result<Denoiser> made = Denoiser::Create(settings_, device_);
    STILLRAY_RETURN_IF_ERROR(made.status());
    denoiser_.emplace(std::move(made.value()));
  }
  return Status::Ok();
}

Status AlphaFilter::Filter(const Frame& frame, const FutureLight& future, Image1* alpha) {
  if (!denoiser_ && !io::IsPartlyTransparent(*alpha)) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(Prepare());
  STILLRAY_RETURN_IF_ERROR(denoiser_->Denoise(FrameOfAlpha(frame, *alpha), future, &denoised_));
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    (*alpha)(x, y) = std::clamp(denoised_.colour[0](x, y), 0.0f, 1.0f);
  });
  return Status::Ok();
}

void AlphaFilter::Reset() {
  if (denoiser_) {
    denoiser_->Reset();
  }
}

size_t AlphaFilter::memory_bytes() const {
  return denoiser_ ? denoiser_->memory_bytes() : 0;
}

DeviceMemory AlphaFilter::device_memory() const {
  return denoiser_ ? denoiser_->device_memory() : DeviceMemory();
}

Result<std::vector<uint8_t>> AlphaFilter::SaveHistory() const {
  return denoiser_ ? denoiser_->SaveHistory() : std::vector<uint8_t>();
}

Status AlphaFilter::RestoreHistory(std::span<const uint8_t> bytes) {
  denoiser_.reset();
  if (bytes.empty()) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(Prepare());
  return denoiser_->RestoreHistory(bytes);
}

}  // namespace stillray
