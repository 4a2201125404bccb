// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Results into the planes of a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "render/guides.h"
#include "render/integrator.h"
#include "render/tiles.h"

namespace stillray::render {

void StorePixel(Image3* image, int x, int y, vec3 value);
/// Guides, emission and background of a tile's pixels, row by row, into the planes.
void StoreGuides(const Tile& tile, const PixelGuides* guides, Frame* frame);
/// The light of a tile's pixels: `sums` of spp samples.
void StoreLight(const Tile& tile, int spp, const SampleLight* sums,
                const std::array<float, kTracedSignalCount>* squares, Frame* frame);

/// Gives an image this size, unless it has it; new ones are zero, others keep what they hold.
template <typename P>
void ResizeImage(P* image, int width, int height) {
  if (image->width() != width || image->height() != height) {
    *image = P(width, height);
  }
}

/// Size, number, jitter and signals of a frame whose pixels lie elsewhere: all planes are empty.
void DescribeFrame(const RenderSettings& settings, const RenderMoment& moment, Frame* frame);

/// Gives all planes of the frame their size and settings their place; light and guides are left as
/// they are. Frame::samples: `spp` everywhere where it is above 1, left as it is where `cycle` is.
void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, Frame* frame);

/// Regions in which sparse frames are rendered: wide, since the pixels of a row share memory pages.
inline constexpr TileSize kSparseRegion = {512, 32};

/// Writes frames in which most pixels are missing, and all planes zero there. Clearing whole planes
/// takes longer than tracing the rest: this clears what it stored into the frame the last time, as
/// long as it is sure that the frame is the one it knows.
///
/// Order of calls for a frame: Begin, PrepareFrame, for each region Clear and then Store, End.
class SparseFrameWriter {
 public:
  void Begin(const RenderSettings& settings, const Frame& frame);
  /// Sets samples and signals of a region to zero and, with GuideCoverage::kSparse, all the rest.
  /// Different regions may be cleared and stored by different threads at once.
  void Clear(const Tile& region, Frame* frame);
  /// Stores a pixel of a region that was cleared.
  /// \param guides  only stored with GuideCoverage::kSparse
  void Store(const Tile& region, int x, int y, const SampleLight& light, const PixelGuides& guides,
             Frame* frame);
  /// `frame` is from now on known to Begin.
  void End(const Frame& frame);
  /// Nothing is known of any frame.
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
  // A pixel that was stored. `kinds`: one bit for each kind of value that is not zero.
  struct StoredPixel {
    uint16_t x;
    uint16_t y;
    uint32_t kinds;
  };
  static Stamp MakeStamp(GuideCoverage guides, const Frame& frame);
  std::vector<StoredPixel>& StoredIn(const Tile& region);

  GuideCoverage guides_ = GuideCoverage::kFull;
  bool is_known_ = false;
  int columns_ = 0;
  std::vector<std::vector<StoredPixel>> stored_;  // by region
  Stamp known_;
};

}  // namespace stillray::render
