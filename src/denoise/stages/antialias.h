// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// antialias: temporal antialiasing of the finished image. Source: Karis 2014 ("High Quality
/// Temporal Supersampling"), SVGF section 3 (post-processing), PSVGF section 4.5: the previous
/// output, fetched with a Catmull-Rom filter along the motion of the nearest surface of the 3x3
/// neighbourhood in front of the pixel's own (so that edges move with the nearer surface), is
/// clamped to the 3x3 neighbourhood of the current image and blended, regardless of the
/// disocclusion test. Departs from them: `resampling` may be a cubic spline (spline_coefficients.h)
/// or ResampleSubcell, since Catmull-Rom's kernel blurs at every fractional offset, and an image is
/// resampled ten times before it has faded; beside a silhouette the motion of the surface in front
/// is extrapolated (`extrapolate_motion`); while the history of a pixel is short, the weight of the
/// previous output is no larger than that of the history (if the noise is large, the clamp lets a
/// wrong colour pass), and a confidence below 1 reduces it; runs on scene-linear radiance, before
/// the tone curve, so that linear files are antialiased too, and blends linear radiance, which
/// converges to the box-filtered image. `tone_scale` blends under a tone curve instead, as SVGF
/// does, which smooths edges of bright light, but darkens textures of high contrast (by up to 5 %).
/// With `ratio` the previous output is multiplied by the change of the radiance (follow_light.h).
///
/// With `texture` the demodulated previous output (divided by its albedo) is clamped, not the
/// output itself. Rays of one frame miss lines that are thinner than a pixel, so that the clamp
/// would erase them, and on textures of high contrast the clamp lets wrong radiance pass. The
/// albedo is therefore antialiased as well, with the same taps and weights: both images are then
/// means over the same points, and the quotient of previous output and previous albedo is a mean of
/// demodulated radiance, weighted by albedo. The quotient is clamped to its range in the 3x3
/// neighbourhood and multiplied by the previous albedo. The previous albedo is clamped only to the
/// range of the albedo in some 12x12 pixels, so that changing textures are followed; to the range
/// in 3x3 pixels where it may belong to another surface or to another reflected image, in this
/// frame or the last one. The result stays within the range of the image in 3x3 pixels, widened
/// where the albedo is outside its own range there.
///
/// State: the previous output and, with `texture`, its albedo. Border: 1 pixel, with `texture` 2;
/// with `extrapolate_motion` 3; reads 4x4 taps along the motion. Reads 36 and 16 x 12, writes 12
/// bytes per pixel; with `texture` 54 and 32 x 12, 24.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/sum_albedo.h"

namespace stillray {

/// The albedos that separate texture from demodulated radiance.
struct AntialiasTexture {
  const SummedAlbedo& albedo;      ///< of this frame
  const Image3* before = nullptr;  ///< the antialiased albedo of the last frame; nullptr: unknown,
                                   ///< the image itself is clamped
  const Image3* spline = nullptr;  ///< spline coefficients of `before`, see AntialiasInput::spline
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
  /// The output of follow_light, per block; nullptr: 1 everywhere.
  const Image1* ratio = nullptr;
  /// History length of each pixel, and number of samples of this frame. `length` nullptr: weight
  /// `taa_alpha` everywhere; `samples` nullptr: one sample everywhere.
  const Image1* length = nullptr;
  const Image1* samples = nullptr;
  /// Frame::confidence; nullptr: 1 everywhere. Read only if `length` is given.
  const Image1* confidence = nullptr;
  /// Used only if `length` is given; nullptr: the image itself is clamped.
  const AntialiasTexture* texture = nullptr;
  Image3* copy = nullptr;  ///< a copy of the finished image, of equal size; nullptr: none
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
