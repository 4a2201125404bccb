// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/motion_field.h"

namespace stillray::motion {

Image2 MotionOf(const CameraMotion& camera, const Image1& depth) {
  const int width = depth.width();
  const int height = depth.height();
  Image2 result(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const vec2 p =
        PicturePoint(width, height, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
    const vec2 motion = camera.MotionOf(p, static_cast<double>(depth(x, y)), width);
    const bool valid = std::isfinite(motion.x + motion.y);
    Set(valid ? motion : UnknownMotion(width, height), x, y, &result);
  });
  return result;
}

Image1 Thinned(const Image1& plane, int n) {
  Image1 thin((plane.width() + n - 1) / n, (plane.height() + n - 1) / n);
  ForEachPixel(thin.width(), thin.height(),
               [&](int x, int y) { thin(x, y) = plane(n * x, n * y); });
  return thin;
}

Image2 Thinned(const Image2& motion, int n) {
  Image2 thin;
  for (int c = 0; c < 2; ++c) {
    thin[c] = Thinned(motion[c], n);
  }
  ForEachPixel(thin.width(), thin.height(),
               [&](int x, int y) { Set(At(thin, x, y) / static_cast<float>(n), x, y, &thin); });
  return thin;
}

}  // namespace stillray::motion
