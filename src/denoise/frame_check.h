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

/// Whether the denoiser can use `frame` with these settings: every image that is needed is there,
/// every image that is there has the frame's size, and the depths are not all unusable. The message
/// names the image and both sizes.
Status CheckFrame(const Frame& frame, const Settings& settings, MotionUse use);

struct OddValues {
  std::string warning;     ///< one line; empty: nothing is odd
  int64_t bad_guides = 0;  ///< pixels that pass through for that reason
};

/// What is odd about the values of a frame that CheckFrame accepts: an image that is given and says
/// nothing. Of usual frames a few rows are read.
OddValues FindOddValues(const Frame& frame, MotionUse use);

}  // namespace stillray
