// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// fill_guides: guides, emission and background for every pixel of frames that have them only where
/// a path was traced (below one sample per pixel).
/// Source: PSVGF section 5. Departs from it: guides of earlier frames come before filled ones.
///
/// A pixel is *known* if the frame gives it a depth or a sample. The steps of a frame:
///
///   FindKnown         lists the known pixels; is any of them moving?
///   RejectGhosts      a known pixel that contradicts the held guides at its place: the held guides
///                     of that surface around it may be those of an object that has left
///   GatherKnown       copies known pixels; the others gather the held guides along the motion
///   downsample, fill  the pyramid (pyramid.h): first level from known pixels, up, and down again
///   FillHoles         the remaining holes: first whether they show a surface or the sky, then
///                     the surface's guides from known surfaces, its background from known sky
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

/// A list of integers for each row of the picture.
class RowLists {
 public:
  void Resize(int width, int height);
  /// Storage for `width` values of row y and a SIMD vector more.
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

/// Memory of FillGuides, kept between frames. None of it is history.
struct FillGuidesWork {
  /// Kinds of known pixels: all, those of a surface, those of the sky, those of this frame.
  enum Kind { kAny, kSurface, kSky, kNew, kKindCount };

  HeldGuides before;
  RowLists known_now;  ///< columns of the pixels that this frame knows
  RowLists ghosts;     ///< row by row, pixels of `before` whose surface has left: y * width + x
  std::array<PyramidMask, kKindCount> mask;
  Pyramid surface;  ///< part of each cell that is surface
  Pyramid inverse_depth;
  std::array<Pyramid, HeldPlanes::kMaxPlanes> plane;
  std::array<Pyramid, 2> motion;
  IdPyramid id;

  size_t bytes() const;
};

/// Whether the frame has pixels without guides: depth 0 and no sample.
bool HasIncompleteGuides(const Frame& frame);

/// Fills the guides of a frame; see above.
/// \param held  in: of the frame before, or empty; out: of this frame
void FillGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                FillGuidesWork* work);

namespace reference {
void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work);
}
namespace cpu {
void FillGuides(const Frame& frame, HeldGuides* held, FillGuidesWork* work);
}

}  // namespace stillray
