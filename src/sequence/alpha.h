// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoising of alpha, as a signal with the guides and motion of the frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/frame.h"

namespace stillray {

/// The settings for alpha: one signal without albedo. Coverage has no outliers that need clamping.
/// \param settings  for the radiance
Settings SettingsOfAlpha(Settings settings);

/// The guides of a frame with its alpha as the only signal.
Frame FrameOfAlpha(const Frame& frame, const Image1& alpha);

class AlphaFilter {
 public:
  /// \param settings  for the radiance
  AlphaFilter(const Settings& settings, const Device& device);

  /// Denoises the alpha of a frame with a separate history, which begins with the first frame that
  /// is not opaque; opaque frames before it are unchanged. Values are clamped to 0..1.
  /// \param frame   with guides and samples; its signals are not used
  /// \param future  alpha of later frames (FrameOfAlpha), or empty
  Status Filter(const Frame& frame, const FutureLight& future, Image1* alpha);

  void Reset();  ///< discards the history
  size_t memory_bytes() const;
  DeviceMemory device_memory() const;
  /// Empty before the first frame that is not opaque.
  Result<std::vector<uint8_t>> SaveHistory() const;
  Status RestoreHistory(std::span<const uint8_t> bytes);

 private:
  Status Prepare();

  Settings settings_;
  Device device_;
  std::optional<Denoiser> denoiser_;
  DenoisedFrame denoised_;
};

}  // namespace stillray
