// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/camera_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "core/pixels.h"

namespace stillray::io {
namespace {

/// At most this many pixels are fitted.
constexpr int64_t kNormalSamples = 1 << 16;
constexpr int64_t kSamples = 1 << 14;
/// Least part of the samples that must follow a fit.
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

bool IsSurface(float depth) {
  return depth > 0 && std::isfinite(depth);
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

/// Normal equations of a least-squares problem with N unknowns.
template <int N>
struct NormalEquations {
  std::array<std::array<double, N>, N> squares{};
  std::array<double, N> products{};

  void Add(const std::array<double, N>& row, double value, double weight) {
    for (size_t i = 0; i < N; ++i) {
      for (size_t j = 0; j <= i; ++j) {
        squares[i][j] += weight * row[i] * row[j];
      }
      products[i] += weight * row[i] * value;
    }
  }

  /// Cholesky. \param ridge  relative to the largest square; keeps unknowns that no equation
  /// determines at zero
  std::array<double, N> Solve(double ridge) const {
    double largest = 1e-300;
    for (size_t i = 0; i < N; ++i) {
      largest = std::max(largest, squares[i][i]);
    }
    auto l = squares;
    std::array<double, N> x = products;
    for (size_t i = 0; i < N; ++i) {
      l[i][i] += ridge * largest;
      for (size_t j = 0; j <= i; ++j) {
        for (size_t k = 0; k < j; ++k) {
          l[i][j] -= l[i][k] * l[j][k];
        }
        l[i][j] = i == j ? std::sqrt(std::max(l[i][i], 1e-300)) : l[i][j] / l[j][j];
      }
      for (size_t k = 0; k < i; ++k) {
        x[i] -= l[i][k] * x[k];
      }
      x[i] /= l[i][i];
    }
    for (size_t i = N; i-- > 0;) {
      for (size_t k = i + 1; k < N; ++k) {
        x[i] -= l[k][i] * x[k];
      }
      x[i] /= l[i][i];
    }
    return x;
  }
};

// The map of normals.

struct NormalPair {
  vec3 normal;
  vec3 mapped;
};

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

/// A start that mirrors do not affect: alternating medians of both unknowns, for rays around the
/// centre of the picture.
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

/// Gauss and Newton on the distances that fit.
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

/// One step of Gauss and Newton. The entry of w that belongs to 1 stays 1.
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

/// The motion of all surfaces of a grid. Depths are not yet divided by the unit.
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

/// Error of points that do not follow the camera, in pixels.
constexpr double kOutlier = 0.3;

/// The median error of points that follow the map: the rounding of halves, which is that of large
/// motion.
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

/// Sum of squared errors, each at most that of an outlier, over some of the points.
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

/// The best of no motion, the map of all points, and many maps that a few points determine: an
/// object that covers a fifth of the picture can lead astray a fit that starts with all points.
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

}  // namespace

mat3 FitNormalMap(const Image3& normal, const Image3& mapped) {
  constexpr int kIterations = 12;
  /// Residual below which all samples have the same weight: the rounding of halves, and bump maps
  /// that differ between the closures of one surface.
  constexpr double kResidualFloor = 0.01;
  std::vector<NormalPair> pairs;
  ForEachSample(normal.width(), normal.height(), kNormalSamples, [&](int x, int y) {
    const NormalPair pair = {VectorAt(normal, x, y), VectorAt(mapped, x, y)};
    if (IsNormal(pair.normal) && IsNormal(pair.mapped) && pair.normal != vec3(0.0f)) {
      pairs.push_back(pair);
    }
  });
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

vec2 PicturePoint(int width, int height, float x, float y) {
  const float scale = 2.0f / static_cast<float>(width);
  return {(x - 0.5f * static_cast<float>(width)) * scale,
          (y - 0.5f * static_cast<float>(height)) * scale};
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
      const vec2 p =
          PicturePoint(width, height, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
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

vec2 CameraMotion::MotionOf(vec2 p, double z, int width) const {
  const glm::dvec3 moved = Moved(map, p, depth_unit / z);
  const glm::dvec2 before = glm::dvec2(moved) / moved.z;
  return vec2((before - glm::dvec2(p)) * (0.5 * width));
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
  return fits ? std::optional<CameraMotion>(fit) : std::nullopt;
}

}  // namespace stillray::io
