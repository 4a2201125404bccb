// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/match_guides.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "stillray/vec.h"

namespace stillray::motion {
namespace {

constexpr int kPatch = 8;   ///< pixels of a side
constexpr int kStride = 4;  ///< pixels from one patch to the next: four patches cover a pixel
constexpr int kPatchPixels = kPatch * kPatch;
constexpr int kPatchRowsPerTask = 4;

/// Weight of pixels that differ from the patch centre in id, or in depth by more than kOtherDepth:
/// silhouettes still localise plain objects.
constexpr float kOtherWeight = 0.2f;
constexpr float kOtherDepth = 0.05f;
constexpr int kIterations = 10;
constexpr float kStill = 0.01f;  ///< pixels; smaller steps end the iteration
/// Added to the diagonal of the normal equations, per unit of weight: without structure, motion is
/// unchanged.
constexpr float kRidge = 2e-4f;
/// Another motion must reduce the mean squared difference by this fraction and by this amount.
constexpr float kBetter = 0.95f;
constexpr float kBetterBy = 1e-6f;
/// Mean squared difference above which a motion does not fit, and the neighbourhood is searched.
constexpr float kUnexplained = 4e-3f;
/// Maximum cost ratio of a searched motion to the old one, since textures repeat.
constexpr float kFound = 0.4f;
/// Distance beyond which all other searched positions must fit worse by kFound.
constexpr float kNotNext = 2.5f;  // pixels
constexpr int kReach = 6;         ///< of the search, in pixels of the level
constexpr int kRounds = 2;        ///< in which motion spreads to neighbours

/// The channels of a patch, and the terms that are constant during its alignment.
struct Template {
  alignas(64) float values[kPatchPixels][kChannels];
  alignas(64) float by_x[kPatchPixels][kChannels];
  alignas(64) float by_y[kPatchPixels][kChannels];
  alignas(64) float mean_by_x[kChannels];  ///< zero for channels that keep their mean
  alignas(64) float mean_by_y[kChannels];
  float weights[kPatchPixels];
  float total = 0;  ///< of the weights
  float xx = 0;     ///< normal equations
  float xy = 0;
  float yy = 0;
};

constexpr bool IsMeanFree(int channel) {
  return channel >= kFirstMeanFree && channel < kEndMeanFree;
}

/// Weighted means over the patch, of the channels from which the mean is subtracted.
void MeansOf(const float (&values)[kPatchPixels][kChannels], const Template& t, float* means) {
  std::fill_n(means, kChannels, 0.0f);
  for (int i = 0; i < kPatchPixels; ++i) {
    for (int c = 0; c < kChannels; ++c) {
      means[c] += t.weights[i] * values[i][c];
    }
  }
  for (int c = 0; c < kChannels; ++c) {
    means[c] = IsMeanFree(c) ? means[c] / t.total : 0.0f;
  }
}

void MakeTemplate(const GuideLevel& level, int x0, int y0, Template* t) {
  const float* middle = level.At(x0 + kPatch / 2, y0 + kPatch / 2);
  t->total = 0;
  for (int j = 0; j < kPatch; ++j) {
    for (int i = 0; i < kPatch; ++i) {
      const int k = j * kPatch + i;
      const float* at = level.At(x0 + i, y0 + j);
      const float* right = at + kChannels;
      const float* left = at - kChannels;
      const float* below = at + level.stride();
      const float* above = at - level.stride();
      for (int c = 0; c < kChannels; ++c) {
        t->values[k][c] = at[c];
        t->by_x[k][c] = 0.5f * (right[c] - left[c]);
        t->by_y[k][c] = 0.5f * (below[c] - above[c]);
      }
      const bool same =
          std::fabs(at[6] - middle[6]) < kOtherDepth && std::fabs(at[7] - middle[7]) < 1e-3f;
      t->weights[k] = same ? 1.0f : kOtherWeight;
      t->total += t->weights[k];
    }
  }
  MeansOf(t->by_x, *t, t->mean_by_x);
  MeansOf(t->by_y, *t, t->mean_by_y);
  alignas(64) float xx[kChannels] = {};
  alignas(64) float xy[kChannels] = {};
  alignas(64) float yy[kChannels] = {};
  for (int k = 0; k < kPatchPixels; ++k) {
    for (int c = 0; c < kChannels; ++c) {
      const float gx = t->by_x[k][c] - t->mean_by_x[c];
      const float gy = t->by_y[k][c] - t->mean_by_y[c];
      xx[c] += t->weights[k] * gx * gx;
      xy[c] += t->weights[k] * gx * gy;
      yy[c] += t->weights[k] * gy * gy;
    }
  }
  t->xx = t->xy = t->yy = 0;
  for (int c = 0; c < kChannels; ++c) {
    t->xx += xx[c];
    t->xy += xy[c];
    t->yy += yy[c];
  }
}

/// The result of evaluating a patch at a position.
struct Fit {
  float cost = 0;  ///< mean squared difference
  float x = 0;     ///< right side of the normal equations
  float y = 0;
};

/// \param place  position of the patch's first pixel in `before`
Fit Compare(const Template& t, const GuideLevel& before, vec2 place) {
  constexpr float kEdge = GuideLevel::kBorder;
  const float px =
      std::clamp(place.x, -kEdge, static_cast<float>(before.width()) + kEdge - kPatch - 1);
  const float py =
      std::clamp(place.y, -kEdge, static_cast<float>(before.height()) + kEdge - kPatch - 1);
  const float fx = std::floor(px);
  const float fy = std::floor(py);
  const float u = px - fx;
  const float v = py - fy;
  const float w00 = (1 - u) * (1 - v);
  const float w10 = u * (1 - v);
  const float w01 = (1 - u) * v;
  const float w11 = u * v;
  alignas(64) float square[kChannels] = {};
  alignas(64) float sum[kChannels] = {};
  alignas(64) float by_x[kChannels] = {};
  alignas(64) float by_y[kChannels] = {};
  for (int j = 0; j < kPatch; ++j) {
    const float* top = before.At(static_cast<int>(fx), static_cast<int>(fy) + j);
    const float* bottom = top + before.stride();
    for (int i = 0; i < kPatch; ++i) {
      const int k = j * kPatch + i;
      const float weight = t.weights[k];
      const float* a = top + i * kChannels;
      const float* b = bottom + i * kChannels;
      for (int c = 0; c < kChannels; ++c) {
        const float value =
            w00 * a[c] + w10 * a[c + kChannels] + w01 * b[c] + w11 * b[c + kChannels];
        const float difference = value - t.values[k][c];
        const float weighted = weight * difference;
        square[c] += weighted * difference;
        sum[c] += weighted;
        by_x[c] += weighted * t.by_x[k][c];
        by_y[c] += weighted * t.by_y[k][c];
      }
    }
  }
  Fit fit;
  for (int c = 0; c < kChannels; ++c) {
    const float mean = IsMeanFree(c) ? sum[c] / t.total : 0.0f;
    fit.cost += square[c] - mean * sum[c];
    fit.x += by_x[c] - t.mean_by_x[c] * sum[c];
    fit.y += by_y[c] - t.mean_by_y[c] * sum[c];
  }
  fit.cost = std::max(fit.cost, 0.0f) / t.total;
  return fit;
}

/// One patch of a level, and its best motion so far.
struct Patch {
  vec2 motion{0.0f};
  float cost = 0;
  float structure = 0;  ///< see Matched
};

/// The root of the smaller eigenvalue of the normal equations.
float StructureOf(const Template& t) {
  const float middle = 0.5f * (t.xx + t.yy);
  const float half = 0.5f * (t.xx - t.yy);
  const float least = middle - std::sqrt(half * half + t.xy * t.xy);
  return std::sqrt(std::max(least, 0.0f) / t.total);
}

bool IsBetter(float cost, float than) {
  return cost < kBetter * than - kBetterBy;
}

class PatchMatcher {
 public:
  PatchMatcher(const GuideLevel& before, const Template& t, int x0, int y0)
      : before_(before), template_(t), at_(static_cast<float>(x0), static_cast<float>(y0)) {}

