// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <string>

#include "denoise/plan.h"
#include "stillray/denoise.hpp"

namespace stillray {

/// Whether the frame has a size that can be denoised.
Status CheckSize(const Frame& frame);

/// Checks that the denoiser can use `frame` with these settings: all required images are given, all
/// given images have the frame's size, and some depths are valid. The message names the image and
/// both sizes.
Status CheckFrame(const Frame& frame, const Settings& settings, MotionUse use);

/// Checks that a frame gives the focal length where the settings need it.
/// \param focal_pixels  Frame::focal_pixels
Status CheckFocalLength(int64_t frame, float focal_pixels, const Settings& settings);

struct OddValues {
  std::string warning;     ///< one line; empty: none
  int64_t bad_guides = 0;  ///< pixels with invalid guides, which are passed through
};

/// Finds suspicious values in a frame that CheckFrame accepts: a given image without information.
/// In most frames only a few rows are read.
OddValues FindOddValues(const Frame& frame, MotionUse use);

}  // namespace stillray
