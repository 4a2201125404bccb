// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/seen_curved.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace stillray::io {
namespace {

constexpr int kFewestPixels = 32;
/// Minimum fraction of a patch's pixels around which the virtual image is smooth. Measured: metal
/// of roughness 0.2 has at most 0.07 (1 to 16 samples), chrome at least 0.24, glass balls 0.38, a
/// glass head, which is better without virtual guides, 0.07 to 0.23.
constexpr float kLeastSmoothOfMirrors = 0.12f;
constexpr float kLeastSmoothOfGlass = 0.3f;

/// Seen depths of four consecutive pixels, and whether they are of one surface.
struct DepthRun {
  std::array<float, 4> depth{};
  bool is_complete = false;
  bool is_aligned = false;
};

DepthRun RunAt(const Seen& seen, const Patches& patches, int x, int y, int dx, int dy) {
  DepthRun run;
  run.is_complete = run.is_aligned = true;
  for (int i = 0; i < 4; ++i) {
    const int u = x + (i - 1) * dx;
    const int v = y + (i - 1) * dy;
    if (!IsInside(seen.depth, u, v) || patches.Of(u, v) != patches.Of(x, y) ||
        !(seen.depth(u, v) > 0)) {
      run.is_complete = false;
      return run;
    }
    run.depth[static_cast<size_t>(i)] = seen.depth(u, v);
    run.is_aligned = run.is_aligned &&
                     dot(VectorAt(seen.normal, u, v), VectorAt(seen.normal, x, y)) > kSeenCosine;
  }
  return run;
}

bool IsSmooth(const DepthRun& run) {
  constexpr float kPrecision = 0.002f;  // layers are halves
  constexpr float kLargestChange = 0.3f;
  const auto& d = run.depth;
  if (std::all_of(d.begin(), d.end(), [](float depth) { return std::isinf(depth); })) {
    return true;
  }
  const float second = d[0] + d[2] - 2 * d[1];
  const float next = d[1] + d[3] - 2 * d[2];
  return run.is_aligned &&
         std::abs(next - second) <
             std::max(kPrecision * d[1], kLargestChange * std::abs(next + second));
}

/// Number of directions in which the virtual image around a pixel is smooth; -1 if few are known.
int SmoothDirections(const Seen& seen, const Patches& patches, int x, int y) {
  constexpr int kDirections[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  constexpr int kFewest = 3;
  int known = 0;
  int smooth = 0;
  for (const auto& [dx, dy] : kDirections) {
    const DepthRun run = RunAt(seen, patches, x, y, dx, dy);
    known += run.is_complete ? 1 : 0;
    smooth += run.is_complete && IsSmooth(run) ? 1 : 0;
  }
  return known >= kFewest ? smooth : -1;
}

struct CurvedCounts {
  int pixels = 0;
  int known = 0;
  int smooth = 0;
  double reflected = 0;
  double refracted = 0;
};

bool IsOnOutline(const Guides& g, int x, int y) {
  return std::any_of(
      std::begin(kNeighbourOffsets), std::end(kNeighbourOffsets), [&](const int(&d)[2]) {
        return IsInside(g.depth, x + d[0], y + d[1]) && !OnSameCurve(g, x, y, x + d[0], y + d[1]);
      });
}

bool IsSupported(const Seen& seen, const Patches& patches, bool refracted, int x, int y) {
  constexpr int kFewestInGlass = 3;
  const Support support = SupportOf(seen, patches, x, y);
  return refracted ? support.same >= kFewestInGlass && 2 * support.same >= support.known
                   : support.same > 0;
}

constexpr int32_t kNone = -1;     ///< the pixel has no virtual image
constexpr int32_t kUnknown = -2;  ///< the source is not yet determined

bool HasSource(const Patches& patches, const Plane<int32_t>& sources, int x, int y, int u, int v) {
  return u >= 0 && v >= 0 && u < sources.width() && v < sources.height() &&
         patches.Of(u, v) == patches.Of(x, y) && sources(u, v) >= 0;
}

/// Number of neighbours of a pixel with the seen surface of pixel `candidate`.
int Votes(const Seen& seen, const Patches& patches, const Plane<int32_t>& sources, int x, int y,
          int32_t candidate) {
  const int width = sources.width();
  int votes = 0;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    if (HasSource(patches, sources, x, y, x + dx, y + dy)) {
      const int32_t other = sources(x + dx, y + dy);
      votes += SeesSame(seen, candidate % width, candidate / width, other % width, other / width);
    }
  }
  return votes;
}

/// The source among those of the neighbours with which most neighbours agree, or kUnknown.
int32_t CommonSource(const Seen& seen, const Patches& patches, const Plane<int32_t>& sources, int x,
                     int y) {
  int32_t best = kUnknown;
  int most = 0;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    if (HasSource(patches, sources, x, y, x + dx, y + dy)) {
      const int32_t candidate = sources(x + dx, y + dy);
      const int votes = Votes(seen, patches, sources, x, y, candidate);
      best = votes > most ? candidate : best;
      most = std::max(votes, most);
    }
  }
  return best;
}

}  // namespace

