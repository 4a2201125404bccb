// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The shared colour formulas for vectors.
#pragma once

#include "core/colour_shared.h"
#include "stillray/vec.h"

namespace stillray {

inline float Luminance709(vec3 c) {
  return Luminance709(c.x, c.y, c.z);
}

inline vec3 Demodulate(vec3 radiance, vec3 albedo) {
  return {Demodulate(radiance.x, albedo.x), Demodulate(radiance.y, albedo.y),
          Demodulate(radiance.z, albedo.z)};
}

}  // namespace stillray
