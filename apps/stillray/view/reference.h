// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The converged picture of a static view, refined pass by pass.
#pragma once

#include "stillray/image.h"
#include "stillray/render.h"

namespace stillray::view {

class ReferenceAccumulator {
 public:
  void Reset() { spp_ = 0; }
  /// Whether the sum is of another size.
  bool HasOtherSize(int width, int height) const {
    return spp_ > 0 && (mean_.width() != width || mean_.height() != height);
  }
  /// Adds one sample per pixel, with random numbers that no earlier pass used. The renderer's
  /// settings are restored on return.
  /// \return kCancelled if `keep_going` returned false: the sum is then unchanged
  Status AddPass(const RenderMoment& moment, Renderer* renderer, const RenderProgress& keep_going);

  int spp() const { return spp_; }
  /// The mean of all passes; nullptr if there is none.
  const Image3* picture() const { return spp_ > 0 ? &mean_ : nullptr; }

 private:
  int spp_ = 0;
  Image3 pass_;
  Image3 mean_;
};

}  // namespace stillray::view
