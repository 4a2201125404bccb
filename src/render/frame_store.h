// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Writes radiance and guides to the planes of a frame.
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
/// Stores the mean radiance of a tile's pixels from `sums` over spp samples.
void StoreLight(const Tile& tile, int spp, const SampleLight* sums, const SampleSquares* squares,
                Frame* frame);

/// Resizes an image unless it already has this size; a resized image is zero, otherwise its content
/// is kept.
template <typename P>
void ResizeImage(P* image, int width, int height) {
  if (image->width() != width || image->height() != height) {
    *image = P(width, height);
  }
}

/// Sets size, index, jitter and signals of a frame whose pixels are in device memory: all host
/// planes are empty.
/// \param separates  transmitted light is stored in separate signals
void DescribeFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                   Frame* frame);

/// Resizes all planes of the frame and sets its other members; radiance and guides are unchanged.
/// Frame::samples is set to `spp` if `spp` > 1, and unchanged if `cycle` > 1.
/// \param separates  transmitted light is stored in separate signals
void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                  Frame* frame);

/// Size of the regions in which sparse frames are rendered: wide, since the pixels of a row share
/// memory pages.
inline constexpr TileSize kSparseRegion = {512, 32};

/// Writes sparse frames: most pixels are missing, and zero in all planes. Clearing whole planes
/// takes longer than tracing the sampled pixels. If the frame is the last one written, only the
/// pixels stored then are cleared.
///
/// Order of calls for a frame: Begin, PrepareFrame, for each region Clear and then Store, End.
class SparseFrameWriter {
 public:
  void Begin(const RenderSettings& settings, const Frame& frame);
  /// Sets samples and signals of a region to zero and, with GuideCoverage::kSparse, all other
  /// planes. Thread-safe for different regions.
  void Clear(const Tile& region, Frame* frame);
  /// Stores a pixel of a cleared region.
  /// \param guides  only stored with GuideCoverage::kSparse
  void Store(const Tile& region, int x, int y, const SampleLight& light, const PixelGuides& guides,
             Frame* frame);
  /// Records the identity of `frame` for the next Begin.
  void End(const Frame& frame);
  /// Discards the recorded identity: the next frame is cleared entirely.
  void Forget() { known_ = Stamp(); }

 private:
  // Identifies a frame by the addresses of its planes, size and index, provided that the caller
  // does not write to the planes.
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
