// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A finished picture as the history of a filter that has none: what is on the screen does not
/// start anew when resolution or filter change.
#pragma once

#include "stillray/frame.h"

namespace stillray::view {

/// A frame whose light is that of a picture.
/// \param guides   frame of the same view, with guides in every pixel, on the host; its size is
///                 that of the result
/// \param picture  scene-linear, of any size with the same aspect ratio; it is resampled
/// \param samples  per pixel, > 0: how much the picture counts against the samples to come
/// \param keeps_guides  whether frames to come lack guides, which the filter then takes from here
/// \return all light but emission and background in one signal, which is right for filters that
///         have one for all light
Frame SeedFrame(const Frame& guides, const Image3& picture, float samples, bool keeps_guides);

}  // namespace stillray::view
