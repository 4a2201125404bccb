// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// How far the light of the last frame holds in smoke and fog.
#pragma once

#include "stillray/image.h"

namespace stillray::io {

/// Volumes change without motion that files could hold, so that a history lags behind them. The
/// more samples a frame has, the fewer frames it takes until that error is larger than the noise.
/// With a confidence c a history has the weight of at most 1 / (1 - c) frames.
/// \param volume   light of volumes
/// \param light    all light of the frame
/// \param samples  per pixel; empty: one each
/// \return Frame::confidence: where a quarter or more of the light of the 7x7 pixels around is that
///     of volumes, 1 for one sample, 0.675 for two, 0.35 for four and more; 1 without such light
Image1 VolumeConfidence(const Image3& volume, const Image3& light, const Image1& samples);

}  // namespace stillray::io
