// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Objects that move by themselves, as wholes.
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
  const Image2& base;  ///< motion of still surfaces
  const Image1& base_distances;
  const Matched& matched;
  const Image1& agreement;
  const Image1& matched_distances;
};

/// Objects (by their ids) of which a part moves by itself are likely to move as wholes, plain parts
/// too: each point of a rigid object moves like one of a still scene before another camera. Such a
/// motion replaces that of the object's pixels if it explains the guides far better than the
/// camera's and hardly worse than matching. Where little of an object moves by itself, or without
/// ids little of the surroundings, pixels stand still. The same bits for any number of threads.
void MoveObjects(const MatchedFrames& frames, MotionField* field);

}  // namespace stillray::motion
