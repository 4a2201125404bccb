// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/fill_depth.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "core/guides.h"
#include "core/pixels.h"

namespace stillray::io {
namespace {

// Interpolated values of a pixel: inverse depth, normal, motion, albedo, specular albedo.
constexpr size_t kNormal = 1;
constexpr size_t kMotion = 4;
constexpr size_t kAlbedo = 6;
constexpr size_t kSpecularAlbedo = 9;
constexpr size_t kValues = 12;
using Values = std::array<float, kValues>;

/// The known values of one level of the pyramid, times their weight; unknown cells are zero until
/// the level is completed.
struct Level {
  explicit Level(int width, int height) : weight(width, height), id(width, height) {
    for (Image1& plane : value) {
      plane = Image1(width, height);
    }
  }
  int width() const { return weight.width(); }
  int height() const { return weight.height(); }

  Image1 weight;  ///< 0..1
  std::array<Image1, kValues> value;
  Plane<uint32_t> id;
};

bool IsKnown(const Guides& g, int x, int y) {
  const float depth = g.depth(x, y);
  const vec3 n = VectorAt(g.normal, x, y);
  const float length2 = dot(n, n);
  return depth > 0 && std::isfinite(depth) && length2 > 0 && std::isfinite(length2);
}

template <int N>
void Gather(const Planes<float, N>& planes, size_t first, int x, int y, Level* level) {
  for (int c = 0; c < N && !planes.empty(); ++c) {
    const float value = planes[c](x, y);
    level->value[first + static_cast<size_t>(c)](x, y) = std::isfinite(value) ? value : 0.0f;
  }
}

template <int N>
void Store(const Level& level, size_t first, int x, int y, Planes<float, N>* planes) {
  for (int c = 0; c < N && !planes->empty(); ++c) {
    (*planes)[c](x, y) = level.value[first + static_cast<size_t>(c)](x, y);
  }
}

Level KnownGuides(const Guides& g) {
  Level level(g.depth.width(), g.depth.height());
  ForEachPixel(level.width(), level.height(), [&](int x, int y) {
    if (!IsKnown(g, x, y)) {
      return;
    }
    level.weight(x, y) = 1;
    level.value[0](x, y) = 1 / g.depth(x, y);
    Gather(g.normal, kNormal, x, y, &level);
    Gather(g.motion, kMotion, x, y, &level);
    Gather(g.albedo, kAlbedo, x, y, &level);
    Gather(g.specular_albedo, kSpecularAlbedo, x, y, &level);
    level.id(x, y) = g.id.empty() ? 0 : g.id(x, y);
  });
  return level;
}

/// Each cell is the weighted mean of four.
Level HalfSize(const Level& fine) {
  Level coarse((fine.width() + 1) / 2, (fine.height() + 1) / 2);
  ForEachPixel(coarse.width(), coarse.height(), [&](int x, int y) {
    float weight = 0;
    Values sum = {};
    for (int v = 2 * y; v < std::min(2 * y + 2, fine.height()); ++v) {
      for (int u = 2 * x; u < std::min(2 * x + 2, fine.width()); ++u) {
        weight += fine.weight(u, v);
        for (size_t i = 0; i < kValues; ++i) {
          sum[i] += fine.value[i](u, v);
        }
        if (coarse.id(x, y) == 0) {
          coarse.id(x, y) = fine.id(u, v);
        }
      }
    }
    const float kept = std::min(weight, 1.0f);
    coarse.weight(x, y) = kept;
    for (size_t i = 0; i < kValues; ++i) {
      coarse.value[i](x, y) = weight > 0 ? sum[i] * (kept / weight) : 0.0f;
    }
  });
  return coarse;
}

/// A completed level, bilinearly interpolated at the centre of cell (x, y) of the next finer level.
Values Interpolate(const Level& coarse, int x, int y) {
  const float s = (static_cast<float>(x) - 0.5f) / 2;
  const float t = (static_cast<float>(y) - 0.5f) / 2;
  const auto x0 = static_cast<int>(std::floor(s));
  const auto y0 = static_cast<int>(std::floor(t));
  Values sum = {};
  for (int v = y0; v <= y0 + 1; ++v) {
    for (int u = x0; u <= x0 + 1; ++u) {
      const float w =
          (1 - std::fabs(s - static_cast<float>(u))) * (1 - std::fabs(t - static_cast<float>(v)));
      const int cu = std::clamp(u, 0, coarse.width() - 1);
      const int cv = std::clamp(v, 0, coarse.height() - 1);
      for (size_t i = 0; i < kValues; ++i) {
        sum[i] += w * coarse.value[i](cu, cv);
      }
    }
  }
  return sum;
}

/// Fills cells of low weight from the next coarser level, which is complete.
void Complete(const Level& coarse, Level* fine) {
  ForEachPixel(fine->width(), fine->height(), [&](int x, int y) {
    const float missing = 1 - fine->weight(x, y);
    if (!(missing > 0)) {
      return;
    }
    const Values from = Interpolate(coarse, x, y);
    for (size_t i = 0; i < kValues; ++i) {
      fine->value[i](x, y) += missing * from[i];
    }
    if (fine->id(x, y) == 0) {
      fine->id(x, y) = coarse.id(x / 2, y / 2);
    }
  });
}

/// The guides at every pixel; zeros if none are known.
Level InterpolateGuides(const Guides& guides) {
  std::vector<Level> levels;
  levels.push_back(KnownGuides(guides));
  while (levels.back().width() > 1 || levels.back().height() > 1) {
    levels.push_back(HalfSize(levels.back()));
  }
  for (size_t i = levels.size() - 1; i-- > 0;) {
    Complete(levels[i + 1], &levels[i]);
  }
  return std::move(levels.front());
}

bool IsLit(const Image3& light, int x, int y) {
  return !light.empty() && (light[0](x, y) > 0 || light[1](x, y) > 0 || light[2](x, y) > 0);
}

bool HasFilteredLight(const Frame& frame, int x, int y) {
  return std::any_of(frame.signals.begin(), frame.signals.end(),
                     [&](const Signal& signal) { return IsLit(signal.radiance, x, y); });
}

// The content of a pixel without depth.
enum : uint8_t {
  kDark,  ///< neither background nor signals
  kBackground,
  kLight,
  kVolume,   ///< radiance, but no sample hit a surface
  kSurface,  ///< it has a depth
};

uint8_t WhatIsSeen(const Frame& frame, int x, int y) {
  if (frame.guides.depth(x, y) != std::numeric_limits<float>::infinity()) {
    return kSurface;
  }
  if (HasFilteredLight(frame, x, y)) {
    const vec3 normal = VectorAt(frame.guides.normal, x, y);
    return dot(normal, normal) > 0 ? kLight : kVolume;
  }
  return IsLit(frame.emission, x, y) || IsLit(frame.background, x, y) ? kBackground : kDark;
}

/// Counts the pixels that show `what` up to `radius` pixels away, the pixel itself included.
int CountAround(const Plane<uint8_t>& seen, uint8_t what, int radius, int x, int y) {
  int count = 0;
  for (int v = std::max(y - radius, 0); v <= std::min(y + radius, seen.height() - 1); ++v) {
    for (int u = std::max(x - radius, 0); u <= std::min(x + radius, seen.width() - 1); ++u) {
      count += seen(u, v) == what ? 1 : 0;
    }
  }
  return count;
}

/// Whether a pixel without radiance belongs to a volume, judged by its neighbours.
bool IsSampleOfVolume(const Plane<uint8_t>& seen, int x, int y) {
  constexpr int kMostAround = 6;
  const uint8_t what = seen(x, y);
  if (what != kDark && what != kBackground) {
    return false;
  }
  return CountAround(seen, kVolume, 2, x, y) > 0 ||
         (what == kDark && CountAround(seen, kSurface, 1, x, y) >= kMostAround);
}

void Normalise(int x, int y, Image3* normal) {
  const vec3 n = VectorAt(*normal, x, y);
  const float length = std::sqrt(dot(n, n));
  for (int c = 0; c < 3; ++c) {
    (*normal)[c](x, y) = length > 0 ? n[c] / length : (c == 2 ? 1.0f : 0.0f);
  }
}

}  // namespace

bool IsPartlyTransparent(const Image1& alpha) {
  std::atomic<bool> any = false;
  ParallelRows(alpha.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1 && !any; ++y) {
      const float* row = alpha.Row(y);
      if (std::any_of(row, row + alpha.width(), [](float a) { return a < 1; })) {
        any = true;
      }
    }
  });
  return any;
}

