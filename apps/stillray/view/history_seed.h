// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Converts a finished image to the history of another filter, so that accumulation does not
/// restart if resolution or filter change.
#pragma once

#include "stillray/frame.h"

namespace stillray::view {

/// Makes a frame with the radiance of an image.
/// \param guides   host frame of the same view, with guides in every pixel; the result has its size
/// \param picture  scene-linear image of any size with equal aspect ratio; it is resampled
/// \param samples  samples per pixel, > 0: weight of the image relative to later samples
/// \param keeps_guides  whether later frames have missing guides, which the filter fills from this
///     frame
/// \return all radiance except for emission and background in one signal, for filters with a single
///     signal
Frame SeedFrame(const Frame& guides, const Image3& picture, float samples, bool keeps_guides);

}  // namespace stillray::view
