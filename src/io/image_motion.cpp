// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/image_motion.h"

#include <cmath>
#include <optional>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/reflected_motion.h"

namespace stillray::io {
namespace {

bool Contains(const Plane<uint8_t>& kinds, ImageKind kind) {
  return AnyPixel(kinds, [kind](uint8_t found) { return found == static_cast<uint8_t>(kind); });
}

}  // namespace

NoSeenGuides WhyUnknown(CameraFits* fits) {
  if (fits->Motion()) {
    return NoSeenGuides::kNone;
  }
  return fits->SeesOnePlane() ? NoSeenGuides::kOnePlane : NoSeenGuides::kMotion;
}

void SetImageMotion(const Plane<uint8_t>& kinds, const Lens& lens, const CameraMotion& camera,
                    CameraFits* fits, const Guides& guides, VirtualGuides* images) {
  const int width = kinds.width();
  const int height = kinds.height();
  const vec2 unknown = UnknownMotion(width, height);
  std::optional<ReflectedMotion> reflected;
  if (Contains(kinds, ImageKind::kReflected) && fits->FieldOfView()) {
    reflected.emplace(guides, lens, camera, fits->FieldOfView()->to_camera);
  }
  const auto motion_of = [&](ImageKind kind, int x, int y) {
    const float depth = images->depth(x, y);
    const vec2 own = {guides.motion[0](x, y), guides.motion[1](x, y)};
    switch (kind) {
      case ImageKind::kPlanar:
        return camera.MotionOf(PixelPoint(guides.depth, x, y), static_cast<double>(depth), width);
      case ImageKind::kReflected:
        return reflected ? reflected->At(x, y, depth).value_or(own) : own;
      case ImageKind::kConvex:
        return ImageMotion(camera, guides, x, y, depth);
      case ImageKind::kSurface:
      case ImageKind::kNone:
        break;
    }
    return own;
  };
  ForEachPixel(width, height, [&](int x, int y) {
    const auto kind = static_cast<ImageKind>(kinds(x, y));
    if (kind != ImageKind::kNone) {
      const vec2 m = motion_of(kind, x, y);
      const bool valid = std::isfinite(m.x + m.y);
      images->motion[0](x, y) = valid ? m.x : unknown.x;
      images->motion[1](x, y) = valid ? m.y : unknown.y;
    }
  });
}

void ForgetImageMotion(VirtualGuides* images) {
  const int width = images->depth.width();
  const int height = images->depth.height();
  const vec2 unknown = UnknownMotion(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    if (images->depth(x, y) > 0) {
      images->motion[0](x, y) = unknown.x;
      images->motion[1](x, y) = unknown.y;
    }
  });
}

}  // namespace stillray::io
