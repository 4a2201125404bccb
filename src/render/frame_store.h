// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Results into the planes of a frame.
#pragma once

#include <vector>

#include "render/guides.h"
#include "render/integrator.h"
#include "render/tiles.h"

namespace stillray::render {

void StorePixel(Image3* image, int x, int y, vec3 value);
void StoreGuides(const PixelGuides& guides, int x, int y, Frame* frame);

/// Gives an image this size, unless it has it; new ones are zero, others keep what they hold.
template <typename P>
void ResizeImage(P* image, int width, int height) {
  if (image->width() != width || image->height() != height) {
    *image = P(width, height);
  }
}

/// Gives all planes of the frame their size and settings their place; light and guides are left as
/// they are. Frame::samples: `spp` everywhere where it is above 1, left as it is where `cycle` is.
void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, Frame* frame);

/// Frames in which most pixels are missing hold zero almost everywhere. Clearing all of that takes
/// longer than tracing the rest: this clears the pixels that the frame before has set, as long as
/// it is sure that the frame is the one it knows.
class SparseFrameCleaner {
 public:
  /// To be called before PrepareFrame.
  void Begin(const RenderSettings& settings, const Frame& frame);
  /// Sets samples and signals of a region to zero and, with GuideCoverage::kSparse, all the rest.
  /// Different regions may be cleared by different threads at once.
  void Clear(const Tile& region, Frame* frame) const;
  /// To be called when all pixels are stored; `frame` is then known to the next Begin.
  void End(const RenderSettings& settings, const Frame& frame);
  /// Nothing is known of any frame: the last one was not finished.
  void Forget() { known_ = Stamp(); }

 private:
  // Tells a frame from all others, short of a caller that writes to its planes.
  struct Stamp {
    std::vector<const void*> planes;
    int width = 0;
    int height = 0;
    int64_t index = 0;
    GuideCoverage guides = GuideCoverage::kFull;
    bool operator==(const Stamp&) const = default;
  };
  static Stamp MakeStamp(GuideCoverage guides, const Frame& frame);

  GuideCoverage guides_ = GuideCoverage::kFull;
  bool only_traced_ = false;
  Stamp known_;
};

}  // namespace stillray::render
