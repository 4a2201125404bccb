// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// antialias: temporal antialiasing of the finished picture. Source: Karis 2014 ("High Quality
/// Temporal Supersampling"), SVGF section 3 (post-processing), PSVGF section 4.5: the previous
/// output, fetched with a Catmull-Rom filter along the motion of the nearest surface of the 3x3
/// neighbourhood in front of the pixel's own (so that edges move with the nearer surface), is
/// clamped to the 3x3 neighbourhood of the current picture and blended, regardless of the
/// disocclusion test. Departs from them: with `spline` it is the cubic spline through the pixels
/// that is fetched (spline_coefficients.h), since Catmull-Rom's kernel blurs fine texture at every
/// fraction of a pixel, and a picture is fetched ten times before it has faded; while the history
/// of a pixel's light is short the previous picture counts no more than the previous light does
/// (the clamp lets a wrong picture pass if the noise of the light is large), and under a confidence
/// in the last frame's light it counts less; runs on scene-linear light, before the tone curve, so
/// that linear files are antialiased too, and blends linear light, which converges to the
/// box-filtered picture. `tone_scale` blends under a tone curve instead, as SVGF does, which
/// smooths edges of bright light, but darkens textures of high contrast (by up to 5 %). With
/// `ratio` the previous picture is multiplied by the change of the light (follow_light.h).
///
/// With `texture` the light of the previous picture is clamped, not the picture itself. Rays of one
/// frame miss lines that are thinner than a pixel, so that the clamp would erase them, and where a
/// texture has contrast it lets a wrong light pass. So the albedo is antialiased as well, with the
/// same taps and weights: both pictures are then means over the same points, and the quotient of
/// the previous picture and the previous albedo is a mean of light, with the albedos as weights. It
/// is clamped to that of the 3x3 neighbourhood and multiplied by the previous albedo, which is only
/// clamped to the range of the albedo in some 12x12 pixels, so that textures that change are
/// followed; to that in 3x3 pixels where it may be that of another surface or of another image in a
/// mirror, in this frame or the last one. The result stays within the range of the picture in 3x3
/// pixels, widened where the albedo is outside its own there.
///
/// State: the previous output, and with `texture` its albedo. Border: 1 pixel, with `texture` 2;
/// reads 4x4 taps along the motion. Reads 36 and 16 x 12, writes 12 bytes per pixel; with `texture`
/// 54 and 32 x 12, 24.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/sum_albedo.h"

namespace stillray {

/// The albedos that separate the texture of pictures from their light.
struct AntialiasTexture {
  const SummedAlbedo& albedo;      ///< of this frame
  const Image3* before = nullptr;  ///< the antialiased albedo of the last frame; nullptr: unknown,
                                   ///< the picture is clamped
  const Image3* spline = nullptr;  ///< as AntialiasInput::spline
  Image3* out = nullptr;           ///< result: the antialiased albedo of this frame
  /// Inverse depth of the last frame; read with `before`.
  const Image1* depth_before = nullptr;
};

struct AntialiasInput {
  const Image3& previous;  ///< the last output
  const Image2& motion;
  const GuidePlanes& guides;
  /// The spline coefficients of `previous`; nullptr: Catmull-Rom
  const Image3* spline = nullptr;
  /// Of follow_light, per block; nullptr: the light is the same.
  const Image1* ratio = nullptr;
  /// Number of samples in the light of each pixel, and of those of this frame; nullptr for length:
  /// weight `taa_alpha` everywhere; for samples: one everywhere.
  const Image1* length = nullptr;
  const Image1* samples = nullptr;
  /// Frame::confidence; nullptr: 1 everywhere. Read with `length` alone.
  const Image1* confidence = nullptr;
  /// Used with `length` alone; nullptr: the picture is clamped.
  const AntialiasTexture* texture = nullptr;
  Image3* copy = nullptr;  ///< a copy of the finished picture, of the same size; nullptr: none
};

namespace reference {
void Antialias(const Image3& colour, const AntialiasInput& in,
               const AntialiasParameters& parameters, Image3* out);
}  // namespace reference
namespace cpu {
void Antialias(const Image3& colour, const AntialiasInput& in,
               const AntialiasParameters& parameters, Image3* out);
}  // namespace cpu

}  // namespace stillray