  Fit At(vec2 motion) const { return Compare(template_, before_, at_ + motion); }

  /// Replaces the motion by another one that fits clearly better.
  bool Try(vec2 motion, Patch* patch) const {
    const float cost = At(motion).cost;
    if (!IsBetter(cost, patch->cost)) {
      return false;
    }
    patch->motion = motion;
    patch->cost = cost;
    return true;
  }

  /// Gauss-Newton with a weak regularisation towards the initial motion. Keeps the best of all
  /// steps.
  void Refine(Patch* patch) const {
    const float ridge = kRidge * template_.total;
    const float xx = template_.xx + ridge;
    const float yy = template_.yy + ridge;
    const float determinant = xx * yy - template_.xy * template_.xy;
    const vec2 start = patch->motion;
    vec2 motion = start;
    for (int i = 0; i < kIterations; ++i) {
      Fit fit = At(motion);
      fit.x += ridge * (motion.x - start.x);
      fit.y += ridge * (motion.y - start.y);
      if (fit.cost < patch->cost) {
        patch->motion = motion;
        patch->cost = fit.cost;
      } else if (i > 2) {
        return;
      }
      const vec2 step((yy * fit.x - template_.xy * fit.y) / determinant,
                      (xx * fit.y - template_.xy * fit.x) / determinant);
      const float length = glm::length(step);
      if (!(length > kStill)) {  // or NaN
        return;
      }
      motion -= length > 2.0f ? step * (2.0f / length) : step;
    }
    const float cost = At(motion).cost;
    if (cost < patch->cost) {
      patch->motion = motion;
      patch->cost = cost;
    }
  }

