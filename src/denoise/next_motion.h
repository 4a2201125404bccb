// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of frames that are played backward.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Every motion of a frame, of its surfaces and of its virtual images, and the confidence in the
/// light that is found along it.
struct FrameMotion {
  Image2 surface;
  Image2 reflection;
  Image2 refraction;
  Image1 confidence;
};

/// \param surface  of the surfaces of a frame, towards `next`
/// \return it with that of the virtual images, which are derived from the motion of `next`, and
///     with the confidence of `next` at the pixels where the surfaces stand there: it says how far
///     the light of both frames is the same
FrameMotion MotionTowards(const Frame& next, Image2 surface);

/// Exchanges the motions and the confidence of a frame.
void SwapMotion(FrameMotion* motion, Frame* frame);

}  // namespace stillray
