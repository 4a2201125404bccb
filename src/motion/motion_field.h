// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Planes of motion, and the tools of their estimation.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

/// The source of a pixel's motion: the camera, matching, its object as a whole, or none.
enum Source : uint8_t { kBase, kMatched, kObject, kUnknown };

/// The estimate of each pixel. Motion leads from pixel to pixel, with jitter.
struct MotionField {
  Image2 motion;
  Image1 confidence;      ///< 0..1
  Plane<uint8_t> source;  ///< Source
};

/// Where guides have less structure (Matched), motion is that of the surroundings.
inline constexpr float kLeastStructure = 0.01f;
/// Matching forth and back must agree by this much.
inline constexpr float kLeastAgreement = 0.5f;
/// Distance of guides, averaged over the surroundings, above which no motion explains them.
inline constexpr float kUnexplained = 0.25f;

inline vec2 At(const Image2& motion, int x, int y) {
  return {motion[0](x, y), motion[1](x, y)};
}

inline void Set(vec2 value, int x, int y, Image2* motion) {
  (*motion)[0](x, y) = value.x;
  (*motion)[1](x, y) = value.y;
}

/// The motion that the camera gives each pixel of a frame with this depth; UnknownMotion where it
/// has none.
Image2 MotionOf(const CameraMotion& camera, const Image1& depth);

/// Every n-th pixel of a plane, and of motion in pixels of the smaller picture.
Image1 Thinned(const Image1& plane, int n);
Image2 Thinned(const Image2& motion, int n);

}  // namespace stillray::motion
