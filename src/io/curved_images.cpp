// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/curved_images.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "io/seen_surfaces.h"

namespace stillray::io {
namespace {

/// Slopes are fitted to 5x5 pixels, spaced by 1/640 of the image width, at least one pixel.
constexpr int kReach = 2;
constexpr int kStepsPerWidth = 640;
/// Minimum number of these pixels on the same surface.
constexpr int kFewest = 12;
/// Neighbours on one surface.
constexpr float kSameCosine = 0.8f;
constexpr float kSameDepth = 0.1f;
/// Maximum fraction of the variance of normals that is not explained by their slopes; bumps exceed
/// it.
constexpr float kMostUnexplained = 0.25f;
/// Range of 2 c d over which the estimate of the reflected distance becomes irrelevant.
constexpr float kUncertain = 2;
constexpr float kCertain = 4;
/// Minimum roughness of surfaces whose radiance is filtered by the guides of the surface.
constexpr float kSmooth = 0.1f;
/// Minimum fraction of the image's pixels.
constexpr float kLeastPart = 0.002f;

/// Whether normals differ between pixels: most surfaces are flat, and need no fit. The minimum
/// relevant curvature is 1 / distance, which turns the normal by at least the angle of a pixel.
bool MayBeCurved(const Guides& g, int x, int y) {
  constexpr float kLeastAngle = 0.5f;  // of the image: wide enough for all but telephoto lenses
  const float least = kLeastAngle / static_cast<float>(g.depth.width());
  const int u = x + (x > 0 ? -1 : 1);
  const int v = y + (y > 0 ? -1 : 1);
  const vec3 normal = VectorAt(g.normal, x, y);
  const vec3 beside = VectorAt(g.normal, u, y) - normal;
  const vec3 above = VectorAt(g.normal, x, v) - normal;
  return IsSurface(g.depth(x, y)) && dot(beside, beside) + dot(above, above) > least * least;
}

/// Sums of a least-squares fit of planes, value = mean + slope (x, y), to positions and normals.
struct SlopeSums {
  float count = 0;
  vec2 offset{0.0f};
  vec3 offsets2{0.0f};  ///< x x, x y, y y
  vec3 normal{0.0f};
  vec3 normal_x{0.0f};
  vec3 normal_y{0.0f};
  float normal2 = 0;
  vec3 point{0.0f};
  vec3 point_x{0.0f};
  vec3 point_y{0.0f};

  void Add(vec2 at, vec3 n, vec3 p) {
    count += 1;
    offset += at;
    offsets2 += vec3(at.x * at.x, at.x * at.y, at.y * at.y);
    normal += n;
    normal_x += at.x * n;
    normal_y += at.y * n;
    normal2 += dot(n, n);
    point += p;
    point_x += at.x * p;
    point_y += at.y * p;
  }
};

struct Slopes {
  vec3 x;
  vec3 y;
};

/// Slopes of values from their sums; sums of offsets are already centred.
Slopes Solve(vec3 offsets2, vec3 by_x, vec3 by_y) {
  const float determinant = offsets2.x * offsets2.z - offsets2.y * offsets2.y;
  return {(offsets2.z * by_x - offsets2.y * by_y) / determinant,
          (offsets2.x * by_y - offsets2.y * by_x) / determinant};
}

/// The largest of |change of normal| / |distance on the surface| over all directions, where the
/// mean curvature is positive; 0 elsewhere, and for invalid values.
float LargestCurvature(const Slopes& n, const Slopes& p) {
  // Extremes of the quotient of two quadratic forms.
  const float a = dot(p.x, p.x);
  const float b = dot(p.x, p.y);
  const float c = dot(p.y, p.y);
  const float d = dot(n.x, n.x);
  const float e = dot(n.x, n.y);
  const float f = dot(n.y, n.y);
  const float determinant = a * c - b * b;
  const float half = 0.5f * (a * f + c * d - 2 * b * e) / determinant;
  const float product = (d * f - e * e) / determinant;
  const float largest2 = half + std::sqrt(std::max(half * half - product, 0.0f));
  const float mean = c * dot(n.x, p.x) - b * (dot(n.x, p.y) + dot(n.y, p.x)) + a * dot(n.y, p.y);
  const float curvature = std::sqrt(largest2);
  return mean > 0 && std::isfinite(curvature) ? curvature : 0.0f;
}

/// Points and normals of surfaces in camera space: right, down, forward.
class Surfaces {
 public:
  Surfaces(const Guides& guides, const View& view)
      : guides_(guides),
        tangent_(static_cast<float>(view.tangent)),
        to_camera_(view.to_camera),
        step_(std::max(guides.depth.width() / kStepsPerWidth, 1)) {}

  vec3 PointAt(int x, int y) const {
    const vec2 p = PixelPoint(guides_.depth, x, y);
    return guides_.depth(x, y) * vec3(tangent_ * p.x, tangent_ * p.y, 1.0f);
  }

  /// Of convex surfaces, else 0.
  float CurvatureAt(int x, int y) const {
    return MayBeCurved(guides_, x, y) ? CurvatureOf(Gather(x, y)) : 0.0f;
  }

