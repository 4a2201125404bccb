// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of frames that are played backward.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Every motion of a frame, of its surfaces and of its virtual images, the normals that surfaces
/// have at its end, and the confidence in the light that is found along it.
struct FrameMotion {
  Image2 surface;
  Image2 reflection;
  Image2 refraction;
  Image3 normal;  ///< for Guides::previous_normal
  Image1 confidence;
};

/// \param frame    its normals
/// \param surface  of its surfaces, towards `next`
/// \return it with that of the virtual images, which are derived from the motion of `next`, with
///     the normals turned as `next` says that they do until then (if it has previous normals), and
///     with the confidence of `next` at the pixels where the surfaces stand there: it says how far
///     the light of both frames is the same
FrameMotion MotionTowards(const Frame& frame, const Frame& next, Image2 surface);

/// Exchanges the motions, the previous normals and the confidence of a frame.
void SwapMotion(FrameMotion* motion, Frame* frame);

}  // namespace stillray