Plane<uint8_t> FindCoveredWithoutDepth(const Frame& frame, const Image1& alpha) {
  const bool by_alpha = IsPartlyTransparent(alpha);
  Plane<uint8_t> seen(frame.width, frame.height);
  ForEachPixel(frame.width, frame.height,
               [&](int x, int y) { seen(x, y) = WhatIsSeen(frame, x, y); });
  const bool any_volume = AnyPixel(seen, [](uint8_t what) { return what == kVolume; });
  Plane<uint8_t> marked(frame.width, frame.height);
  std::atomic<bool> any = false;
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const uint8_t what = seen(x, y);
    const bool has_light = what == kLight || what == kVolume;
    const bool is_covered = what != kSurface && by_alpha && alpha(x, y) > 0;
    const bool any_of_them =
        has_light || is_covered || (any_volume && IsSampleOfVolume(seen, x, y));
    marked(x, y) = any_of_them ? 1 : 0;
    if (any_of_them) {
      any = true;
    }
  });
  return any ? std::move(marked) : Plane<uint8_t>();
}

Image3 TakeBackground(const Plane<uint8_t>& without_depth, const Image3& volume,
                      const Image3& normal, Image3* background) {
  Image3 taken(background->width(), background->height());
  ForEachPixel(background->width(), background->height(), [&](int x, int y) {
    const vec3 n = VectorAt(normal, x, y);
    if (without_depth(x, y) == 0 || (dot(n, n) > 0 && !IsLit(volume, x, y))) {
      return;
    }
    for (int c = 0; c < 3; ++c) {
      taken[c](x, y) = (*background)[c](x, y);
      (*background)[c](x, y) = 0;
    }
  });
  return taken;
}

