// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of frames in a sequence that is processed backward.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The motions of a frame's surfaces and virtual images towards another frame, the normals of the
/// surfaces in that frame, and the confidence in its radiance.
struct FrameMotion {
  Image2 surface;
  Image2 reflection;
  Image2 refraction;
  Image3 normal;  ///< for Guides::previous_normal
  Image1 confidence;
};

/// \param frame    its normals are read
/// \param surface  motion of the surfaces of `frame` towards `next`
/// \return \p surface; the motions of the virtual images, derived from those of `next`; the
///     normals, rotated by the change that the previous normals of `next` give (if it has them);
///     and the confidence of `next` at the positions of the surfaces in `next`, which applies to
///     both directions
FrameMotion MotionTowards(const Frame& frame, const Frame& next, Image2 surface);

/// Exchanges the motions, the previous normals and the confidence of a frame.
void SwapMotion(FrameMotion* motion, Frame* frame);

}  // namespace stillray
