// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/reflections.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include <fmt/format.h>

#include "core/cameras.h"
#include "core/pixels.h"
#include "core/reflections.h"

namespace stillray {
namespace {

/// Tolerances of neighbours on one surface: relative difference of depth, cosine of normals.
constexpr float kSameDepth = 0.05f;
constexpr float kSameCosine = 0.9f;
/// Maximum relative difference of depth within one virtual image.
constexpr float kSameImage = 0.03f;

static_assert(sizeof(HitCamera) == 80, "push constants of the shader");

/// The map of zero motion.
const glm::dmat4x3& Still() {
  static const glm::dmat4x3 still(1.0);
  return still;
}

/// The map (homogeneous), scaled so that w is positive and near 1 in front of the camera. If the
/// camera turned by a right angle, w cannot be normalised.
glm::dmat4x3 Scaled(const glm::dmat4x3& map) {
  constexpr double kLeast = 1e-3;
  double most = 0;
  for (int column = 0; column < 4; ++column) {
    const glm::dvec3 size = glm::abs(map[column]);
    most = std::max({most, size.x, size.y, size.z});
  }
  const double w = std::abs(map[2].z);
  const double unit = w > kLeast * most ? w : most;
  return map * (1 / unit);
}

Status NoPerspective(const char* which) {
  return Status::InvalidArgument(
      fmt::format("the camera of {} has no inverse or no perspective, expected the matrices of a "
                  "perspective camera",
                  which));
}

bool IsPerspective(const CameraMatrices& camera, int width, int height) {
  return HasInverse(camera) && FromPicture(camera, width, height).has_value();
}

Status CheckSize(const char* name, int width, int height, const Image1& depth) {
  if (width == depth.width() && height == depth.height()) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("image '{}' is {}x{}, expected {}x{} as 'depth'", name,
                                             width, height, depth.width(), depth.height()));
}

Status CheckSizes(const Guides& g, const Image1& hits) {
  if (g.depth.empty()) {
    return Status::InvalidArgument("image 'depth' is not given");
  }
  STILLRAY_RETURN_IF_ERROR(CheckSize("hit_distance", hits.width(), hits.height(), g.depth));
  if (!g.normal.empty()) {
    STILLRAY_RETURN_IF_ERROR(CheckSize("normal", g.normal.width(), g.normal.height(), g.depth));
  }
  if (!g.id.empty()) {
    STILLRAY_RETURN_IF_ERROR(CheckSize("id", g.id.width(), g.id.height(), g.depth));
  }
  return g.roughness.empty()
             ? Status::Ok()
             : CheckSize("roughness", g.roughness.width(), g.roughness.height(), g.depth);
}

bool IsSameSurface(const Guides& g, int x, int y, int u, int v) {
  const float depth = g.depth(x, y);
  return std::abs(g.depth(u, v) - depth) < kSameDepth * depth &&
         (g.id.empty() || g.id(x, y) == g.id(u, v)) &&
         (g.normal.empty() ||
          dot(VectorAt(g.normal, x, y), VectorAt(g.normal, u, v)) > kSameCosine);
}

bool IsSameImage(float a, float b) {
  return a == b || std::abs(a - b) < kSameImage * a;
}

/// Whether at least half of the neighbours on the same surface have the pixel's virtual image.
bool IsSupported(const Guides& g, const Image1& images, int x, int y) {
  int neighbours = 0;
  int same = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, images.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, images.width() - 1); ++u) {
      if ((u != x || v != y) && IsSameSurface(g, x, y, u, v)) {
        ++neighbours;
        same += IsSameImage(images(x, y), images(u, v)) ? 1 : 0;
      }
    }
  }
  return same > 0 && 2 * same >= neighbours;
}

}  // namespace

Result<HitCamera> MakeHitCamera(const CameraMatrices& now, const CameraMatrices& before, int width,
                                int height) {
  if (!IsPerspective(now, width, height)) {
    return NoPerspective("this frame");
  }
  if (!IsPerspective(before, width, height)) {
    return NoPerspective("the previous frame");
  }
  const std::optional<CameraMotion> motion = MotionOfCamera(now, before, width, height);
  if (!motion) {
    return NoPerspective("this frame");
  }
  const glm::dmat4 ray = *FromPicture(now, width, height);
  const glm::dmat4x3 move = Scaled(motion->map) - Still();
  const auto in_ray = [&](int column, int row) { return static_cast<float>(ray[column][row]); };
  const auto in_move = [&](int column, int row) { return static_cast<float>(move[column][row]); };
  HitCamera camera;
  camera.ray_x_x = in_ray(0, 0);
  camera.ray_x_y = in_ray(1, 0);
  camera.ray_x_1 = in_ray(2, 0);
  camera.ray_y_x = in_ray(0, 1);
  camera.ray_y_y = in_ray(1, 1);
  camera.ray_y_1 = in_ray(2, 1);
  camera.move_x_x = in_move(0, 0);
  camera.move_x_y = in_move(1, 0);
  camera.move_x_1 = in_move(2, 0);
  camera.move_x_z = in_move(3, 0);
  camera.move_y_x = in_move(0, 1);
  camera.move_y_y = in_move(1, 1);
  camera.move_y_1 = in_move(2, 1);
  camera.move_y_z = in_move(3, 1);
  camera.move_w_x = in_move(0, 2);
  camera.move_w_y = in_move(1, 2);
  camera.move_w_1 = in_move(2, 2);
  camera.move_w_z = in_move(3, 2);
  camera.width = width;
  camera.height = height;
  return camera;
}

Result<VirtualGuides> ReflectionsFromHits(const Guides& guides, const Image1& hit_distance,
                                          const CameraMatrices& now, const CameraMatrices& before) {
  STILLRAY_RETURN_IF_ERROR(CheckSizes(guides, hit_distance));
  const int width = guides.depth.width();
  const int height = guides.depth.height();
  const Result<HitCamera> camera = MakeHitCamera(now, before, width, height);
  STILLRAY_RETURN_IF_ERROR(camera.status());
  Image1 all(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const float cosine = CosineOfRay(*camera, PlaceOfPixel(*camera, x, y));
    all(x, y) = DepthOfHit(guides.depth(x, y), hit_distance(x, y), cosine);
  });
  VirtualGuides images;
  images.depth = Image1(width, height);
  images.motion = Image2(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const float depth = all(x, y);
    if (!(depth > 0) || (guides.roughness.empty() && !IsSupported(guides, all, x, y))) {
      return;
    }
    const vec2 motion = MotionOfHit(*camera, PlaceOfPixel(*camera, x, y), depth);
    images.depth(x, y) = depth;
    images.motion[0](x, y) = motion.x;
    images.motion[1](x, y) = motion.y;
  });
  return images;
}

}  // namespace stillray
