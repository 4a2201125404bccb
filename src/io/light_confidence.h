// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Confidence in the history (Frame::confidence) where radiance changes although motion and guides
/// of other renderers' files do not show it. With a confidence c the history counts for at most 1 /
/// (1 - c) frames; the more samples a frame has, the fewer frames it takes until the error of a
/// history is larger than the noise. Confidence images are as Frame::confidence.
#pragma once

#include "stillray/image.h"

namespace stillray::io {

/// In smoke and fog, whose changes are not in the motion vectors: where volumes make up a quarter
/// or more of the radiance of the 7x7 neighbourhood, 1 for one sample, 0.675 for two, 0.35 for four
/// and more. 1 elsewhere.
/// \param volume   light of volumes
/// \param light    all light of the frame
/// \param samples  per pixel; empty: one each
Image1 VolumeConfidence(const Image3& volume, const Image3& light, const Image1& samples);

/// In hair, fur and leaves: pixels whose guides are means over many surfaces never show the same
/// mean again once they move. Returns 1 minus their confidence: where normals in the 5x5
/// neighbourhood are shorter than 1 by 0.15 on average, 0.15 per doubling of the samples, at most
/// 0.65; partially from 0.05 on. 0 elsewhere.
/// \param normal   as stored: means over the samples; zero where there is no surface
/// \param samples  per pixel; empty: one each
Image1 MixedLoss(const Image3& normal, const Image1& samples);

/// Confidence for known motion: 1 - loss where the motion is a quarter of a pixel or more,
/// interpolated below; 1 where the motion is zero.
/// \param loss    as MixedLoss returns it
/// \param motion  of the same size
Image1 ConfidenceInMotion(const Image1& loss, const Image2& motion);

}  // namespace stillray::io
