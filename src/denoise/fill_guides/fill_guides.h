// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides, emission and background of frames that know them only where a path was traced.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "denoise/fill_guides/pyramid.h"
#include "stillray/frame.h"

namespace stillray {

struct StageTable;

/// What the filter reads of what each pixel sees, completed, and where it is more than a guess.
/// Images that frames do not give are empty; emission and background also as long as all that is
/// known of them is black.
struct HeldGuides {
  Image1 known;   ///< 1: from a path through this pixel, in this frame or one before; 0: filled
  Guides guides;  ///< without roughness
  Image3 emission;
  Image3 background;

  // What the vector version knows of this; false is always right.
  bool motionless = false;  ///< motion is zero everywhere
  bool raised = false;      ///< the first level of the work's pyramids is made of this

  bool empty() const { return known.empty(); }
  size_t bytes() const;
};

/// Calls visit(plane) for every plane of floats in a fixed order, empty ones too.
template <typename Held, typename Visit>
void VisitHeldPlanes(Held& held, const Visit& visit) {
  visit(held.known);
  visit(held.guides.depth);
  for (auto* image : {&held.guides.normal, &held.guides.albedo, &held.guides.specular_albedo,
                      &held.guides.transmission_albedo, &held.emission, &held.background}) {
    for (auto& plane : image->channel) {
      visit(plane);
    }
  }
  for (auto& plane : held.guides.motion.channel) {
    visit(plane);
  }
}

/// A few values for each row of the picture.
class RowLists {
 public:
  void Resize(int width, int height);
  /// Where Append may write `width` values and a vector more.
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

/// Room for CompleteGuides, kept between frames. Nothing in it is history.
struct SparseGuidesWork {
  /// Kinds of known pixels: all, those of a surface, those of the sky, those of this frame.
  enum Kind { kAny, kSurface, kSky, kNew, kKindCount };
  static constexpr size_t kMostPlanes = 18;

  HeldGuides before;
  RowLists known_now;  ///< columns of the pixels that this frame knows
  RowLists ghosts;     ///< row by row, pixels of `before` whose surface has left: y * width + x
  std::array<FillMask, kKindCount> mask;
  FillLevels surface;  ///< part of each cell that is surface
  FillLevels inverse_depth;
  std::array<FillLevels, kMostPlanes> plane;
  std::array<FillLevels, 2> motion;
  FillIdLevels id;

  size_t bytes() const;
};

/// Whether there are pixels of which nothing is known: depth 0 and no sample.
bool HasUnknownGuides(const Frame& frame);

/// Completes the guides of a frame with unknown ones. What this frame knows is taken; then what is
/// held from earlier frames, moved along the motion; the rest is filled (pyramid.h):
/// first whether a hole shows a surface, then its guides from surfaces alone, its background from
/// the sky alone. Where something new was found to stand in front of, or instead of, what is held,
/// the held guides of that surface around it are given up: they may be the ghost of an object that
/// has left.
/// \param held  of the frame before, or empty; on return, of this frame
void CompleteGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                    SparseGuidesWork* work);

namespace reference {
void CompleteGuides(const Frame& frame, HeldGuides* held, SparseGuidesWork* work);
}
namespace cpu {
void CompleteGuides(const Frame& frame, HeldGuides* held, SparseGuidesWork* work);
}

}  // namespace stillray
