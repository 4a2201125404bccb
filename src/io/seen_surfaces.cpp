// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/seen_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace stillray::io {
namespace {

float LightAt(const Frame& frame, SignalKind direct, SignalKind indirect, int x, int y) {
  float sum = 0;
  for (const Signal& signal : frame.signals) {
    sum += signal.kind == direct || signal.kind == indirect ? SumAt(signal.radiance, x, y) : 0.0f;
  }
  return sum;
}

/// Smaller albedos belong to the mirror's edge, or are noise.
constexpr float kLeastAlbedo = 0.02f;

}  // namespace

vec3 SeenAlbedoAt(const Image3& albedo, const Image3& mirror, vec3 light, int x, int y) {
  vec3 seen = VectorAt(albedo, x, y);
  for (int c = 0; c < 3; ++c) {
    const float colour = mirror.empty() ? 1.0f : std::max(mirror[c](x, y), kLeastAlbedo);
    const float value = seen[c] / colour;
    const float most = std::max(light[c] / colour, 1.0f);
    seen[c] = std::isfinite(value) ? std::clamp(value, kLeastAlbedo, most) : 1.0f;
  }
  return seen;
}

vec3 SeenNormal(vec3 normal, vec3 albedo) {
  constexpr float kLamp = 3;
  return std::max({albedo.x, albedo.y, albedo.z}) > kLamp ? -normal : normal;
}

vec3 ReflectedLightAt(const Frame& frame, int x, int y) {
  vec3 light(0.0f);
  for (const Signal& signal : frame.signals) {
    const bool reflected =
        signal.kind == SignalKind::kDirectSpecular || signal.kind == SignalKind::kIndirectSpecular;
    light += reflected && !signal.radiance.empty() ? VectorAt(signal.radiance, x, y) : vec3(0.0f);
  }
  return light;
}

bool SeesSame(const Seen& seen, int x, int y, int u, int v) {
  constexpr float kDepth = 0.03f;
  const float a = seen.depth(x, y);
  const float b = seen.depth(u, v);
  if (std::isinf(a) || std::isinf(b)) {
    return std::isinf(a) && std::isinf(b);
  }
  return a > 0 && std::abs(a - b) < kDepth * a &&
         dot(VectorAt(seen.normal, x, y), VectorAt(seen.normal, u, v)) > kSeenCosine;
}

bool OnSameSurface(const Guides& g, int x, int y, int u, int v, float depth, float cosine) {
  const float a = g.depth(x, y);
  const float b = g.depth(u, v);
  const bool same_id = g.id.empty() || g.id(x, y) == g.id(u, v);
  return same_id && std::abs(a - b) < depth * a &&
         dot(VectorAt(g.normal, x, y), VectorAt(g.normal, u, v)) > cosine;
}

bool OnSamePlane(const Guides& g, int x, int y, int u, int v) {
  constexpr float kDepth = 0.02f;
  constexpr float kCosine = 0.9999f;  // normals have the precision of halves
  return OnSameSurface(g, x, y, u, v, kDepth, kCosine);
}

bool OnSameCurve(const Guides& g, int x, int y, int u, int v) {
  constexpr float kDepth = 0.1f;
  constexpr float kCosine = 0.5f;
  return OnSameSurface(g, x, y, u, v, kDepth, kCosine);
}

Patches::Patches(const Guides& g, const Image1& seen, SameSurface same)
    : same_(same),
      width_(g.depth.width()),
      height_(g.depth.height()),
      patch_(static_cast<size_t>(width_) * static_cast<size_t>(height_)) {
  Join(g, seen);
  Number(seen);
  FillGaps(g);
}

int32_t Patches::Root(int32_t i) {
  while (patch_[static_cast<size_t>(i)] != i) {
    auto& parent = patch_[static_cast<size_t>(i)];
    parent = patch_[static_cast<size_t>(parent)];
    i = parent;
  }
  return i;
}

/// Union-find over the left and upper neighbours.
void Patches::Join(const Guides& g, const Image1& seen) {
  std::iota(patch_.begin(), patch_.end(), 0);
  const auto join = [&](int x, int y, int u, int v) {
    if (seen(u, v) > 0 && same_(g, x, y, u, v)) {
      const int32_t a = Root(static_cast<int32_t>(Index(x, y)));
      const int32_t b = Root(static_cast<int32_t>(Index(u, v)));
      patch_[static_cast<size_t>(std::max(a, b))] = std::min(a, b);
    }
  };
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (seen(x, y) > 0 && x > 0) {
        join(x, y, x - 1, y);
      }
      if (seen(x, y) > 0 && y > 0) {
        join(x, y, x, y - 1);
      }
    }
  }
}

/// Numbers the sets from 0. Roots precede the other pixels of their sets.
void Patches::Number(const Image1& seen) {
  std::vector<int32_t> number(patch_.size(), -1);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const size_t i = Index(x, y);
      if (!(seen(x, y) > 0)) {
        patch_[i] = -1;
        continue;
      }
      const int32_t root = Root(static_cast<int32_t>(i));
      number[i] = root == static_cast<int32_t>(i) ? static_cast<int32_t>(count_++)
                                                  : number[static_cast<size_t>(root)];
    }
  }
  patch_ = std::move(number);
}

/// A pixel without a valid seen surface belongs to the patch that surrounds it.
void Patches::FillGaps(const Guides& g) {
  constexpr int kMost = 5;
  std::vector<int32_t> filled = patch_;
  ForEachPixel(width_, height_, [&](int x, int y) {
    if (Of(x, y) >= 0) {
      return;
    }
    int32_t patch = -1;
    int votes = 0;  // pixels of the patch minus pixels of others (Boyer-Moore majority vote)
    for (const auto& [dx, dy] : kNeighbourOffsets) {
      const int u = x + dx;
      const int v = y + dy;
      if (IsInside(g.depth, u, v) && Of(u, v) >= 0 && same_(g, x, y, u, v)) {
        patch = votes == 0 ? Of(u, v) : patch;
        votes += Of(u, v) == patch ? 1 : -1;
      }
    }
    if (votes >= kMost) {
      filled[Index(x, y)] = patch;
    }
  });
  patch_ = std::move(filled);
}

Support SupportOf(const Seen& seen, const Patches& patches, int x, int y) {
  Support support;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    const int u = x + dx;
    const int v = y + dy;
    if (IsInside(seen.depth, u, v) && patches.Of(u, v) == patches.Of(x, y)) {
      ++support.neighbours;
      support.known += seen.depth(u, v) > 0 ? 1 : 0;
      support.same += SeesSame(seen, x, y, u, v) ? 1 : 0;
    }
  }
  return support;
}

Plane<uint8_t> DropOtherLobes(const Frame& frame, const Patches& patches,
                              const std::vector<PatchKind>& kinds, Seen* seen) {
  Plane<uint8_t> dropped(frame.width, frame.height);
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const int32_t patch = patches.Of(x, y);
    if (patch < 0 || !kinds[static_cast<size_t>(patch)].shows_image) {
      return;
    }
    const float reflected =
        LightAt(frame, SignalKind::kDirectSpecular, SignalKind::kIndirectSpecular, x, y);
    const float refracted =
        LightAt(frame, SignalKind::kDirectTransmission, SignalKind::kIndirectTransmission, x, y);
    const bool through = kinds[static_cast<size_t>(patch)].refracted;
    const float own = through ? refracted : reflected;
    const float other = through ? reflected : refracted;
    if (other > 0 && !(own > 0)) {
      dropped(x, y) = 1;
      seen->depth(x, y) = 0;
    }
  });
  return dropped;
}

}  // namespace stillray::io
