// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// antialias: temporal antialiasing of the finished picture.
/// Source: Karis 2014 ("High Quality Temporal Supersampling"), SVGF section 3 (post-processing),
/// PSVGF section 4.5: the previous output, fetched along the motion of the nearest surface that
/// stands in front of the pixel's own (so that edges move with what they belong to) with a
/// Catmull-Rom filter, is clamped to the 3x3 neighbourhood of the present and blended, whatever the
/// disocclusion test said. Departs from them: while the light of a pixel is young the picture
/// before counts no more than the light before does (the clamp lets a wrong picture pass where the
/// noise of young light is large); runs on scene-linear light, before the tone curve, so that
/// linear files are antialiased too, and blends without Karis' weights 1 / (1 + luminance): those
/// suppress flicker of undenoised highlights, but darkened textures of high contrast by 5 %, where
/// the plain blend converges to the box-filtered picture. State: the previous output. Border: 1
/// pixel; reads 4x4 taps along the motion. Reads 36 and 16 x 12, writes 12 bytes per pixel.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/antialias_shared.h"

namespace stillray {

struct AntialiasInput {
  const Image3& previous;  ///< the last output
  const Image2& motion;
  const GuidePlanes& guides;
  /// Samples that the light of each pixel has in all, and that this frame brought; nullptr for
  /// length: weight `taa_alpha` everywhere; for samples: one everywhere.
  const Image1* length = nullptr;
  const Image1* samples = nullptr;
  Image3* copy = nullptr;  ///< the finished picture once more, of the same size; nullptr: no
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
