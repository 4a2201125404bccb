// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Guides, emission and background of frames that know them only where a path was traced.
#pragma once

#include <vector>

#include "denoise/stages/fill_guides.h"
#include "stillray/frame.h"

namespace stillray {

struct StageTable;

/// Everything that a frame says of what each pixel sees, completed, and where it is more than a
/// guess. Images that frames do not give are empty.
struct HeldGuides {
  Image1 known;    ///< 1: from a path through this pixel, in this frame or one before; 0: filled
  Image1 surface;  ///< 1: a surface, 0: the ray left the scene
  Image1 inverse_depth;
  Guides guides;
  Image3 emission;
  Image3 background;

  bool empty() const { return known.empty(); }
  size_t bytes() const;
};

/// Calls visit(plane) for every plane of floats in a fixed order, empty ones too.
template <typename Held, typename Visit>
void VisitHeldPlanes(Held& held, const Visit& visit) {
  visit(held.known);
  visit(held.surface);
  visit(held.inverse_depth);
  visit(held.guides.depth);
  visit(held.guides.roughness);
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

/// Room for CompleteGuides, kept between frames. Nothing in it is history.
struct SparseGuidesWork {
  HeldGuides before;
  Image1 known_now;
  Image1 blocked;
  FillPyramid pyramid;

  size_t bytes() const;
};

/// Whether there are pixels of which nothing is known: depth 0 and no sample.
bool HasUnknownGuides(const Frame& frame);

/// Completes the guides of a frame with unknown ones. What this frame knows is taken; then what is
/// held from earlier frames, moved along the motion; the rest is filled (stages/fill_guides.h).
/// Where something new was found to stand in front of, or instead of, what is held, the held
/// guides of that surface around it are given up: they may be the ghost of an object that has left.
/// \param held  of the frame before, or empty; on return, of this frame
void CompleteGuides(const Frame& frame, const StageTable& stages, HeldGuides* held,
                    SparseGuidesWork* work);

}  // namespace stillray