 private:
  SlopeSums Gather(int x, int y) const {
    const int width = guides_.depth.width();
    const int height = guides_.depth.height();
    SlopeSums sums;
    const vec3 centre = PointAt(x, y);
    for (int j = -kReach; j <= kReach; ++j) {
      for (int i = -kReach; i <= kReach; ++i) {
        const int u = x + i * step_;
        const int v = y + j * step_;
        const bool inside = u >= 0 && v >= 0 && u < width && v < height;
        if (inside && OnSameSurface(guides_, x, y, u, v, kSameDepth, kSameCosine)) {
          sums.Add(vec2(i, j), VectorAt(guides_.normal, u, v), PointAt(u, v) - centre);
        }
      }
    }
    return sums;
  }

  float CurvatureOf(const SlopeSums& s) const {
    if (s.count < static_cast<float>(kFewest)) {
      return 0;
    }
    const vec2 mean = s.offset / s.count;
    const vec3 offsets2 =
        s.offsets2 - s.count * vec3(mean.x * mean.x, mean.x * mean.y, mean.y * mean.y);
    const vec3 by_x = s.normal_x - mean.x * s.normal;
    const vec3 by_y = s.normal_y - mean.y * s.normal;
    Slopes turn = Solve(offsets2, by_x, by_y);
    const float variation = s.normal2 - dot(s.normal, s.normal) / s.count;
    const float explained = dot(turn.x, by_x) + dot(turn.y, by_y);
    if (!(variation - explained <= kMostUnexplained * variation)) {
      return 0;
    }
    turn = {to_camera_ * turn.x, to_camera_ * turn.y};
    const Slopes way = Solve(offsets2, s.point_x - mean.x * s.point, s.point_y - mean.y * s.point);
    return LargestCurvature(turn, way);
  }

  const Guides& guides_;
  float tangent_;
  mat3 to_camera_;
  int step_;
};

/// Distance of the virtual image behind the surface, along the ray. 0: unknown.
float BehindSurface(float curvature, float distance) {
  const float certain =
      std::clamp((2 * curvature * distance - kUncertain) / (kCertain - kUncertain), 0.0f, 1.0f);
  const float behind = 1 / (2 * curvature + 1 / distance);
  return certain > 0 ? certain * certain * (3 - 2 * certain) * behind : 0.0f;
}

bool ShowsImage(const VirtualGuides& images, int x, int y) {
  return !images.empty() && images.depth(x, y) > 0;
}

/// Pixels with known virtual images belong to smooth surfaces.
Image1 RoughnessOf(const Frame& frame) {
  Image1 roughness(frame.width, frame.height);
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const bool shows = ShowsImage(frame.reflection, x, y) || ShowsImage(frame.refraction, x, y);
    roughness(x, y) = shows ? 0.0f : 1.0f;
  });
  return roughness;
}

/// Whether so many pixels with images matter.
bool IsEnough(int64_t count, int width, int height) {
  return static_cast<float>(count) >=
         kLeastPart * static_cast<float>(width) * static_cast<float>(height);
}

}  // namespace

bool HasCurvedImages(const Guides& guides) {
  const int width = guides.depth.width();
  const int height = guides.depth.height();
  const std::optional<View> view = FitView(guides.depth, guides.normal);
  if (!view || width < 2 || height < 2) {
    return false;
  }
  const Surfaces surfaces(guides, *view);
  std::atomic<int64_t> count = 0;
  ForEachPixel(width, height, [&](int x, int y) {
    const float curvature = surfaces.CurvatureAt(x, y);
    count += curvature > 0 && BehindSurface(curvature, glm::length(surfaces.PointAt(x, y))) > 0;
  });
  return IsEnough(count, width, height);
}

void SetCurvedImages(CameraFits* fits, bool later, Frame* frame, FrameImages* images) {
  Guides& g = frame->guides;
  const int width = frame->width;
  const int height = frame->height;
  const bool known = !g.roughness.empty();
  Image1 roughness = known ? Image1() : RoughnessOf(*frame);
  if (frame->reflection.empty()) {
    frame->reflection.depth = Image1(width, height);
    frame->reflection.motion = Image2(width, height);
  }
  if (images->reflection.empty()) {
    images->reflection = Plane<uint8_t>(width, height);
  }
  Plane<uint8_t> convex(width, height);
  const std::optional<CameraMotion> camera = later ? std::nullopt : fits->Motion();
  const std::optional<View>& view = fits->FieldOfView();
  std::atomic<int64_t> unmoved = 0;  // pixels whose image has no motion
  if (view && width > 1 && height > 1) {
    const Surfaces surfaces(g, *view);
    ForEachPixel(width, height, [&](int x, int y) {
      const bool smooth = known && g.roughness(x, y) < kSmooth;
      if (smooth || ShowsImage(frame->reflection, x, y)) {
        return;
      }
      const float distance = glm::length(surfaces.PointAt(x, y));
      const float behind = BehindSurface(surfaces.CurvatureAt(x, y), distance);
      if (!(behind > 0)) {
        return;
      }
      if (!later && !camera) {
        ++unmoved;
        return;
      }
      frame->reflection.depth(x, y) = g.depth(x, y) * (1 + behind / distance);
      convex(x, y) = images->reflection(x, y) = static_cast<uint8_t>(ImageKind::kConvex);
      if (!known) {
        roughness(x, y) = kCurvedRoughness;
      }
    });
  }
  if (camera) {
    SetImageMotion(convex, images->lens, *camera, fits, g, &frame->reflection);
  }
  if (IsEnough(unmoved, width, height) && images->missing == NoSeenGuides::kNone) {
    images->missing = WhyUnknown(fits);
  }
  if (!known) {
    g.roughness = std::move(roughness);
  }
}

}  // namespace stillray::io
