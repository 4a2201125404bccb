// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Rigid motion of moving objects.
#pragma once

#include "motion/guide_pyramid.h"
#include "motion/match_guides.h"
#include "motion/motion_field.h"
#include "stillray/frame.h"

namespace stillray::motion {

/// Two frames after matching. All planes have the size of the frames.
struct MatchedFrames {
  const Guides& guides;  ///< of the newer frame, with depth; ids are optional
  const GuidePyramid& now;
  const GuidePyramid& before;
  const Image2& base;  ///< motion of static surfaces
  const Image1& base_distances;
  const Matched& matched;
  const Image1& agreement;
  const Image1& matched_distances;
};

/// Objects (by their ids) with a moving part are likely to move rigidly, including plain parts: a
/// rigid object moves like a static scene under another camera. The rigid motion replaces the
/// motion of the object's pixels if it fits the guides far better than the camera's and hardly
/// worse than matching. Where only a small part of an object, or without ids of the neighbourhood,
/// moves, pixels are treated as static. Results do not depend on the number of threads.
void MoveObjects(const MatchedFrames& frames, MotionField* field);

}  // namespace stillray::motion
