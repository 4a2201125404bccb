// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// remodulate: adds a signal, times its albedo, to the picture. Source: SVGF section 3. Pixel by
/// pixel. Reads 24 to 60, writes 12 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// AddUnfiltered: sum += light as it is (emission, background); values that are not finite count as
/// zero, and the number of such pixels is returned. Remodulate: sum += light * max(albedo,
/// floor), or light as it is where there is no albedo.
namespace reference {
void Remodulate(const Image3& light, const AlbedoSum& albedo, Image3* sum);
int64_t AddUnfiltered(const Image3& light, Image3* sum);
}  // namespace reference
namespace cpu {
void Remodulate(const Image3& light, const AlbedoSum& albedo, Image3* sum);
int64_t AddUnfiltered(const Image3& light, Image3* sum);
}  // namespace cpu

}  // namespace stillray
