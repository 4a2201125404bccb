// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Alpha that is denoised as light is: with the same guides, along the same motion.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/frame.h"

namespace stillray {

/// The settings of alpha: one signal without albedo. Coverage has no outliers that a clamp would
/// have to remove. \param settings  of the picture
Settings SettingsOfAlpha(Settings settings);

/// The guides of a frame with its alpha as light.
Frame FrameOfAlpha(const Frame& frame, const Image1& alpha);

class AlphaFilter {
 public:
  /// \param settings  of the picture
  AlphaFilter(const Settings& settings, const Device& device);

  /// Denoises the alpha of a frame with a history of its own, which begins with the first frame
  /// that is not opaque; frames before it are unchanged. Values are clamped to 0..1.
  /// \param frame   with guides and samples; its light is not used
  /// \param future  alpha of later frames (FrameOfAlpha), or empty
  Status Filter(const Frame& frame, const FutureLight& future, Image1* alpha);

  void Reset();  ///< forgets the history
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