  /// Searches the neighbourhood, in steps of two pixels and then of one. False if no position fits
  /// clearly better than all others.
  bool Search(Patch* patch) const {
    constexpr int kSteps = kReach / 2;
    constexpr int kSide = 2 * kSteps + 1;
    std::array<float, kSide * kSide> costs;
    Patch best = *patch;
    const auto offset = [](int i) {
      return vec2(static_cast<float>(2 * (i % kSide - kSteps)),
                  static_cast<float>(2 * (i / kSide - kSteps)));
    };
    for (int i = 0; i < kSide * kSide; ++i) {
      const vec2 motion = patch->motion + offset(i);
      costs[static_cast<size_t>(i)] = At(motion).cost;
      if (costs[static_cast<size_t>(i)] < best.cost) {
        best.motion = motion;
        best.cost = costs[static_cast<size_t>(i)];
      }
    }
    const vec2 coarse = best.motion;
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        Try(coarse + vec2(static_cast<float>(x), static_cast<float>(y)), &best);
      }
    }
    Refine(&best);
    if (best.cost >= kFound * patch->cost) {
      return false;
    }
    for (int i = 0; i < kSide * kSide; ++i) {
      if (glm::length(patch->motion + offset(i) - coarse) > kNotNext &&
          best.cost >= kFound * costs[static_cast<size_t>(i)]) {
        return false;
      }
    }
    *patch = best;
    return true;
  }

 private:
  const GuideLevel& before_;
  const Template& template_;
  vec2 at_;
};

/// The patches of one level.
class PatchGrid {
 public:
  PatchGrid(const GuideLevel& now, const GuideLevel& before)
      : now_(now),
        before_(before),
        columns_((now.width() + kStride - 1) / kStride),
        rows_((now.height() + kStride - 1) / kStride),
        patches_(static_cast<size_t>(columns_) * static_cast<size_t>(rows_)) {}

  void Match(const Image2& coarse, const Image2& start, bool searches);
  void Spread();
  Image2 Dense() const;
  Image1 Structure() const;

 private:
  /// The centre of a patch is the centre of its kStride x kStride pixels.
  static int FirstPixel(int i) { return i * kStride + kStride / 2 - kPatch / 2; }
  size_t Index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }
  Patch MatchOne(int column, int row, const Image2& coarse, const Image2& start,
                 bool searches) const;

  const GuideLevel& now_;
  const GuideLevel& before_;
  int columns_;
  int rows_;
  std::vector<Patch> patches_;
};

/// Motion of a pixel of this level, from a plane of this size or of half of it.
vec2 MotionAt(const Image2& motion, int x, int y, int divisor) {
  const int u = std::clamp(x / divisor, 0, motion.width() - 1);
  const int v = std::clamp(y / divisor, 0, motion.height() - 1);
  return vec2(motion[0](u, v), motion[1](u, v)) * static_cast<float>(divisor);
}

