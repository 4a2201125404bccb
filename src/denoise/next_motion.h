// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The motion of frames that are played backward.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// Every motion of a frame: of its surfaces and of its virtual images.
struct FrameMotion {
  Image2 surface;
  Image2 reflection;
  Image2 refraction;
};

/// \param surface  of the surfaces of a frame, towards `next`
/// \return it with that of the virtual images, which are derived from the motion of `next`
FrameMotion MotionTowards(const Frame& next, Image2 surface);

/// Exchanges the motions of a frame.
void SwapMotion(FrameMotion* motion, Frame* frame);

}  // namespace stillray
