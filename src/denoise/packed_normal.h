// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Unit normals in 32 bits: OctahedralEncode of both coordinates in 16 bits each, x in the lower
/// half. A coordinate c is stored as the integer round(32767 c) + 32768, so that 0 is free to stand
/// for "no normal", as in the zeroed border of planes. The error of the direction is at most 6.5e-5
/// radians (0.0037 degrees). Devices round to equal directions (packSnorm2x16).
#pragma once

#include <cmath>
#include <cstdint>

#include "denoise/octahedral_shared.h"

namespace stillray {

inline constexpr float kNormalSteps = 32767.0f;  ///< of a coordinate from 0 to 1
inline constexpr uint32_t kNormalZero = 32768;   ///< code of the coordinate 0

/// \param n  of unit length, or zero
inline uint32_t PackNormal(vec3 n) {
  if (dot(n, n) == 0) {
    return 0;
  }
  const vec2 e = OctahedralEncode(n);
  const auto code = [](float c) {
    return static_cast<uint32_t>(static_cast<int>(std::nearbyint(c * kNormalSteps)) +
                                 static_cast<int>(kNormalZero));
  };
  return code(e.x) | code(e.y) << 16;
}

inline vec3 UnpackNormal(uint32_t packed) {
  if (packed == 0) {
    return vec3(0.0f);
  }
  const auto coordinate = [](uint32_t code) {
    return (static_cast<float>(code) - static_cast<float>(kNormalZero)) / kNormalSteps;
  };
  return OctahedralDecode({coordinate(packed & 0xffffu), coordinate(packed >> 16)});
}

}  // namespace stillray
