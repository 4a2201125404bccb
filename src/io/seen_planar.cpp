// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/seen_planar.h"

#include <algorithm>
#include <cmath>

namespace stillray::io {
namespace {

/// Minimum cosine of normals of one plane, in the precision of halves.
constexpr float kFlatCosine = 0.9999f;
/// Minimum fraction of a patch's pixels that lie on its plane, and agree with their neighbours.
constexpr float kLeastPlanar = 0.8f;
constexpr float kLeastCoherent = 0.8f;
constexpr int kLeastPixels = 32;

/// The neighbour on the same patch that agrees with most of its own neighbours, at least `least`.
/// (-1, -1) if there is none.
ivec2 CommonNeighbour(const Seen& seen, const Patches& patches, int x, int y, int least) {
  ivec2 best = {-1, -1};
  int most = least - 1;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    const int u = x + dx;
    const int v = y + dy;
    if (IsInside(seen.depth, u, v) && patches.Of(u, v) == patches.Of(x, y)) {
      const int same = SupportOf(seen, patches, u, v).same;
      best = same > most ? ivec2(u, v) : best;
      most = std::max(same, most);
    }
  }
  return best;
}

/// Neighbours of a pixel with the same seen surface as `other`.
int Agreement(const Seen& seen, int x, int y, ivec2 other) {
  int same = 0;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    const int u = x + dx;
    const int v = y + dy;
    same += IsInside(seen.depth, u, v) && SeesSame(seen, other.x, other.y, u, v) ? 1 : 0;
  }
  return same;
}

/// Whether the seen albedos of two pixels agree.
bool SeesColour(const Seen& seen, int x, int y, int u, int v) {
  constexpr float kOtherColour = 0.15f;
  const vec3 a = VectorAt(seen.albedo, x, y);
  const vec3 b = VectorAt(seen.albedo, u, v);
  const vec3 difference = glm::abs(a - b);
  return difference.x + difference.y + difference.z <=
         kOtherColour * (glm::length(a) + glm::length(b));
}

/// A neighbour whose seen albedo agrees with nearly all neighbours, but not with the pixel; (-1,
/// -1) if there is none. A tiled floor reflected by a pane coincides, in unfolded space, with the
/// floor behind the pane, but with other tiles.
ivec2 NeighbourOfOtherColour(const Seen& seen, int x, int y) {
  constexpr int kNearlyAll = 6;
  const auto is_same = [&](int x0, int y0, int u, int v) {
    return IsInside(seen.depth, u, v) && SeesSame(seen, x0, y0, u, v) &&
           SeesColour(seen, x0, y0, u, v);
  };
  for (const auto& [i, j] : kNeighbourOffsets) {
    const int u = x + i;
    const int v = y + j;
    if (!IsInside(seen.depth, u, v) || !SeesSame(seen, x, y, u, v) ||
        SeesColour(seen, x, y, u, v)) {
      continue;
    }
    int count = 0;
    for (const auto& [dx, dy] : kNeighbourOffsets) {
      count += is_same(u, v, x + dx, y + dy) ? 1 : 0;
    }
    if (count >= kNearlyAll) {
      return {u, v};
    }
  }
  return {-1, -1};
}

struct PatchCounts {
  int pixels = 0;
  int coherent = 0;
  double reflected = 0;
  double refracted = 0;
};

struct PlaneCounts {
  int pixels = 0;
  int planar = 0;
  glm::dvec3 normal{0.0};  ///< sum
};

}  // namespace

ivec2 PlanarSource(const Seen& seen, const Patches& patches, bool other_lobe, int x, int y) {
  constexpr int kAlone = 1;
  constexpr int kMost = 4;
  constexpr int kAgreed = 6;
  if (other_lobe) {
    return CommonNeighbour(seen, patches, x, y, 1);
  }
  if (SupportOf(seen, patches, x, y).same > kAlone) {
    const ivec2 other = NeighbourOfOtherColour(seen, x, y);
    return other.x >= 0 ? other : ivec2(x, y);
  }
  const ivec2 source = CommonNeighbour(seen, patches, x, y, kMost);
  // At edges the seen surface of a pixel without guides, as in glass within a mirror, is unknown.
  const bool unknown =
      seen.depth(x, y) == 0 && source.x >= 0 && Agreement(seen, x, y, source) < kAgreed;
  return unknown ? ivec2(-1, -1) : source;
}

std::vector<uint8_t> ArePlanar(const Patches& patches, const Guides& g) {
  std::vector<PlaneCounts> counts(patches.count());
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, PlaneCounts& c) {
    ++c.pixels;
    c.normal += glm::dvec3(VectorAt(g.normal, x, y));
  });
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, PlaneCounts& c) {
    const glm::dvec3 normal(VectorAt(g.normal, x, y));
    c.planar +=
        glm::dot(normal, c.normal) > static_cast<double>(kFlatCosine) * glm::length(c.normal);
  });
  std::vector<uint8_t> planar;
  planar.reserve(counts.size());
  for (const PlaneCounts& c : counts) {
    const bool most = static_cast<float>(c.planar) >= kLeastPlanar * static_cast<float>(c.pixels);
    planar.push_back(c.pixels >= kLeastPixels && most ? 1 : 0);
  }
  return planar;
}

std::vector<PatchKind> PlanarKinds(const Seen& seen, const Patches& patches, const Guides& g,
                                   SeenLobes lobes) {
  std::vector<PatchCounts> counts(patches.count());
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, PatchCounts& c) {
    const Support support = SupportOf(seen, patches, x, y);
    ++c.pixels;
    c.coherent += support.neighbours > 0 && 2 * support.same >= support.neighbours;
    c.reflected += static_cast<double>(SumAt(g.specular_albedo, x, y));
    c.refracted += static_cast<double>(SumAt(g.transmission_albedo, x, y));
  });
  const std::vector<uint8_t> planar = ArePlanar(patches, g);
  std::vector<PatchKind> kinds;
  kinds.reserve(counts.size());
  for (size_t i = 0; i < counts.size(); ++i) {
    const PatchCounts& c = counts[i];
    const bool coherent =
        static_cast<float>(c.coherent) >= kLeastCoherent * static_cast<float>(c.pixels);
    kinds.push_back(
        {planar[i] != 0 && coherent, lobes == SeenLobes::kEither && c.refracted > c.reflected});
  }
  return kinds;
}

}  // namespace stillray::io
