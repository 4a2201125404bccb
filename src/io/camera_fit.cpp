// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/camera_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/guides.h"
#include "core/least_squares.h"
#include "core/pixels.h"

namespace stillray::io {
namespace {

/// At most this many pixels are fitted.
constexpr int64_t kNormalSamples = 1 << 16;
constexpr int64_t kSamples = 1 << 14;
constexpr int64_t kSlopeSamples = 1 << 12;
/// Minimum fraction of inliers of a fit.
constexpr double kLeastPart = 1.0 / 3;

/// Whether the vector may be a normal, or a mean of normals, in any precision. False for NaN.
bool IsNormal(vec3 v) {
  constexpr float kLongest = 1.1f;
  return glm::length(v) < kLongest;
}

/// Calls visit(x, y) for pixels of a regular grid, at most `most`.
template <typename Visit>
void ForEachSample(int width, int height, int64_t most, const Visit& visit) {
  int step = 1;
  while (int64_t{width / step} * (height / step) > most) {
    ++step;
  }
  for (int y = step / 2; y < height; y += step) {
    for (int x = step / 2; x < width; x += step) {
      visit(x, y);
    }
  }
}

/// Reorders the values. 0 if there are none.
double Median(std::vector<double>* values) {
  if (values->empty()) {
    return 0;
  }
  const auto middle = values->begin() + static_cast<ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// The map of normals.

struct NormalPair {
  vec3 normal;
  vec3 mapped;
};

/// The linear map that fits most pairs.
mat3 MapOf(const std::vector<NormalPair>& pairs) {
  constexpr int kIterations = 12;
  /// Residual below which all samples have the same weight: the rounding of halves, and bump maps
  /// that differ between the closures of one surface.
  constexpr double kResidualFloor = 0.01;
  glm::dmat3 map(0.0);
  for (int i = 0; i < kIterations; ++i) {
    glm::dmat3 products(0.0);
    glm::dmat3 squares(0.0);
    double total = 0;
    for (const NormalPair& pair : pairs) {
      const glm::dvec3 n(pair.normal);
      const glm::dvec3 d(pair.mapped);
      const double residual = i == 0 ? 0 : glm::length(d - map * n);
      const double weight = 1 / ((kResidualFloor + residual) * (kResidualFloor + residual));
      products += glm::outerProduct(weight * d, n);
      squares += glm::outerProduct(weight * n, n);
      total += weight;
    }
    constexpr double kRidge = 1e-6;
    map = products * glm::inverse(squares + glm::dmat3(kRidge * std::max(total, 1e-30)));
  }
  return mat3(map);
}

// The lens.

struct Distance {
  vec2 p;
  double z;
  double distance;
};

constexpr double kLensTolerance = 0.005;  ///< relative error of z that counts as fitting

double RelativeError(const Lens& lens, const Distance& d) {
  return lens.DepthOf(d.distance, d.p) / d.z - 1;
}

/// An initial value that is insensitive to mirrors: alternating medians of both unknowns, for rays
/// around the image centre.
Lens StartOfLens(const std::vector<Distance>& distances) {
  constexpr int kIterations = 40;
  constexpr double kOutside = 0.1;  ///< squared distance from the centre at which k is well defined
  Lens lens;
  lens.k = 0.4;
  std::vector<double> values;
  for (int i = 0; i < kIterations; ++i) {
    values.clear();
    for (const Distance& d : distances) {
      values.push_back(d.z - d.distance * lens.Cosine(d.p));
    }
    lens.start = Median(&values);
    values.clear();
    for (const Distance& d : distances) {
      const double p2 = static_cast<double>(dot(d.p, d.p));
      if (p2 > kOutside && d.z > lens.start) {
        const double secant = d.distance / (d.z - lens.start);
        values.push_back((secant * secant - 1) / p2);
      }
    }
    lens.k = std::max(Median(&values), 0.0);
  }
  return lens;
}

/// Gauss-Newton steps on the inliers.
void RefineLens(const std::vector<Distance>& distances, Lens* lens) {
  constexpr int kIterations = 12;
  double scale = 0.02;
  for (int i = 0; i < kIterations; ++i) {
    NormalEquations<4> equations;
    for (const Distance& d : distances) {
      const double error = RelativeError(*lens, d);
      const glm::dvec2 offset = glm::dvec2(d.p) - lens->centre;
      const double cosine = lens->Cosine(d.p);
      const double by_k = -0.5 * d.distance * cosine * cosine * cosine / d.z;
      const double weight = 1 / std::pow(1 + error * error / (scale * scale), 2);
      equations.Add({by_k * glm::dot(offset, offset), 1 / d.z, -2 * by_k * lens->k * offset.x,
                     -2 * by_k * lens->k * offset.y},
                    -error, weight);
    }
    const std::array<double, 4> step = equations.Solve(1e-12);
    lens->k = std::max(lens->k + step[0], 0.0);
    lens->start += step[1];
    lens->centre += glm::dvec2(step[2], step[3]);
    scale = std::max(0.5 * scale, 0.002);
  }
}

// The motion of the camera.

struct MovedPoint {
  vec2 now;
  vec2 before;
  double nearness;  ///< depth_unit / z
};

glm::dvec3 Moved(const glm::dmat4x3& map, vec2 p, double nearness) {
  return map * glm::dvec4(glm::dvec2(p), 1.0, nearness);
}

double ErrorOf(const glm::dmat4x3& map, const MovedPoint& point) {
  const glm::dvec3 moved = Moved(map, point.now, point.nearness);
  return glm::length(glm::dvec2(moved) / moved.z - glm::dvec2(point.before));
}

/// One Gauss-Newton step. The constant entry of w stays 1.
glm::dmat4x3 ImproveMap(const std::vector<MovedPoint>& points, double scale,
                        const glm::dmat4x3& map) {
  NormalEquations<11> equations;
  for (const MovedPoint& point : points) {
    const glm::dvec4 a(glm::dvec2(point.now), 1.0, point.nearness);
    const glm::dvec3 moved = map * a;
    const double error = ErrorOf(map, point);
    const double weight =
        1 / (std::pow(1 + error * error / (scale * scale), 2) * moved.z * moved.z);
    if (!std::isfinite(weight)) {
      continue;
    }
    for (int c = 0; c < 2; ++c) {
      const double place = moved[c] / moved.z;
      std::array<double, 11> row{};
      for (int i = 0; i < 4; ++i) {
        row[static_cast<size_t>(4 * c + i)] = a[i];
      }
      row[8] = -place * a.x;
      row[9] = -place * a.y;
      row[10] = -place * a.w;
      equations.Add(row, (static_cast<double>(point.before[c]) - place) * moved.z, weight);
    }
  }
  const std::array<double, 11> step = equations.Solve(1e-13);
  glm::dmat4x3 better = map;
  for (int i = 0; i < 4; ++i) {
    better[i].x += step[static_cast<size_t>(i)];
    better[i].y += step[static_cast<size_t>(4 + i)];
  }
  better[0].z += step[8];
  better[1].z += step[9];
  better[3].z += step[10];
  return better;
}

/// The motion of the surfaces at the pixels of a grid. Depths are not yet divided by the unit.
std::vector<MovedPoint> MovedPoints(const Image1& depth, const Image2& motion) {
  const int width = depth.width();
  const int height = depth.height();
  std::vector<MovedPoint> points;
  ForEachSample(width, height, kSamples, [&](int x, int y) {
    const vec2 m = {motion[0](x, y), motion[1](x, y)};
    if (IsSurface(depth(x, y)) && std::isfinite(m.x + m.y)) {
      const float px = static_cast<float>(x) + 0.5f;
      const float py = static_cast<float>(y) + 0.5f;
      points.push_back({PicturePoint(width, height, px, py),
                        PicturePoint(width, height, px + m.x, py + m.y),
                        1 / static_cast<double>(depth(x, y))});
    }
  });
  return points;
}

/// Error in pixels from which on points are outliers.
constexpr double kOutlier = 0.3;

/// The median error of inliers: the rounding of halves, which is largest for large motion.
double NoiseOf(const glm::dmat4x3& map, const std::vector<MovedPoint>& points, double pixel) {
  std::vector<double> errors;
  for (const MovedPoint& point : points) {
    const double error = ErrorOf(map, point);
    if (error < kOutlier * pixel) {
      errors.push_back(error);
    }
  }
  return Median(&errors);
}

/// Sum of squared errors over some of the points, each limited to the error of an outlier.
double CostOf(const glm::dmat4x3& map, const std::vector<MovedPoint>& points, double outlier) {
  constexpr size_t kMost = 512;
  const size_t step = points.size() / kMost + 1;
  double cost = 0;
  for (size_t i = 0; i < points.size(); i += step) {
    const double error = ErrorOf(map, points[i]) / outlier;
    cost += error < 1 ? error * error : 1;
  }
  return cost;
}

/// The best of no motion, the fit to all points, and many fits to a few points (RANSAC): an object
/// that covers a fifth of the image can mislead a fit to all points.
glm::dmat4x3 StartOfMap(const std::vector<MovedPoint>& points, double pixel) {
  constexpr int kTrials = 300;
  constexpr int kPoints = 6;  // 12 equations, 11 unknowns
  constexpr int kSteps = 3;
  constexpr double kEqualWeights = 1e9;
  const glm::dmat4x3 still(1.0);
  glm::dmat4x3 best = still;
  double least = CostOf(still, points, kOutlier * pixel);
  const auto consider = [&](const std::vector<MovedPoint>& some) {
    glm::dmat4x3 map = still;
    for (int i = 0; i < kSteps; ++i) {
      map = ImproveMap(some, kEqualWeights, map);
    }
    const double cost = CostOf(map, points, kOutlier * pixel);
    if (cost < least) {
      least = cost;
      best = map;
    }
  };
  consider(points);
  std::minstd_rand random;
  for (int trial = 0; trial < kTrials && !points.empty(); ++trial) {
    std::vector<MovedPoint> few;
    for (int i = 0; i < kPoints; ++i) {
      few.push_back(points[random() % points.size()]);
    }
    consider(few);
  }
  return best;
}

/// Whether the points move and lie in one plane, so that the motion at other depths is unknown:
/// with the plane's nearness a . (p, 1), the maps H - e a^T with the epipole e move its points
/// alike for every e (Hartley and Zisserman, section 13.1). For a plane that does not move, only a
/// static camera is plausible.
bool IsOnePlane(const glm::dmat4x3& map, const std::vector<MovedPoint>& points, double tolerance) {
  /// RMS deviation of the nearness from the plane, relative to the median nearness, from which on
  /// the epipole is determined: depth in halves deviates by 0.0003, and errors of 0.01 pixels in
  /// the motion of all samples amount to 0.03 pixels far from the plane.
  constexpr double kLeastRelief = 0.003;
  constexpr double kStill = 0.02;  // of the tolerance
  NormalEquations<3> equations;
  double moved = 0;
  size_t fitting = 0;
  for (const MovedPoint& point : points) {
    if (ErrorOf(map, point) < tolerance) {
      equations.Add({static_cast<double>(point.now.x), static_cast<double>(point.now.y), 1},
                    point.nearness, 1);
      moved = std::max(moved, static_cast<double>(glm::length(point.before - point.now)));
      ++fitting;
    }
  }
  if (moved < kStill * tolerance) {
    return false;
  }
  const std::array<double, 3> plane = equations.Solve(1e-12);
  double squares = 0;
  for (const MovedPoint& point : points) {
    if (ErrorOf(map, point) < tolerance) {
      const double on_plane = plane[0] * point.now.x + plane[1] * point.now.y + plane[2];
      squares += (point.nearness - on_plane) * (point.nearness - on_plane);
    }
  }
  return squares < kLeastRelief * kLeastRelief * static_cast<double>(fitting);
}

// The field of view.

/// A normal, and the plane through nearness around it (NearnessPlane), of unit length.
struct SlopedNormal {
  glm::dvec3 normal;
  glm::dvec3 plane;
};

/// The plane through nearness, 1 / depth, around a pixel: (slope by x, slope by y, value at the
/// image centre). Nothing at edges, and on surfaces that are curved or not smooth.
std::optional<glm::dvec3> NearnessPlane(const Image1& depth, const Image3& normal, int x, int y) {
  constexpr int kReach = 2;
  constexpr float kSameCosine = 0.99f;
  constexpr double kSameDepth = 0.05;
  NormalEquations<3> equations;
  const vec3 own = VectorAt(normal, x, y);
  const double z = static_cast<double>(depth(x, y));
  for (int v = y - kReach; v <= y + kReach; ++v) {
    for (int u = x - kReach; u <= x + kReach; ++u) {
      const double relative = z / static_cast<double>(depth(u, v));
      if (!(std::abs(relative - 1) < kSameDepth) ||
          !(dot(own, VectorAt(normal, u, v)) > kSameCosine * dot(own, own))) {
        return std::nullopt;
      }
      equations.Add({static_cast<double>(u - x), static_cast<double>(v - y), 1}, relative, 1);
    }
  }
  const std::array<double, 3> fit = equations.Solve(1e-12);
  const double pixels = 0.5 * depth.width();  // per unit of PicturePoint
  const glm::dvec2 slope = pixels * glm::dvec2(fit[0], fit[1]);
  const glm::dvec2 p(PixelPoint(depth, x, y));
  return glm::dvec3(slope, fit[2] - glm::dot(slope, p));
}

std::vector<SlopedNormal> SlopedNormals(const Image1& depth, const Image3& normal) {
  constexpr int kBorder = 2;
  const int width = depth.width();
  const int height = depth.height();
  std::vector<SlopedNormal> normals;
  ForEachSample(width, height, kSlopeSamples, [&](int x, int y) {
    const bool inside = x >= kBorder && y >= kBorder && x < width - kBorder && y < height - kBorder;
    const vec3 n = inside ? VectorAt(normal, x, y) : vec3(0.0f);
    if (n == vec3(0.0f) || !IsNormal(n) || !IsSurface(depth(x, y))) {
      return;
    }
    if (const std::optional<glm::dvec3> plane = NearnessPlane(depth, normal, x, y)) {
      normals.push_back({glm::normalize(glm::dvec3(n)), glm::normalize(*plane)});
    }
  });
  return normals;
}

/// Two surfaces that are not parallel. For the correct tangent the angles between their normals and
/// between their planes are equal.
struct SurfacePair {
  glm::dvec3 a;  ///< planes
  glm::dvec3 b;
  double cosine = 0;  ///< of their normals
};

std::vector<SurfacePair> PairsOf(const std::vector<SlopedNormal>& normals) {
  constexpr double kParallel = 0.95;
  constexpr size_t kPairsPerNormal = 4;
  std::vector<SurfacePair> pairs;
  std::minstd_rand random;
  for (const SlopedNormal& n : normals) {
    for (size_t i = 0; i < kPairsPerNormal; ++i) {
      const SlopedNormal& other = normals[random() % normals.size()];
      const double cosine = glm::dot(n.normal, other.normal);
      if (std::abs(cosine) < kParallel) {
        pairs.push_back({n.plane, other.plane, cosine});
      }
    }
  }
  return pairs;
}

/// Difference of the cosines of the angles by normals and by planes.
double ErrorOf(const SurfacePair& pair, double tangent) {
  const glm::dvec3 scale(1 / tangent, 1 / tangent, 1);
  return glm::dot(glm::normalize(scale * pair.a), glm::normalize(scale * pair.b)) - pair.cosine;
}

/// Sum of squared errors, each less than 1.
double CostOf(const std::vector<SurfacePair>& pairs, double tangent) {
  constexpr double kScale = 0.02;
  double cost = 0;
  for (const SurfacePair& pair : pairs) {
    const double error = ErrorOf(pair, tangent) / kScale;
    cost += error * error / (1 + error * error);
  }
  return cost;
}

/// The tangent of the least cost, by golden sections between the neighbours of the best of a
/// geometric series.
double BestTangent(const std::vector<SurfacePair>& pairs) {
  constexpr double kFirst = 0.02;
  constexpr double kFactor = 1.05;
  constexpr int kTrials = 110;  // up to 4.3, 154 degrees
  constexpr int kSections = 20;
  constexpr double kGolden = 0.6180339887498949;
  double best = kFirst;
  double least = CostOf(pairs, best);
  for (int i = 1; i < kTrials; ++i) {
    const double tangent = kFirst * std::pow(kFactor, i);
    const double cost = CostOf(pairs, tangent);
    best = cost < least ? tangent : best;
    least = std::min(cost, least);
  }
  double low = best / kFactor;
  double high = best * kFactor;
  for (int i = 0; i < kSections; ++i) {
    const double a = high - kGolden * (high - low);
    const double b = low + kGolden * (high - low);
    const bool is_lower = CostOf(pairs, a) < CostOf(pairs, b);
    (is_lower ? high : low) = is_lower ? b : a;
  }
  return 0.5 * (low + high);
}

}  // namespace

mat3 FitNormalMap(const Image3& normal, const Image3& mapped) {
  std::vector<NormalPair> pairs;
  ForEachSample(normal.width(), normal.height(), kNormalSamples, [&](int x, int y) {
    const NormalPair pair = {VectorAt(normal, x, y), VectorAt(mapped, x, y)};
    if (IsNormal(pair.normal) && IsNormal(pair.mapped) && pair.normal != vec3(0.0f)) {
      pairs.push_back(pair);
    }
  });
  return MapOf(pairs);
}

double Lens::Cosine(vec2 p) const {
  const glm::dvec2 offset = glm::dvec2(p) - centre;
  return 1 / std::sqrt(1 + k * glm::dot(offset, offset));
}

std::optional<Lens> FitLens(const Image1& depth, const Image1& distance) {
  const int width = depth.width();
  const int height = depth.height();
  std::vector<Distance> distances;
  size_t surfaces = 0;
  ForEachSample(width, height, kSamples, [&](int x, int y) {
    const float z = depth(x, y);
    const float d = distance(x, y);
    surfaces += IsSurface(z) ? 1 : 0;
    if (IsSurface(z) && IsSurface(d)) {
      const vec2 p = PixelPoint(depth, x, y);
      distances.push_back({p, static_cast<double>(z), static_cast<double>(d)});
    }
  });
  Lens lens = StartOfLens(distances);
  RefineLens(distances, &lens);
  const auto fitting = std::count_if(distances.begin(), distances.end(), [&](const Distance& d) {
    return std::abs(RelativeError(lens, d)) < kLensTolerance;
  });
  const bool fits =
      surfaces > 0 && static_cast<double>(fitting) >= kLeastPart * static_cast<double>(surfaces);
  return fits ? std::optional<Lens>(lens) : std::nullopt;
}

std::optional<View> FitView(const Image1& depth, const Image3& normal) {
  constexpr size_t kFewest = 32;
  constexpr double kTolerance = 0.03;
  constexpr double kLeastFitting = 0.5;
  const std::vector<SlopedNormal> normals = SlopedNormals(depth, normal);
  const std::vector<SurfacePair> pairs = PairsOf(normals);
  if (pairs.size() < kFewest) {
    return std::nullopt;
  }
  View view;
  view.tangent = BestTangent(pairs);
  const auto fitting = std::count_if(pairs.begin(), pairs.end(), [&](const SurfacePair& pair) {
    return std::abs(ErrorOf(pair, view.tangent)) < kTolerance;
  });
  if (static_cast<double>(fitting) < kLeastFitting * static_cast<double>(pairs.size())) {
    return std::nullopt;
  }
  std::vector<NormalPair> turned;
  turned.reserve(normals.size());
  const glm::dvec3 scale(1 / view.tangent, 1 / view.tangent, 1);
  for (const SlopedNormal& n : normals) {
    turned.push_back({vec3(n.normal), vec3(-glm::normalize(scale * n.plane))});
  }
  view.to_camera = MapOf(turned);
  return view;
}

std::optional<CameraMotion> FitCameraMotion(const Image1& depth, const Image2& motion) {
  constexpr int kIterations = 12;
  constexpr double kTolerance = 0.1;  // pixels
  constexpr double kLeastScale = 0.01;
  const double pixel = 2.0 / depth.width();
  std::vector<MovedPoint> points = MovedPoints(depth, motion);
  std::vector<double> nearness;
  for (const MovedPoint& point : points) {
    nearness.push_back(point.nearness);
  }
  CameraMotion fit;
  fit.depth_unit = points.empty() ? 1 : 1 / Median(&nearness);
  for (MovedPoint& point : points) {
    point.nearness *= fit.depth_unit;
  }
  fit.map = StartOfMap(points, pixel);
  double scale = kOutlier * pixel;
  for (int i = 0; i < kIterations; ++i) {
    fit.map = ImproveMap(points, scale, fit.map);
    scale = std::max({0.7 * scale, kLeastScale * pixel, NoiseOf(fit.map, points, pixel)});
  }
  const auto fitting = std::count_if(points.begin(), points.end(), [&](const MovedPoint& point) {
    return ErrorOf(fit.map, point) < kTolerance * pixel;
  });
  const bool fits = !points.empty() &&
                    static_cast<double>(fitting) >= kLeastPart * static_cast<double>(points.size());
  if (!fits) {
    return std::nullopt;
  }
  fit.of_one_plane = IsOnePlane(fit.map, points, kTolerance * pixel);
  return fit;
}

const std::optional<CameraMotion>& CameraFits::Motion() {
  if (!camera_) {
    const std::optional<CameraMotion> fit =
        motion_.empty() ? std::nullopt : FitCameraMotion(depth_, motion_);
    sees_one_plane_ = fit && fit->of_one_plane;
    camera_ = sees_one_plane_ ? std::nullopt : fit;
  }
  return *camera_;
}

bool CameraFits::SeesOnePlane() {
  Motion();
  return sees_one_plane_;
}

const std::optional<View>& CameraFits::FieldOfView() {
  if (!view_) {
    view_ = FitView(depth_, normal_);
  }
  return *view_;
}

vec2 ImageMotion(const CameraMotion& camera, const Guides& guides, int x, int y, float image) {
  const int width = guides.depth.width();
  const vec2 p = PixelPoint(guides.depth, x, y);
  const vec2 moved = camera.MotionOf(p, static_cast<double>(image), width);
  const vec2 own = {guides.motion[0](x, y), guides.motion[1](x, y)};
  const vec2 rest = own - camera.MotionOf(p, static_cast<double>(guides.depth(x, y)), width);
  return moved + rest;
}

}  // namespace stillray::io
