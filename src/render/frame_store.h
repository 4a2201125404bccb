// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Stores results in the planes of a frame.
#pragma once

#include <cstdint>
#include <vector>

#include "render/guides.h"
#include "render/integrator.h"
#include "render/tiles.h"

namespace stillray::render {

void StorePixel(Image3* image, int x, int y, vec3 value);
/// Stores guides, emission and background of a tile's pixels, row by row.
void StoreGuides(const Tile& tile, const PixelGuides* guides, Frame* frame);
/// Stores the light of a tile's pixels: `sums` of spp samples.
void StoreLight(const Tile& tile, int spp, const SampleLight* sums, const SampleSquares* squares,
                Frame* frame);

/// Resizes an image unless it already has this size; new ones are zero, others keep their content.
template <typename P>
void ResizeImage(P* image, int width, int height) {
  if (image->width() != width || image->height() != height) {
    *image = P(width, height);
  }
}

/// Sets size, number, jitter and signals of a frame whose pixels are on a device: all planes are
/// empty.
/// \param separates  transmitted light has signals of its own
void DescribeFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                   Frame* frame);

/// Resizes all planes of the frame and sets its other members; light and guides are unchanged.
/// Frame::samples: `spp` everywhere if it is above 1, unchanged if `cycle` is.
/// \param separates  transmitted light has signals of its own
void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                  Frame* frame);

/// Regions in which sparse frames are rendered: wide, since the pixels of a row share memory pages.
inline constexpr TileSize kSparseRegion = {512, 32};

/// Writes frames in which most pixels are missing, and all planes zero there. Clearing whole planes
/// takes longer than tracing the other pixels, so this clears only the pixels that it stored into
/// the frame the last time, if it recognises the frame.
///
/// Order of calls for a frame: Begin, PrepareFrame, for each region Clear and then Store, End.
class SparseFrameWriter {
 public:
  void Begin(const RenderSettings& settings, const Frame& frame);
  /// Sets samples and signals of a region to zero and, with GuideCoverage::kSparse, all other
  /// planes. Different regions may be cleared and stored by different threads at once.
  void Clear(const Tile& region, Frame* frame);
  /// Stores a pixel of a cleared region.
  /// \param guides  only stored with GuideCoverage::kSparse
  void Store(const Tile& region, int x, int y, const SampleLight& light, const PixelGuides& guides,
             Frame* frame);
  /// Remembers `frame` for the next Begin.
  void End(const Frame& frame);
  /// Forgets the remembered frame.
  void Forget() { known_ = Stamp(); }

 private:
  // Identifies a frame by its planes, provided that the caller does not write to them.
  struct Stamp {
    std::vector<const void*> planes;
    int width = 0;
    int height = 0;
    int64_t index = 0;
    GuideCoverage guides = GuideCoverage::kFull;
    bool operator==(const Stamp&) const = default;
  };
  // A stored pixel. `kinds`: one bit for each kind of value that is not zero.
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
