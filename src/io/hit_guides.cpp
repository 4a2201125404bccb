// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/hit_guides.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <glm/mat2x2.hpp>

#include "core/cameras.h"
#include "core/guides.h"
#include "core/pixels.h"
#include "io/seen_curved.h"
#include "io/seen_guides.h"
#include "io/seen_planar.h"
#include "io/seen_surfaces.h"

namespace stillray::io {
namespace {

/// Maximum relative difference of the depths of both layers.
constexpr float kSameImage = 0.05f;

/// View-space z of the virtual image at each pixel; 0 where there is none.
Image1 ImageDepth(const Image1& hits, const Lens& lens, const Image1& depth) {
  Image1 images(depth.width(), depth.height());
  ForEachPixel(depth.width(), depth.height(), [&](int x, int y) {
    const float z = depth(x, y);
    const float hit = hits(x, y);
    if (!IsSurface(z) || !(hit > 0)) {
      return;
    }
    const double cosine = lens.Cosine(PixelPoint(depth, x, y));
    images(x, y) =
        std::isinf(hit)
            ? hit
            : static_cast<float>(static_cast<double>(z) + static_cast<double>(hit) * cosine);
  });
  return images;
}

/// Guides of the reflected surface: normal and albedo from the kSeen layers, where they are given
/// and describe the same virtual image.
class Reflected {
 public:
  Reflected(const HitLayers& layers, const Image1& images, const Frame& frame)
      : layers_(layers), images_(images), frame_(frame) {
    const Guides& g = frame.guides;
    if (!layers.seen_depth.empty()) {
      seen_lens_ = FitLens(g.depth, layers.seen_depth);
    }
    if (!layers.seen_normal.empty()) {
      Image3 own = g.normal;
      ForEachPixel(own.width(), own.height(), [&](int x, int y) {
        for (int c = 0; c < 3 && images(x, y) > 0; ++c) {
          own[c](x, y) = 0;
        }
      });
      to_world_ = FitToWorld(own, layers.seen_normal);
    }
  }

  /// Whether the kSeen layers describe the pixel's virtual image.
  bool IsSeen(int x, int y) const {
    if (layers_.seen_depth.empty()) {
      return true;
    }
    const float image = images_(x, y);
    const float distance = layers_.seen_depth(x, y);
    if (distance == 0 || std::isinf(image)) {
      return distance == 0 && std::isinf(image);
    }
    return seen_lens_ &&
           std::abs(seen_lens_->DepthOf(static_cast<double>(distance), PixelPoint(images_, x, y)) -
                    static_cast<double>(image)) < static_cast<double>(kSameImage * image);
  }

  vec3 NormalAt(int x, int y) const {
    const vec3 mirror = VectorAt(frame_.guides.normal, x, y);
    if (!to_world_ || !IsSeen(x, y)) {
      return mirror;
    }
    const vec3 normal = *to_world_ * VectorAt(layers_.seen_normal, x, y);
    const float length = glm::length(normal);
    return length > 0.5f && length < 2.0f ? normal / length : mirror;
  }

  vec3 AlbedoAt(int x, int y) const {
    return layers_.seen_albedo.empty() || !IsSeen(x, y)
               ? vec3(1.0f)
               : SeenAlbedoAt(layers_.seen_albedo, frame_.guides.specular_albedo,
                              ReflectedLightAt(frame_, x, y), x, y);
  }

 private:
  const HitLayers& layers_;
  const Image1& images_;
  const Frame& frame_;
  std::optional<Lens> seen_lens_;
  std::optional<mat3> to_world_;
};

/// For each pixel, the pixel whose virtual image it takes, y * width + x, or -1; and the kind of
/// its motion.
struct Sources {
  Plane<int32_t> pixel;
  Plane<uint8_t> kind;

