// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Planes of motion, and helpers for their estimation.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "stillray/image.h"
#include "stillray/vec.h"

namespace stillray::motion {

/// The source of a pixel's motion: the camera, matching, its object's rigid motion, or none.
enum Source : uint8_t { kBase, kMatched, kObject, kUnknown };

/// The estimate of each pixel. Motion is from pixel to pixel, including jitter.
struct MotionField {
  Image2 motion;
  Image1 confidence;      ///< 0..1
  Plane<uint8_t> source;  ///< Source
};

/// Minimum structure of guides (Matched) for independent motion; below, motion is that of the
/// neighbourhood.
inline constexpr float kLeastStructure = 0.01f;
/// Minimum forward-backward consistency.
inline constexpr float kLeastAgreement = 0.5f;
/// Distance of guides, averaged over the neighbourhood, above which a motion does not match.
inline constexpr float kUnexplained = 0.25f;

inline vec2 At(const Image2& motion, int x, int y) {
  return {motion[0](x, y), motion[1](x, y)};
}

inline void Set(vec2 value, int x, int y, Image2* motion) {
  (*motion)[0](x, y) = value.x;
  (*motion)[1](x, y) = value.y;
}

/// The camera's motion of each pixel of a frame with this depth; UnknownMotion where it is
/// undefined.
Image2 MotionOf(const CameraMotion& camera, const Image1& depth);

/// Every n-th pixel of a plane; motion is in pixels of the smaller plane.
Image1 Thinned(const Image1& plane, int n);
Image2 Thinned(const Image2& motion, int n);

}  // namespace stillray::motion