void DivideByHits(const Image3& volume, const Image3& stored_normal, Image3* albedo) {
  ForEachPixel(albedo->width(), albedo->height(), [&](int x, int y) {
    const vec3 n = VectorAt(stored_normal, x, y);
    const float hits = std::sqrt(dot(n, n));
    if (!IsLit(volume, x, y) || !(hits > 0 && hits < 1)) {
      return;
    }
    for (int c = 0; c < 3; ++c) {
      float& a = (*albedo)[c](x, y);
      a = std::max(std::min(a / hits, 1.0f), a);
    }
  });
}

void FillDepth(const Plane<uint8_t>& marked, Guides* guides) {
  const Level filled = InterpolateGuides(*guides);
  const bool none_known = !(filled.value[0](0, 0) > 0);
  ForEachPixel(marked.width(), marked.height(), [&](int x, int y) {
    if (marked(x, y) == 0) {
      return;
    }
    guides->depth(x, y) = none_known ? 1.0f : 1 / filled.value[0](x, y);
    if (!guides->id.empty()) {
      guides->id(x, y) = filled.id(x, y);
    }
    const vec3 own = VectorAt(guides->normal, x, y);
    if (dot(own, own) > 0) {
      return;  // some samples hit a surface: the other guides are means over them
    }
    Store(filled, kNormal, x, y, &guides->normal);
    Normalise(x, y, &guides->normal);
    Store(filled, kMotion, x, y, &guides->motion);
    Store(filled, kAlbedo, x, y, &guides->albedo);
    Store(filled, kSpecularAlbedo, x, y, &guides->specular_albedo);
  });
}

}  // namespace stillray::io
