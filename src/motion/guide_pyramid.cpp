// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/guide_pyramid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"

namespace stillray::motion {
namespace {

/// Minimum length of the shorter side of the coarsest level, in pixels.
constexpr int kLeastSide = 20;

/// Weight of albedo: textures localise better than shapes, where neighbours often have similar
/// normals.
constexpr float kAlbedoScale = 2.0f;
constexpr float kNormalScale = 0.7f;
/// Weight of the natural logarithm of depth: a depth edge of 10 % counts like an albedo difference
/// of 0.05.
constexpr float kDepthScale = 1.0f;
constexpr float kIdScale = 0.5f;
/// Logarithmic depth of pixels without a surface: differs from all surfaces in any unit.
constexpr float kNoSurface = 12.0f;
constexpr float kMostDepth = 11.0f;

float FiniteOr0(float value) {
  return std::isfinite(value) ? value : 0.0f;
}

/// 0 to 1, different for most pairs of ids.
float NumberOf(uint32_t id) {
  uint32_t h = id * 0x9e3779b1u;
  h ^= h >> 15;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  return static_cast<float>(h >> 8) * (1.0f / 16777216.0f);
}

float DepthFeature(float depth) {
  if (!(depth > 0)) {
    return 0;
  }
  return std::isfinite(depth) ? std::clamp(std::log(depth), -kMostDepth, kMostDepth) : kNoSurface;
}

void FillFinest(const Guides& guides, GuideLevel* level) {
  ParallelRows(level->height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < level->width(); ++x) {
        float* to = level->At(x, y);
        for (int c = 0; c < 3; ++c) {
          const float albedo = guides.albedo.empty() ? 0.0f : guides.albedo[c](x, y);
          to[c] = kAlbedoScale * std::clamp(FiniteOr0(albedo), 0.0f, 2.0f);
          to[3 + c] = kNormalScale * std::clamp(FiniteOr0(guides.normal[c](x, y)), -1.0f, 1.0f);
        }
        to[6] = kDepthScale * DepthFeature(guides.depth(x, y));
        to[7] = guides.id.empty() ? 0.0f : kIdScale * NumberOf(guides.id(x, y));
      }
    }
  });
  level->FillBorder();
}

/// Binomial filter 1 2 1 in both directions: guides of one sample have jagged edges, which prevent
/// sub-pixel alignment.
GuideLevel Smoothed(const GuideLevel& sharp) {
  constexpr float kWeights[3] = {0.25f, 0.5f, 0.25f};
  GuideLevel smooth(sharp.width(), sharp.height());
  ParallelRows(sharp.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < sharp.width(); ++x) {
        float sum[kChannels] = {};
        for (int j = 0; j < 3; ++j) {
          const float* from = sharp.At(x - 1, y - 1 + j);
          for (int i = 0; i < 3; ++i) {
            for (int c = 0; c < kChannels; ++c) {
              sum[c] += kWeights[j] * kWeights[i] * from[i * kChannels + c];
            }
          }
        }
        std::copy_n(sum, kChannels, smooth.At(x, y));
      }
    }
  });
  smooth.FillBorder();
  return smooth;
}

/// Half the size: means of 4x4 pixels with weights 1 3 3 1, centred on the pixels of the smaller
/// image.
GuideLevel Halved(const GuideLevel& fine) {
  constexpr float kWeights[4] = {0.125f, 0.375f, 0.375f, 0.125f};
  GuideLevel coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2);
  ParallelRows(coarse.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < coarse.width(); ++x) {
        float sum[kChannels] = {};
        for (int j = 0; j < 4; ++j) {
          const float* from = fine.At(2 * x - 1, 2 * y - 1 + j);
          for (int i = 0; i < 4; ++i) {
            for (int c = 0; c < kChannels; ++c) {
              sum[c] += kWeights[j] * kWeights[i] * from[i * kChannels + c];
            }
          }
        }
        std::copy_n(sum, kChannels, coarse.At(x, y));
      }
    }
  });
  coarse.FillBorder();
  return coarse;
}

}  // namespace

GuideLevel::GuideLevel(int width, int height)
    : width_(width),
      height_(height),
      values_(static_cast<size_t>(width + 2 * kBorder) * static_cast<size_t>(height + 2 * kBorder) *
              kChannels) {}

void GuideLevel::FillBorder() {
  for (int y = 0; y < height_; ++y) {
    for (int i = 1; i <= kBorder; ++i) {
      std::copy_n(At(0, y), kChannels, At(-i, y));
      std::copy_n(At(width_ - 1, y), kChannels, At(width_ - 1 + i, y));
    }
  }
  const auto row = static_cast<size_t>(stride());
  for (int i = 1; i <= kBorder; ++i) {
    std::copy_n(At(-kBorder, 0), row, At(-kBorder, -i));
    std::copy_n(At(-kBorder, height_ - 1), row, At(-kBorder, height_ - 1 + i));
  }
}

size_t GuidePyramid::bytes() const {
  size_t sum = sharp.bytes();
  for (const GuideLevel& level : levels) {
    sum += level.bytes();
  }
  return sum;
}

GuideLevel MakeLevel(const Guides& guides) {
  GuideLevel level(guides.depth.width(), guides.depth.height());
  FillFinest(guides, &level);
  return level;
}

GuidePyramid MakePyramid(GuideLevel sharp) {
  GuidePyramid pyramid;
  pyramid.sharp = std::move(sharp);
  pyramid.levels.push_back(Smoothed(pyramid.sharp));
  while (std::min(pyramid.levels.back().width(), pyramid.levels.back().height()) >=
         2 * kLeastSide) {
    GuideLevel coarse = Halved(pyramid.levels.back());
    pyramid.levels.push_back(std::move(coarse));
  }
  return pyramid;
}

float DistanceOf(const float* a, const float* b) {
  float sum = 0;
  for (int c = 0; c < kChannels; ++c) {
    sum += std::fabs(a[c] - b[c]);
  }
  return std::min(sum, kMostDistance);
}

float DistanceTo(const GuideLevel& now, int x, int y, const GuideLevel& before, float u, float v) {
  const bool inside = u >= 0.0f && v >= 0.0f && u <= static_cast<float>(before.width() - 1) &&
                      v <= static_cast<float>(before.height() - 1);
  if (!inside) {  // or NaN
    return kMostDistance;
  }
  const int left = static_cast<int>(u);
  const int top = static_cast<int>(v);
  const float* own = now.At(x, y);
  float least = kMostDistance;
  const int right = u > static_cast<float>(left) ? left + 1 : left;
  const int bottom = v > static_cast<float>(top) ? top + 1 : top;
  for (int py = top; py <= bottom; ++py) {
    for (int px = left; px <= right; ++px) {
      least = std::min(least, DistanceOf(own, before.At(px, py)));
    }
  }
  return least;
}

}  // namespace stillray::motion
