// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// remodulate: the output image: the sum of all signals, each times its albedo, and of the
/// unfiltered radiance. Source: SVGF section 3. Pixel by pixel. The image is always finite, so that
/// antialias, which weights neighbours, does not spread invalid values: albedo that is not finite
/// counts as 1, and the sum is clamped to kMostPicture. Reads 24 to 48 bytes per pixel and signal,
/// 12 of emission and of background, writes 12.
#pragma once

#include <span>

#include "denoise/planes.h"

namespace stillray {

/// Largest value of the output image. Antialias, which scales values by less than 2 and subtracts
/// them, then does not overflow.
inline constexpr float kMostPicture = 1e37f;

/// A filtered signal (luminance, red, blue), and the albedos that it is multiplied by. A signal of
/// a single channel (AlbedoSum::channel) is added to that channel of the image only.
struct SignalLight {
  const LumaImage3* light = nullptr;
  AlbedoSum albedo;
};

struct RemodulateParameters {
  bool luminance_rec601 = false;  ///< luminance weights of the signals
  bool add = true;                ///< to the image; off: overwrite it
};

/// All terms of the output image. The spans must outlive this.
struct PictureParts {
  std::span<const SignalLight> signals;
  std::span<const Image3* const> unfiltered;
  RemodulateParameters remodulate;
};

/// \param unfiltered  emission, background: values that are not finite count as zero
/// \return the number of pixels of \p unfiltered that are not finite
namespace reference {
int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& parameters, Image3* picture);
}
namespace cpu {
int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& parameters, Image3* picture);
/// Computes one row on the calling thread.
/// \param to  [out] red, green and blue, with space for whole vectors
int64_t RemodulateRow(const PictureParts& parts, int width, int y, float* const to[3]);
}  // namespace cpu

}  // namespace stillray
