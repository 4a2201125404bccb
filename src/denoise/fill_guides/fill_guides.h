// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fill_guides: computes guides, emission and background for every pixel of sparse frames (below
/// one sample per pixel), which have them only where a path was traced. Source: PSVGF section 5.
/// Departs from it: guides of earlier frames take precedence over interpolated ones.
///
/// A pixel is *known* if the frame gives it a depth or a sample. The steps of a frame:
///
///   FindKnown         lists the known pixels, and tests whether any of them has motion
///   RejectGhosts      where a known pixel contradicts the held guides at its position, rejects
///                     the held guides of their surface around it: the object may have moved away
///   GatherKnown       copies known pixels; the others gather the held guides along the motion
///   downsample, fill  the pyramid (pyramid.h): first level from known pixels, up, and down again
///   FillHoles         the remaining holes: decides between surface and sky, then fills a surface's
///                     guides from known surfaces, and the sky's background from known sky
///
/// | file                      | |
/// |---|---|
/// | fill_guides_shared.h      | formulas, in C++ and GLSL |
/// | held_guides.{h,cpp}       | guides carried over from frame to frame |
/// | fill_guides_reference.cpp | scalar: all steps |
/// | fill_guides.cpp           | vectors: order of the steps, FindKnown, RejectGhosts |
/// | gather_known.cpp          | vectors: GatherKnown and the pyramid's first level |
/// | fill_holes.cpp            | vectors: FillHoles |
/// | pyramid.{h,cpp}, pyramid_reference.cpp, pyramid_rows-inl.h | the pyramid |
///
/// On Vulkan: src/denoise/vulkan/fill_guides, one shader per step.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "denoise/fill_guides/held_guides.h"
#include "denoise/fill_guides/pyramid.h"
#include "stillray/frame.h"

namespace stillray {

struct StageTable;

/// A list of integers for each row of the image.
class RowLists {
 public:
  void Resize(int width, int height);
  /// Storage for `width` values of row y plus a SIMD vector.
  int32_t* Begin(int y) { return values_.data() + static_cast<size_t>(y) * stride_; }
  void SetCount(int y, int count) { counts_[static_cast<size_t>(y)] = count; }
  std::span<const int32_t> Row(int y) const {
    return {values_.data() + static_cast<size_t>(y) * stride_,
            static_cast<size_t>(counts_[static_cast<size_t>(y)])};
  }
  int height() const { return static_cast<int>(counts_.size()); }
  size_t bytes() const { return (values_.size() + counts_.size()) * sizeof(int32_t); }

 private:
  size_t stride_ = 0;
  std::vector<int32_t> values_;
  std::vector<int> counts_;
};

/// Work memory of FillGuides, kept between frames; contains no history.
struct FillGuidesWork {
  /// Kinds of known pixels: all; with a surface; with the sky; known in this frame.
  enum Kind { kAny, kSurface, kSky, kNew, kKindCount };

  HeldGuides before;
  RowLists known_now;  ///< columns of the known pixels of this frame
  RowLists ghosts;  ///< pixels of `before` whose surface has moved away, row by row: y * width + x
  std::array<PyramidMask, kKindCount> mask;
  Pyramid surface;  ///< fraction of each cell that is surface
  Pyramid inverse_depth;
  std::array<Pyramid, HeldPlanes::kMaxPlanes> plane;
  std::array<Pyramid, 2> motion;
  IdPyramid id;

  size_t bytes() const;
};

/// Whether the frame has pixels without guides: depth 0 and no sample.
bool HasIncompleteGuides(const Frame& frame);

/// Fills the guides of a frame, with the functions of `stages`.
/// \param held  [in,out] guides of the last frame, or empty; replaced by those of this frame
void FillGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                FillGuidesWork* work);

namespace reference {
void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work);
}
namespace cpu {
void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work);
}

}  // namespace stillray
