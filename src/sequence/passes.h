// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --passes: the denoised radiance of every layer, so that compositing the layers gives the
/// denoised colour.
///
/// A signal that was filtered as a whole (direct and indirect specular light) is split in
/// proportion to its parts, which additional denoisers filter separately: proportions of single
/// noisy pixels would restore the noise. Only the proportions are used, so the parts sum to the
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
  /// \return kInvalidArgument naming the setting that prevents splitting
  static Status Check(const Settings& settings, const AovLayout& layout);

  /// \param device  of the denoisers of the parts
  PassSplitter(const Settings& settings, const Device& device);

  /// Outputs required from the main denoiser.
  static std::vector<std::string> Outputs();

  /// Splits the radiance of `denoised` into `layers`, as stored in the file.
  /// \param parts   the frame's layers; emptied
  /// \param colour  [in,out] the denoised colour; radiance that no layer can represent is removed:
  ///     the remainder on black surfaces due to the minimum divisor of albedo
  Status Split(const Frame& frame, const AovLayout& layout, std::vector<LightPart> parts,
               const DenoisedFrame& denoised, Image3* colour, std::vector<NewLayer>* layers);

  void Reset();
  Result<std::vector<uint8_t>> SaveHistory() const;
  /// \return kBadData
  Status RestoreHistory(std::span<const uint8_t> bytes);
  size_t memory_bytes() const;
  DeviceMemory device_memory() const;  ///< the part of memory_bytes() on the device

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
