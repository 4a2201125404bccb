// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// How far the light of the last frame holds where it changes without a trace in the motion and
/// guides of other renderers' files. With a confidence c a history has the weight of at most 1 / (1
/// - c) frames; the more samples a frame has, the fewer frames it takes until the error of a
/// history is larger than the noise. Images of confidence are as Frame::confidence.
#pragma once

#include "stillray/image.h"

namespace stillray::io {

/// In smoke and fog, which change without motion that files could hold: where a quarter or more of
/// the light of the 7x7 pixels around is that of volumes, 1 for one sample, 0.675 for two, 0.35 for
/// four and more. 1 without such light.
/// \param volume   light of volumes
/// \param light    all light of the frame
/// \param samples  per pixel; empty: one each
Image1 VolumeConfidence(const Image3& volume, const Image3& light, const Image1& samples);

/// In hair, fur and leaves: pixels whose guides are means over many surfaces never show the same
/// mean again once they move. What their confidence then lacks of 1: where the normals of the 5x5
/// pixels around are shorter than 1 by 0.15 in the mean, 0.15 for each doubling of the samples, and
/// at most 0.65; from 0.05 on in part. 0 elsewhere.
/// \param normal   as stored: means over the samples; zero where there is no surface
/// \param samples  per pixel; empty: one each
Image1 MixedLoss(const Image3& normal, const Image1& samples);

/// Confidence where motion is known: 1 less the loss where a pixel moves by a quarter of a pixel or
/// more, from 0 on in part; 1 where nothing moves.
/// \param loss    as MixedLoss returns it
/// \param motion  of the same size
Image1 ConfidenceInMotion(const Image1& loss, const Image2& motion);

}  // namespace stillray::io
