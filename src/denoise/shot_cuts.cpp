// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/shot_cuts.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/parallel.h"

namespace stillray {
namespace {

// The tolerances are large: frames are up to 1/24 s apart, guides may be noisy, and a missed cut
// costs less than a needlessly discarded history.
constexpr float kDepthTolerance = 0.1f;  ///< as a fraction of the depth
constexpr float kMinCosine = 0.7f;       ///< between normals
constexpr float kAlbedoTolerance = 0.1f;

/// Least agreement between two frames of one shot; see IsCut().
constexpr double kLeastOfSurfaces = 0.1;
constexpr double kLeastOfInside = 0.2;

bool SameDepth(const Guides& a, int x, int y, const Guides& b, int u, int v) {
  const float za = a.depth(x, y);
  const float zb = b.depth(u, v);
  return std::fabs(za - zb) <= kDepthTolerance * std::max(za, zb);
}

bool SameNormal(const Guides& a, int x, int y, const Guides& b, int u, int v) {
  float dot = 0;
  float aa = 0;
  float bb = 0;
  for (int c = 0; c < 3; ++c) {
    dot += a.normal[c](x, y) * b.normal[c](u, v);
    aa += a.normal[c](x, y) * a.normal[c](x, y);
    bb += b.normal[c](u, v) * b.normal[c](u, v);
  }
  return dot >= kMinCosine * std::sqrt(aa * bb);
}

bool SameAlbedo(const Guides& a, int x, int y, const Guides& b, int u, int v) {
  if (a.albedo.empty() || b.albedo.empty()) {
    return true;
  }
  for (int c = 0; c < 3; ++c) {
    if (!(std::fabs(a.albedo[c](x, y) - b.albedo[c](u, v)) <= kAlbedoTolerance)) {
      return false;
    }
  }
  return true;
}

bool SameSurface(const Guides& a, int x, int y, const Guides& b, int u, int v) {
  const bool ids = !a.id.empty() && !b.id.empty();
  return SameDepth(a, x, y, b, u, v) && SameNormal(a, x, y, b, u, v) &&
         SameAlbedo(a, x, y, b, u, v) && (!ids || a.id(x, y) == b.id(u, v));
}

/// Whether one of the four pixels around the position shows the surface.
bool IsThere(const Guides& now, int x, int y, const Guides& before, int u0, int v0) {
  for (int i = 0; i < 4; ++i) {
    const int u = u0 + (i & 1);
    const int v = v0 + (i >> 1);
    if (u >= 0 && v >= 0 && u < before.depth.width() && v < before.depth.height() &&
        SameSurface(now, x, y, before, u, v)) {
      return true;
    }
  }
  return false;
}

struct Counts {
  int64_t surfaces = 0;
  int64_t inside = 0;
  int64_t found = 0;
};

Counts CountRow(const Frame& now, const Guides& before, int y) {
  Counts counts;
  const Guides& g = now.guides;
  for (int x = 0; x < now.width; ++x) {
    if (!std::isfinite(g.depth(x, y))) {
      continue;
    }
    ++counts.surfaces;
    const float u = std::floor(static_cast<float>(x) + g.motion[0](x, y));
    const float v = std::floor(static_cast<float>(y) + g.motion[1](x, y));
    // Also false for NaN.
    if (u >= -1 && v >= -1 && u < static_cast<float>(now.width) &&
        v < static_cast<float>(now.height)) {
      ++counts.inside;
      counts.found += IsThere(g, x, y, before, static_cast<int>(u), static_cast<int>(v));
    }
  }
  return counts;
}

double Part(int64_t part, int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

Agreement FindAgain(const Frame& now, const Guides& before) {
  std::vector<Counts> rows(static_cast<size_t>(now.height));
  ParallelRows(now.height, 8, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      rows[static_cast<size_t>(y)] = CountRow(now, before, y);
    }
  });
  Counts sum;
  for (const Counts& row : rows) {
    sum.surfaces += row.surfaces;
    sum.inside += row.inside;
    sum.found += row.found;
  }
  Agreement agreement;
  if (sum.surfaces > 0) {
    agreement.of_surfaces = Part(sum.found, sum.surfaces);
  }
  if (sum.inside > 0) {
    agreement.of_inside = Part(sum.found, sum.inside);
  }
  return agreement;
}

bool IsCut(const Agreement& agreement) {
  return agreement.of_surfaces < kLeastOfSurfaces || agreement.of_inside < kLeastOfInside;
}

}  // namespace stillray
