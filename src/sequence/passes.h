// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --passes: the denoised light of every layer, so that a compositor that combines the layers gets
/// the denoised colour.
///
/// A signal that was filtered as a whole (direct and indirect specular light) is split in
/// proportion to its parts, which other denoisers have filtered separately: shares of single noisy
/// pixels would restore their noise. Only the proportion is used, so the parts add up to the
/// signal.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stillray/aov.h"
#include "stillray/denoise.hpp"

namespace stillray {

class PassSplitter {
 public:
  /// \return kInvalidArgument naming the setting under which light cannot be split
  static Status Check(const Settings& settings, const AovLayout& layout);

  /// \param device  of the denoisers of the parts
  PassSplitter(const Settings& settings, const Device& device);

  /// Outputs that the denoiser of the whole light must return.
  static std::vector<std::string> Outputs();

  /// Splits the light of `denoised` into `layers`, as stored in the file.
  /// \param parts   the frame's light; emptied
  /// \param colour  [in,out] the denoised colour; loses light that no sum of layers can hold: that
  ///     which the minimum divisor of albedo leaves on black surfaces
  Status Split(const Frame& frame, const AovLayout& layout, std::vector<LightPart> parts,
               const DenoisedFrame& denoised, Image3* colour, std::vector<NewLayer>* layers);

  void Reset();
  Result<std::vector<uint8_t>> SaveHistory() const;
  /// \return kBadData
  Status RestoreHistory(std::span<const uint8_t> bytes);
  size_t memory_bytes() const;
  DeviceMemory device_memory() const;  ///< the part of it on the device

 private:
  using Members = std::vector<LightPart*>;
  Status Estimate(const Frame& frame, const Guides& guides, const std::string& group,
                  const Members& members, std::vector<Image3>* estimates);
  Status FilterPair(const Frame& frame, const Guides& guides, const std::string& name,
                    LightPart* first, LightPart* second, std::vector<Image3>* estimates);

  Settings settings_;
  Device device_;
  std::map<std::string, Denoiser> denoisers_;  ///< of two parts each, made on first use
};

}  // namespace stillray