Patch PatchGrid::MatchOne(int column, int row, const Image2& coarse, const Image2& start,
                          bool searches) const {
  const int x0 = FirstPixel(column);
  const int y0 = FirstPixel(row);
  const int x = std::min(x0 + kPatch / 2, now_.width() - 1);
  const int y = std::min(y0 + kPatch / 2, now_.height() - 1);
  Template t;
  MakeTemplate(now_, x0, y0, &t);
  const PatchMatcher matcher(before_, t, x0, y0);
  const vec2 from_coarse = coarse.empty() ? vec2(0.0f) : MotionAt(coarse, x, y, 2);
  const vec2 first = start.empty() ? from_coarse : MotionAt(start, x, y, 1);
  Patch patch = {first, matcher.At(first).cost, StructureOf(t)};
  if (!start.empty() && patch.cost <= kBetterBy) {
    return patch;
  }
  matcher.Try(start.empty() ? vec2(0.0f) : from_coarse, &patch);
  Patch refined = patch;
  matcher.Refine(&refined);
  if (searches && refined.cost > kUnexplained) {
    matcher.Search(&refined);
  }
  return start.empty() || IsBetter(refined.cost, patch.cost) ? refined : patch;
}

void PatchGrid::Match(const Image2& coarse, const Image2& start, bool searches) {
  ParallelRows(rows_, kPatchRowsPerTask, [&](int r0, int r1) {
    for (int row = r0; row < r1; ++row) {
      for (int column = 0; column < columns_; ++column) {
        patches_[Index(column, row)] = MatchOne(column, row, coarse, start, searches);
      }
    }
  });
}

/// Patches try the motion of their neighbours before this round.
void PatchGrid::Spread() {
  const std::vector<Patch> last = patches_;
  constexpr int kNeighbours[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  constexpr float kSameMotion = 0.1f;  // pixels
  ParallelRows(rows_, kPatchRowsPerTask, [&](int r0, int r1) {
    for (int row = r0; row < r1; ++row) {
      for (int column = 0; column < columns_; ++column) {
        Patch& patch = patches_[Index(column, row)];
        if (patch.cost <= kBetterBy) {
          continue;
        }
        Template t;
        bool made = false;
        for (const auto& [dx, dy] : kNeighbours) {
          const int u = column + dx;
          const int v = row + dy;
          if (u < 0 || v < 0 || u >= columns_ || v >= rows_) {
            continue;
          }
          const vec2 motion = last[Index(u, v)].motion;
          if (glm::length(motion - patch.motion) < kSameMotion) {
            continue;
          }
          if (!made) {
            MakeTemplate(now_, FirstPixel(column), FirstPixel(row), &t);
            made = true;
          }
          const PatchMatcher matcher(before_, t, FirstPixel(column), FirstPixel(row));
          if (matcher.Try(motion, &patch)) {
            matcher.Refine(&patch);
          }
        }
      }
    }
  });
}

/// The motion of one pixel: the mean over the surrounding patches that agree with the best one,
/// weighted by their fit.
Image2 PatchGrid::Dense() const {
  constexpr float kAgreed = 1.0f;      // pixels
  constexpr float kCostFloor = 1e-4f;  // of noise
  Image2 dense(now_.width(), now_.height());
  ParallelRows(now_.height(), 4 * kPatchRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < now_.width(); ++x) {
        // Patches whose own pixels are these, or up to one and a half strides away.
        std::array<vec2, 10> motions;
        std::array<float, 10> costs;
        size_t count = 0;
        const auto add = [&](vec2 motion, float cost) {
          motions[count] = motion;
          costs[count++] = cost;
        };
        for (int row = y / kStride - 1; row <= y / kStride + 1; ++row) {
          for (int column = x / kStride - 1; column <= x / kStride + 1; ++column) {
            if (row >= 0 && column >= 0 && row < rows_ && column < columns_) {
              const Patch& patch = patches_[Index(column, row)];
              add(patch.motion, PixelCost(now_, before_, x, y, patch.motion) + 0.25f * patch.cost);
            }
          }
        }
        size_t best = 0;
        for (size_t i = 1; i < count; ++i) {
          best = costs[i] < costs[best] ? i : best;
        }
        vec2 sum(0.0f);
        float total = 0;
        for (size_t i = 0; i < count; ++i) {
          if (glm::length(motions[i] - motions[best]) < kAgreed) {
            const float weight = 1 / (kCostFloor + costs[i]);
            sum += weight * motions[i];
            total += weight;
          }
        }
        dense[0](x, y) = sum.x / total;
        dense[1](x, y) = sum.y / total;
      }
    }
  });
  return dense;
}