  void Set(int x, int y, int32_t from, ImageKind how) {
    pixel(x, y) = from;
    kind(x, y) = static_cast<uint8_t>(how);
  }
};

Sources NoSources(int width, int height) {
  Sources sources = {Plane<int32_t>(width, height), Plane<uint8_t>(width, height)};
  ForEachPixel(width, height, [&](int x, int y) { sources.pixel(x, y) = -1; });
  return sources;
}

/// With roughness: every pixel takes its own virtual image.
Sources SourcesByRoughness(const Seen& seen, const Guides& g) {
  const int width = g.depth.width();
  Sources sources = NoSources(width, g.depth.height());
  const Patches patches(g, seen.depth, OnSamePlane);
  const std::vector<uint8_t> planar = ArePlanar(patches, g);
  ForEachPixel(width, g.depth.height(), [&](int x, int y) {
    const int32_t patch = patches.Of(x, y);
    if (seen.depth(x, y) > 0 && patch >= 0) {
      sources.Set(
          x, y, y * width + x,
          planar[static_cast<size_t>(patch)] != 0 ? ImageKind::kPlanar : ImageKind::kReflected);
    }
  });
  return sources;
}

/// Without roughness, where neighbours agree: in planar mirrors, then in curved mirrors.
Sources SourcesByNeighbours(Seen seen, const Frame& frame) {
  const Guides& g = frame.guides;
  const int width = frame.width;
  Sources sources = NoSources(width, frame.height);
  const Patches planes(g, seen.depth, OnSamePlane);
  const std::vector<PatchKind> flat = PlanarKinds(seen, planes, g, SeenLobes::kReflected);
  Plane<uint8_t> taken(width, frame.height);
  ForEachPixel(width, frame.height, [&](int x, int y) {
    const int32_t patch = planes.Of(x, y);
    if (patch < 0 || !flat[static_cast<size_t>(patch)].shows_image) {
      return;
    }
    taken(x, y) = 1;
    const ivec2 from = PlanarSource(seen, planes, false, x, y);
    if (from.x >= 0) {
      sources.Set(x, y, from.y * width + from.x, ImageKind::kPlanar);
    }
  });
  ForEachPixel(width, frame.height, [&](int x, int y) {
    seen.depth(x, y) = taken(x, y) != 0 ? 0.0f : seen.depth(x, y);
  });
  const Patches curves(g, seen.depth, OnSameCurve);
  const std::vector<PatchKind> kinds = CurvedKinds(frame, curves, SeenLobes::kReflected, &seen);
  const Plane<int32_t> found = CurvedSources(seen, g, curves, kinds);
  ForEachPixel(width, frame.height, [&](int x, int y) {
    if (found(x, y) >= 0) {
      sources.Set(x, y, found(x, y), ImageKind::kReflected);
    }
  });
  return sources;
}

void SetVector(vec3 value, int x, int y, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

}  // namespace

std::optional<Lens> LensOfCamera(const CameraMatrices& camera, int width, int height) {
  const std::optional<glm::dmat4> ray = FromPicture(camera, width, height);
  if (!ray) {
    return std::nullopt;
  }
  const glm::dmat4& m = *ray;
  const glm::dmat2 slope = {m[0].x, m[0].y, m[1].x, m[1].y};
  Lens lens;
  lens.k = glm::dot(slope[0], slope[0]);
  lens.centre = -(glm::inverse(slope) * glm::dvec2(m[2]));
  return lens;
}

Lens LensOfFocalLength(double focal, int width) {
  Lens lens;
  const double tangent = 0.5 * width / focal;
  lens.k = tangent * tangent;
  return lens;
}

void SetHitGuides(const HitLayers& layers, const Lens& lens, Frame* frame, FrameImages* images) {
  const Guides& g = frame->guides;
  const int width = frame->width;
  const Image1 depth = ImageDepth(layers.distance, lens, g.depth);
  const Reflected reflected(layers, depth, *frame);
  Image3 albedo(width, frame->height);
  Image3 normal(width, frame->height);
  ForEachPixel(width, frame->height, [&](int x, int y) {
    SetVector(reflected.AlbedoAt(x, y), x, y, &albedo);
    SetVector(reflected.NormalAt(x, y), x, y, &normal);
  });
  const Seen seen = {depth, std::move(normal), albedo};
  const Sources sources =
      g.roughness.empty() ? SourcesByNeighbours(seen, *frame) : SourcesByRoughness(seen, g);
  VirtualGuides reflection;
  reflection.depth = Image1(width, frame->height);
  reflection.normal = Image3(width, frame->height);
  reflection.albedo = Image3(width, frame->height);
  reflection.motion = Image2(width, frame->height);
  ForEachPixel(width, frame->height, [&](int x, int y) {
    const int32_t from = sources.pixel(x, y);
    if (from < 0) {
      return;
    }
    const int u = from % width;
    const int v = from / width;
    const vec3 colour = VectorAt(albedo, u, v);
    reflection.depth(x, y) = depth(u, v);
    SetVector(SeenNormal(VectorAt(seen.normal, u, v), colour), x, y, &reflection.normal);
    SetVector(colour, x, y, &reflection.albedo);
  });
  frame->reflection = std::move(reflection);
  images->reflection = sources.kind;
  images->lens = lens;
}

}  // namespace stillray::io
