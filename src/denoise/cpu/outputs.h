// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The requested intermediate images of one frame on the CPU.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "denoise/planes.h"
#include "denoise/signal_groups.h"
#include "denoise/stage_table.h"
#include "denoise/stages/demodulate_shared.h"
#include "stillray/denoise.hpp"

namespace stillray {

class FrameOutputs {
 public:
  /// \param names  full names of outputs, see Denoiser::OutputNames. The arguments must outlive
  ///     this object.
  FrameOutputs(const std::vector<std::string>& names, const StageTable& stages,
               const DemodulateParameters& demodulate, DenoisedFrame* out)
      : names_(names), stages_(stages), demodulate_(demodulate), out_(out) {}

  bool any() const { return !names_.empty(); }
  bool Wants(const std::string& name) const;
  /// Stores the output `kind`.`signal`, if it is requested.
  void KeepPlane(const char* kind, const SignalGroup& signal, const Image1& plane);
  /// \param light  luminance, red, blue; stored as red, green, blue
  void KeepLight(const char* kind, const SignalGroup& signal, const LumaImage3& light);
  void KeepPicture(const char* name, const Image3& picture);
  /// Adds a signal, times its albedo, to the image `name`, which must be requested.
  /// \param scratch  work memory of the image's size
  void AddToPicture(const std::string& name, const LumaImage3& light, const AlbedoSum& albedo,
                    Image3* scratch);
  /// Adds unfiltered radiance to all images of AddToPicture.
  void AddUnfiltered(std::span<const Image3* const> unfiltered);
  /// Appends the images of AddToPicture to the frame's outputs, after all others.
  void Finish();

 private:
  const std::vector<std::string>& names_;
  const StageTable& stages_;
  const DemodulateParameters& demodulate_;
  DenoisedFrame* out_;
  std::vector<std::pair<std::string, Image3>> sums_;
};

}  // namespace stillray