Image1 PatchGrid::Structure() const {
  Image1 structure(now_.width(), now_.height());
  for (int y = 0; y < now_.height(); ++y) {
    for (int x = 0; x < now_.width(); ++x) {
      structure(x, y) = patches_[Index(x / kStride, y / kStride)].structure;
    }
  }
  return structure;
}

/// Motion at half the size: of one of four pixels, as a mean over two surfaces is wrong for both.
Image2 HalvedMotion(const Image2& motion) {
  Image2 half((motion.width() + 1) / 2, (motion.height() + 1) / 2);
  for (int c = 0; c < 2; ++c) {
    for (int y = 0; y < half.height(); ++y) {
      for (int x = 0; x < half.width(); ++x) {
        half[c](x, y) = 0.5f * motion[c](2 * x, 2 * y);
      }
    }
  }
  return half;
}

}  // namespace

float PixelCost(const GuideLevel& now, const GuideLevel& before, int x, int y, vec2 motion) {
  constexpr float kEdge = GuideLevel::kBorder;
  const float px = std::clamp(static_cast<float>(x) + motion.x, -kEdge,
                              static_cast<float>(before.width()) + kEdge - 2);
  const float py = std::clamp(static_cast<float>(y) + motion.y, -kEdge,
                              static_cast<float>(before.height()) + kEdge - 2);
  const float fx = std::floor(px);
  const float fy = std::floor(py);
  const float u = px - fx;
  const float v = py - fy;
  const float* own = now.At(x, y);
  const float* top = before.At(static_cast<int>(fx), static_cast<int>(fy));
  const float* bottom = top + before.stride();
  float sum = 0;
  for (int c = 0; c < kChannels; ++c) {
    const float above = top[c] + u * (top[c + kChannels] - top[c]);
    const float below = bottom[c] + u * (bottom[c + kChannels] - bottom[c]);
    const float difference = above + v * (below - above) - own[c];
    sum += difference * difference;
  }
  return sum;
}

Matched MatchPyramids(const GuidePyramid& now, const GuidePyramid& before, const Image2& start,
                      size_t finest) {
  std::vector<Image2> starts(now.levels.size());
  if (!start.empty()) {
    starts[finest] = start;
    for (size_t i = finest + 1; i < starts.size(); ++i) {
      starts[i] = HalvedMotion(starts[i - 1]);
    }
  }
  Matched matched;
  Image2& motion = matched.motion;
  for (size_t i = now.levels.size(); i-- > finest;) {
    PatchGrid grid(now.levels[i], before.levels[i]);
    grid.Match(motion, starts[i], i > 0);
    for (int round = 0; round < kRounds; ++round) {
      grid.Spread();
    }
    motion = grid.Dense();
    if (i == finest) {
      matched.structure = grid.Structure();
    }
  }
  return matched;
}

Image1 AgreementOf(const Image2& forth, const Image2& back) {
  // Tolerance of half a pixel for jagged silhouettes.
  constexpr float kAgreed = 0.5f;
  constexpr float kDisagreed = 1.5f;
  constexpr float kPart = 0.05f;  // of the length of the motion
  const int width = forth.width();
  const int height = forth.height();
  Image1 agreement(width, height);
  ParallelRows(height, 4 * kPatchRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        const vec2 there(forth[0](x, y), forth[1](x, y));
        const float u = static_cast<float>(x) + there.x;
        const float v = static_cast<float>(y) + there.y;
        if (!(u >= 0 && v >= 0 && u <= static_cast<float>(width - 1) &&
              v <= static_cast<float>(height - 1))) {
          continue;
        }
        float error = kDisagreed * 2;
        for (int i = 0; i < 4; ++i) {
          const int px = std::min(static_cast<int>(u) + (i & 1), width - 1);
          const int py = std::min(static_cast<int>(v) + (i >> 1), height - 1);
          error = std::min(error, glm::length(there + vec2(back[0](px, py), back[1](px, py))));
        }
        const float slack = kPart * glm::length(there);
        agreement(x, y) =
            std::clamp((kDisagreed + slack - error) / (kDisagreed - kAgreed), 0.0f, 1.0f);
      }
    }
  });
  return agreement;
}

}  // namespace stillray::motion
