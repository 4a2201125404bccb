// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "stillray/denoise.hpp"

namespace stillray {

/// Whether the denoiser can use `frame` with these settings: every image that is needed is there
/// and every image that is there has the frame's size. The message names the image and both sizes.
/// \param jittered  this frame or one before it was: then Antialias::kAuto needs motion
Status CheckFrame(const Frame& frame, const Settings& settings, bool jittered);

}  // namespace stillray
