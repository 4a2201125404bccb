// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The converged image of a static view, refined progressively by passes.
#pragma once

#include "stillray/image.h"
#include "stillray/render.h"

namespace stillray::view {

class ReferenceAccumulator {
 public:
  void Reset() { spp_ = 0; }
  /// Whether the size of the sum differs.
  bool HasOtherSize(int width, int height) const {
    return spp_ > 0 && (mean_.width() != width || mean_.height() != height);
  }
  /// Adds one sample per pixel, with new random numbers. The renderer's settings are restored on
  /// return.
  /// \return kCancelled if `keep_going` returned false: the sum is then unchanged
  Status AddPass(const RenderMoment& moment, Renderer* renderer, const RenderProgress& keep_going);

  int spp() const { return spp_; }
  /// The mean of all passes; nullptr before the first pass.
  const Image3* picture() const { return spp_ > 0 ? &mean_ : nullptr; }

 private:
  int spp_ = 0;
  Image3 pass_;
  Image3 mean_;
};

}  // namespace stillray::view