std::vector<PatchKind> CurvedKinds(const Frame& frame, const Patches& patches, SeenLobes lobes,
                                   Seen* seen) {
  const Guides& g = frame.guides;
  std::vector<CurvedCounts> counts(patches.count());
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, CurvedCounts& c) {
    ++c.pixels;
    c.reflected += static_cast<double>(SumAt(g.specular_albedo, x, y));
    c.refracted += static_cast<double>(SumAt(g.transmission_albedo, x, y));
  });
  std::vector<PatchKind> kinds;
  kinds.reserve(counts.size());
  for (const CurvedCounts& c : counts) {
    kinds.push_back(
        {c.pixels >= kFewestPixels, lobes == SeenLobes::kEither && c.refracted > c.reflected});
  }
  if (lobes == SeenLobes::kEither) {
    DropOtherLobes(frame, patches, kinds, seen);
  }
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, CurvedCounts& c) {
    if (c.pixels >= kFewestPixels && seen->depth(x, y) > 0) {
      constexpr int kMost = 3;
      const int smooth = SmoothDirections(*seen, patches, x, y);
      c.known += smooth >= 0 ? 1 : 0;
      c.smooth += smooth >= kMost ? 1 : 0;
    }
  });
  for (size_t i = 0; i < counts.size(); ++i) {
    const float least = kinds[i].refracted ? kLeastSmoothOfGlass : kLeastSmoothOfMirrors;
    kinds[i].shows_image =
        counts[i].smooth >= kFewestPixels &&
        static_cast<float>(counts[i].smooth) >= least * static_cast<float>(counts[i].known);
  }
  return kinds;
}

Plane<int32_t> CurvedSources(const Seen& seen, const Guides& g, const Patches& patches,
                             const std::vector<PatchKind>& kinds) {
  constexpr int kPasses = 3;
  const int width = seen.depth.width();
  Plane<int32_t> sources(width, seen.depth.height());
  ForEachPixel(width, seen.depth.height(), [&](int x, int y) {
    const int32_t patch = patches.Of(x, y);
    const PatchKind kind = patch < 0 ? PatchKind() : kinds[static_cast<size_t>(patch)];
    if (!kind.shows_image || (kind.refracted && IsOnOutline(g, x, y))) {
      sources(x, y) = kNone;
    } else if (seen.depth(x, y) > 0 && IsSupported(seen, patches, kind.refracted, x, y)) {
      sources(x, y) = y * width + x;
    } else {
      sources(x, y) = kUnknown;
    }
  });
  for (int pass = 0; pass < kPasses; ++pass) {
    const Plane<int32_t> last = sources;
    ForEachPixel(width, last.height(), [&](int x, int y) {
      if (last(x, y) == kUnknown) {
        sources(x, y) = CommonSource(seen, patches, last, x, y);
      }
    });
  }
  return sources;
}

}  // namespace stillray::io
