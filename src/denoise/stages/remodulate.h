// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// remodulate: adds a signal, times its albedo, to the picture. Source: SVGF section 3. Pixel by
/// pixel. Reads 24 to 60, writes 12 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"

namespace stillray {

struct RemodulateParameters {
  bool rec601 = false;  ///< luminance weights of the light
  bool add = true;      ///< to what `sum` holds; off: `sum` is overwritten
};

/// AddUnfiltered: sum += light as it is (emission, background; red, green, blue); values that are
/// not finite count as zero, and the number of such pixels is returned. Remodulate: sum += light
/// (luminance, red, blue) * max(albedo, floor), or light itself where there is no albedo.
namespace reference {
void Remodulate(const Image3& light, const AlbedoSum& albedo,
                const RemodulateParameters& parameters, Image3* sum);
int64_t AddUnfiltered(const Image3& light, Image3* sum);
}  // namespace reference
namespace cpu {
void Remodulate(const Image3& light, const AlbedoSum& albedo,
                const RemodulateParameters& parameters, Image3* sum);
int64_t AddUnfiltered(const Image3& light, Image3* sum);
}  // namespace cpu

}  // namespace stillray
