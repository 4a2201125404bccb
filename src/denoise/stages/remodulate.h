// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// remodulate: the picture: the sum of all signals, each times its albedo, and unfiltered light.
/// Source: SVGF section 3. Pixel by pixel. The picture is always finite, so that antialias, which
/// weights neighbours, does not spread invalid values: albedo that is not finite counts as 1, and
/// larger values are clamped to kMostPicture. Reads 24 to 48 bytes per pixel and signal, 12 of
/// emission and of background, writes 12.
#pragma once

#include <span>

#include "denoise/planes.h"

namespace stillray {

/// Antialias multiplies the picture by less than 2 and subtracts.
inline constexpr float kMostPicture = 1e37f;

/// A filtered signal (luminance, red, blue), and the albedos that divided it. One of a single
/// channel (AlbedoSum::channel) is added to that channel of the picture alone.
struct SignalLight {
  const LumaImage3* light = nullptr;
  AlbedoSum albedo;
};

struct RemodulateParameters {
  bool luminance_rec601 = false;  ///< luminance weights of the light
  bool add = true;                ///< to the picture; off: overwrite it
};

/// All parts of a picture, which must outlive this.
struct PictureParts {
  std::span<const SignalLight> signals;
  std::span<const Image3* const> unfiltered;
  RemodulateParameters remodulate;
};

/// \param unfiltered  emission, background: values that are not finite count as
///                    zero
/// \return the number of pixels of \p unfiltered that are not finite
namespace reference {
int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& parameters, Image3* picture);
}
namespace cpu {
int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& parameters, Image3* picture);
/// One row, on the calling thread, to be read at once.
/// \param to  red, green and blue, with space for whole vectors
int64_t RemodulateRow(const PictureParts& parts, int width, int y, float* const to[3]);
}  // namespace cpu

}  // namespace stillray
