// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/align_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/least_squares.h"
#include "core/parallel.h"
#include "motion/motion_field.h"

namespace stillray::motion {
namespace {

constexpr int kIterations = 12;
/// Albedo and normal. Depth changes with the camera, and ids do not localise.
constexpr int kCompared = 6;
/// Approximate maximum number of compared pixels: those with the strongest gradient in each part of
/// a row.
constexpr int64_t kMostPixels = 1 << 15;
/// Squared gradient per pixel below which a pixel is not compared.
constexpr float kLeastGradient2 = 1e-4f;
constexpr int64_t kFewestPixels = 200;
/// Squared difference at which the weight is 1/4, as a multiple of the median: reduces moving
/// objects, silhouettes, and highlights in guides.
constexpr float kOutlier2 = 4.0f;
constexpr float kLeastOutlier2 = 1e-5f;
/// Iterations end when no pixel moves by more than this, in pixels.
constexpr double kConverged = 1e-3;
/// A result farther from the start than this, in pixels, has diverged.
constexpr double kFarthest = 1.0;

using Unknowns = std::array<double, 11>;

/// A pixel that is compared.
struct Sample {
  int x;
  int y;
};

float Gradient2(const GuideLevel& level, int x, int y) {
  const float* left = level.At(x - 1, y);
  const float* right = level.At(x + 1, y);
  const float* above = level.At(x, y - 1);
  const float* below = level.At(x, y + 1);
  float sum = 0;
  for (int c = 0; c < kCompared; ++c) {
    const float gx = 0.5f * (right[c] - left[c]);
    const float gy = 0.5f * (below[c] - above[c]);
    sum += gx * gx + gy * gy;
  }
  return sum;
}

/// Per row, of every few pixels the one with the strongest gradient.
std::vector<Sample> PickSamples(const GuideLevel& now, const Image1& depth) {
  const int width = now.width();
  const int height = now.height();
  int step = 1;
  while (int64_t{width / step} * (height / step) > kMostPixels) {
    ++step;
  }
  std::vector<Sample> samples;
  for (int y = 1 + (step - 1) / 2; y < height - 1; y += step) {
    for (int x0 = 1; x0 < width - 1; x0 += step) {
      Sample best = {-1, y};
      float strongest = kLeastGradient2;
      for (int x = x0; x < std::min(x0 + step, width - 1); ++x) {
        const float gradient2 = IsSurface(depth(x, y)) ? Gradient2(now, x, y) : 0.0f;
        best.x = gradient2 > strongest ? x : best.x;
        strongest = std::max(strongest, gradient2);
      }
      if (best.x >= 0) {
        samples.push_back(best);
      }
    }
  }
  return samples;
}

/// Bilinearly interpolated values, and their gradients per pixel.
struct Warped {
  std::array<float, kCompared> value;
  std::array<float, kCompared> by_x;
  std::array<float, kCompared> by_y;
};

std::array<float, kCompared> ValueAt(const GuideLevel& level, float u, float v) {
  const float fx = std::floor(u);
  const float fy = std::floor(v);
  const float* top = level.At(static_cast<int>(fx), static_cast<int>(fy));
  const float* bottom = top + level.stride();
  std::array<float, kCompared> values;
  for (int c = 0; c < kCompared; ++c) {
    const float above = top[c] + (u - fx) * (top[c + kChannels] - top[c]);
    const float below = bottom[c] + (u - fx) * (bottom[c + kChannels] - bottom[c]);
    values[static_cast<size_t>(c)] = above + (v - fy) * (below - above);
  }
  return values;
}

Warped WarpedAt(const GuideLevel& level, float u, float v) {
  Warped warped;
  warped.value = ValueAt(level, u, v);
  const auto right = ValueAt(level, u + 1, v);
  const auto left = ValueAt(level, u - 1, v);
  const auto below = ValueAt(level, u, v + 1);
  const auto above = ValueAt(level, u, v - 1);
  for (size_t c = 0; c < kCompared; ++c) {
    warped.by_x[c] = 0.5f * (right[c] - left[c]);
    warped.by_y[c] = 0.5f * (below[c] - above[c]);
  }
  return warped;
}

/// One pixel under a motion: the difference of its guides, and the derivative by the entries of the
/// map.
struct Residual {
  bool valid = false;
  float square = 0;
  std::array<double, kCompared> difference{};
  std::array<Unknowns, kCompared> by_map{};
};

/// Derivative of a position by the entries of the map, except the constant entry of w.
std::array<Unknowns, 2> PlaceByMap(const glm::dvec4& from, const glm::dvec3& moved) {
  std::array<Unknowns, 2> by_map{};
  for (size_t c = 0; c < 2; ++c) {
    const double place = moved[static_cast<int>(c)] / moved.z;
    for (int i = 0; i < 4; ++i) {
      by_map[c][4 * c + static_cast<size_t>(i)] = from[i] / moved.z;
    }
    by_map[c][8] = -place * from.x / moved.z;
    by_map[c][9] = -place * from.y / moved.z;
    by_map[c][10] = -place * from.w / moved.z;
  }
  return by_map;
}

glm::dvec4 From(const CameraMotion& camera, int width, int height, int x, int y, float depth) {
  const vec2 p =
      PicturePoint(width, height, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
  return {glm::dvec2(p), 1.0, camera.depth_unit / static_cast<double>(depth)};
}

Residual ResidualOf(const GuideLevel& now, const GuideLevel& before, const Sample& at, float depth,
                    const CameraMotion& camera) {
  Residual residual;
  const int width = now.width();
  const int height = now.height();
  const glm::dvec4 from = From(camera, width, height, at.x, at.y, depth);
  const glm::dvec3 moved = camera.map * from;
  const double pixels = 0.5 * width;
  const glm::dvec2 place =
      glm::dvec2(moved) / moved.z * pixels + glm::dvec2(0.5 * width - 0.5, 0.5 * height - 0.5);
  if (!(place.x >= 1 && place.y >= 1 && place.x <= width - 2 && place.y <= height - 2)) {
    return residual;  // or NaN
  }
  residual.valid = true;
  const Warped there = WarpedAt(before, static_cast<float>(place.x), static_cast<float>(place.y));
  const Warped here = WarpedAt(now, static_cast<float>(at.x), static_cast<float>(at.y));
  const std::array<Unknowns, 2> by_map = PlaceByMap(from, moved);
  for (size_t c = 0; c < kCompared; ++c) {
    const float difference = there.value[c] - here.value[c];
    residual.square += difference * difference;
    residual.difference[c] = static_cast<double>(difference);
    const float gx = 0.5f * (there.by_x[c] + here.by_x[c]);
    const float gy = 0.5f * (there.by_y[c] + here.by_y[c]);
    for (size_t k = 0; k < by_map[0].size(); ++k) {
      residual.by_map[c][k] = pixels * (static_cast<double>(gx) * by_map[0][k] +
                                        static_cast<double>(gy) * by_map[1][k]);
    }
  }
  return residual;
}

CameraMotion Moved(const CameraMotion& camera, const Unknowns& step) {
  CameraMotion moved = camera;
  for (int i = 0; i < 4; ++i) {
    moved.map[i].x -= step[static_cast<size_t>(i)];
    moved.map[i].y -= step[static_cast<size_t>(4 + i)];
  }
  moved.map[0].z -= step[8];
  moved.map[1].z -= step[9];
  moved.map[3].z -= step[10];
  return moved;
}

/// The frames, and the pixels that are compared.
class Alignment {
 public:
  Alignment(const GuideLevel& now, const GuideLevel& before, const Image1& depth)
      : now_(now), before_(before), depth_(depth), samples_(PickSamples(now, depth)) {}

  bool HasStructure() const { return static_cast<int64_t>(samples_.size()) >= kFewestPixels; }

  /// The median of the squared differences.
  float MedianSquare(const CameraMotion& camera) const {
    std::vector<float> squares(samples_.size(), -1.0f);
    ForEachSample([&](size_t i) {
      const Residual residual = At(i, camera);
      squares[i] = residual.valid ? residual.square : -1.0f;
    });
    std::erase_if(squares, [](float square) { return square < 0; });
    if (squares.empty()) {
      return 0;
    }
    const auto middle = squares.begin() + static_cast<ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    return *middle;
  }

  /// The Gauss-Newton step of the unknowns.
  Unknowns Step(const CameraMotion& camera, float outlier2) const {
    // Partial sums over fixed sets of pixels, so that results do not depend on threads.
    std::vector<NormalEquations<11>> parts((samples_.size() + kPart - 1) / kPart);
    ParallelRows(static_cast<int>(parts.size()), 1, [&](int p0, int p1) {
      for (int p = p0; p < p1; ++p) {
        const size_t first = static_cast<size_t>(p) * kPart;
        for (size_t i = first; i < std::min(first + kPart, samples_.size()); ++i) {
          AddTo(At(i, camera), outlier2, &parts[static_cast<size_t>(p)]);
        }
      }
    });
    NormalEquations<11> sum;
    for (const NormalEquations<11>& part : parts) {
      sum.Add(part);
    }
    return sum.Solve(1e-12);
  }

  /// The maximum difference of both motions over all pixels, in pixels.
  double Difference(const CameraMotion& a, const CameraMotion& b) const {
    double most = 0;
    for (size_t i = 0; i < samples_.size(); i += samples_.size() / 64 + 1) {
      const Sample& at = samples_[i];
      const vec2 p = PicturePoint(now_.width(), now_.height(), static_cast<float>(at.x) + 0.5f,
                                  static_cast<float>(at.y) + 0.5f);
      const double z = static_cast<double>(depth_(at.x, at.y));
      const vec2 way = a.MotionOf(p, z, now_.width()) - b.MotionOf(p, z, now_.width());
      most = std::max(most, static_cast<double>(glm::length(way)));
    }
    return most;
  }

 private:
  static constexpr size_t kPart = 512;

  Residual At(size_t i, const CameraMotion& camera) const {
    return ResidualOf(now_, before_, samples_[i], depth_(samples_[i].x, samples_[i].y), camera);
  }

  template <typename Body>
  void ForEachSample(const Body& body) const {
    ParallelRows(static_cast<int>(samples_.size()), kPart, [&](int i0, int i1) {
      for (int i = i0; i < i1; ++i) {
        body(static_cast<size_t>(i));
      }
    });
  }

  static void AddTo(const Residual& residual, float outlier2, NormalEquations<11>* equations) {
    if (!residual.valid) {
      return;
    }
    const double relative = static_cast<double>(residual.square / outlier2);
    const double weight = 1 / ((1 + relative) * (1 + relative));
    for (size_t c = 0; c < kCompared; ++c) {
      equations->Add(residual.by_map[c], residual.difference[c], weight);
    }
  }

  const GuideLevel& now_;
  const GuideLevel& before_;
  const Image1& depth_;
  std::vector<Sample> samples_;
};

}  // namespace

CameraMotion AlignCamera(const GuideLevel& now, const GuideLevel& before, const Image1& depth,
                         const CameraMotion& start) {
  const Alignment alignment(now, before, depth);
  if (!alignment.HasStructure()) {
    return start;
  }
  CameraMotion camera = start;
  for (int i = 0; i < kIterations; ++i) {
    const float outlier2 = std::max(kOutlier2 * alignment.MedianSquare(camera), kLeastOutlier2);
    const CameraMotion next = Moved(camera, alignment.Step(camera, outlier2));
    const double difference = alignment.Difference(camera, next);
    if (!std::isfinite(difference)) {
      return start;
    }
    camera = next;
    if (difference < kConverged) {
      break;
    }
  }
  return alignment.Difference(start, camera) < kFarthest ? camera : start;
}

}  // namespace stillray::motion
