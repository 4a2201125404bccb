// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Converts a finished picture to the history of another filter, so that the picture on the screen
/// does not restart when resolution or filter change.
#pragma once

#include "stillray/frame.h"

namespace stillray::view {

/// A frame whose light is that of a picture.
/// \param guides   frame of the same view, with guides in every pixel, on the host; the result has
///     its size
/// \param picture  scene-linear, of any size with the same aspect ratio; it is resampled
/// \param samples  per pixel, > 0: weight of the picture relative to later samples
/// \param keeps_guides  whether later frames have unknown guides, which the filter then fills from
///     these
/// \return all light but emission and background in one signal, as filters with a single signal
///     need it
Frame SeedFrame(const Frame& guides, const Image3& picture, float samples, bool keeps_guides);

}  // namespace stillray::view
