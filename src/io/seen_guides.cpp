// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/seen_guides.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/guides.h"
#include "core/pixels.h"
#include "io/camera_fit.h"
#include "io/seen_curved.h"
#include "io/seen_planar.h"
#include "io/seen_surfaces.h"

namespace stillray::io {
namespace {

/// Minimum relative difference of depth between a surface and its virtual image. At the foot of a
/// mirror both depths agree, and so do their guides.
constexpr float kOtherDepth = 0.01f;

void SetVector(vec3 value, int x, int y, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

/// View-space z of the seen surface of a pixel.
double DepthOfSeen(const SeenLayers& layers, const Lens& lens, int x, int y) {
  return lens.DepthOf(static_cast<double>(layers.depth(x, y)), PixelPoint(layers.depth, x, y));
}

/// Depth and normal of the seen surface, where it is not the visible surface itself.
Seen FindSeen(const SeenLayers& layers, const Lens& lens, const mat3& to_world, const Guides& g) {
  const int width = g.depth.width();
  const int height = g.depth.height();
  Seen seen = {Image1(width, height), Image3(width, height), layers.albedo};
  ForEachPixel(width, height, [&](int x, int y) {
    const float z = g.depth(x, y);
    if (!(z > 0) || !std::isfinite(z)) {
      return;
    }
    if (layers.depth(x, y) == 0) {
      seen.depth(x, y) = std::numeric_limits<float>::infinity();
      return;
    }
    const auto depth = static_cast<float>(DepthOfSeen(layers, lens, x, y));
    const vec3 normal = to_world * VectorAt(layers.normal, x, y);
    const float length = glm::length(normal);
    if (depth > z * (1 + kOtherDepth) && std::isfinite(depth) && length > 0.5f && length < 2.0f) {
      seen.depth(x, y) = depth;
      SetVector(normal / length, x, y, &seen.normal);
    }
  });
  return seen;
}

void MakePlanes(int width, int height, VirtualGuides* guides, Plane<uint8_t>* kinds) {
  guides->depth = Image1(width, height);
  guides->normal = Image3(width, height);
  guides->albedo = Image3(width, height);
  guides->motion = Image2(width, height);
  *kinds = Plane<uint8_t>(width, height);
}

/// Planes without any virtual image.
void MakeImages(Frame* frame, FrameImages* images) {
  MakePlanes(frame->width, frame->height, &frame->reflection, &images->reflection);
  if (!frame->guides.transmission_albedo.empty()) {
    MakePlanes(frame->width, frame->height, &frame->refraction, &images->refraction);
  }
}

bool HasImage(const Plane<uint8_t>& kinds) {
  return AnyPixel(kinds, [](uint8_t kind) { return kind != 0; });
}

/// The normals of pixels without virtual images; zero elsewhere.
Image3 OwnNormals(const SeenLayers& layers, const Lens& lens, const Guides& g) {
  const int width = g.depth.width();
  const int height = g.depth.height();
  Image3 own(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const double depth = DepthOfSeen(layers, lens, x, y);
    if (std::abs(depth / static_cast<double>(g.depth(x, y)) - 1) < kOtherDepth) {
      SetVector(VectorAt(g.normal, x, y), x, y, &own);
    }
  });
  return own;
}

/// Completes the map in the third direction if the normals span only two. The map is mirrored:
/// world space is right-handed, and Cycles' camera space, with z into the scene, is left-handed.
mat3 Completed(const mat3& map) {
  const mat3 cofactors(glm::cross(map[1], map[2]), glm::cross(map[2], map[0]),
                       glm::cross(map[0], map[1]));
  return map - cofactors;
}

/// Conversion of the layers to the frame's conventions.
struct SeenFit {
  Lens lens;
  mat3 to_world{1.0f};
};

NoSeenGuides Fit(const SeenLayers& layers, const Guides& g, SeenFit* fit) {
  const std::optional<Lens> lens = FitLens(g.depth, layers.depth);
  if (!lens) {
    return NoSeenGuides::kLens;
  }
  fit->lens = *lens;
  const std::optional<mat3> to_world = FitToWorld(OwnNormals(layers, *lens, g), layers.normal);
  if (!to_world) {
    return NoSeenGuides::kNormal;
  }
  fit->to_world = *to_world;
  return NoSeenGuides::kNone;
}

/// Guides of the pixels' seen surfaces.
class Images {
 public:
  Images(const SeenLayers& layers, const Seen& seen, Frame* frame, FrameImages* images)
      : layers_(layers), seen_(seen), frame_(*frame), images_(*images) {}

  vec3 AlbedoAt(bool refracted, int x, int y) const {
    const Guides& g = frame_.guides;
    if (refracted) {
      return SeenAlbedoAt(layers_.albedo, g.transmission_albedo, vec3(0.0f), x, y);
    }
    return SeenAlbedoAt(layers_.albedo, g.specular_albedo, ReflectedLightAt(frame_, x, y), x, y);
  }

  /// Depth and normal are taken from pixel `from`.
  void Set(bool refracted, ivec2 from, vec3 albedo, ImageKind kind, int x, int y) {
    VirtualGuides& to = refracted ? frame_.refraction : frame_.reflection;
    to.depth(x, y) = seen_.depth(from.x, from.y);
    SetVector(SeenNormal(VectorAt(seen_.normal, from.x, from.y), albedo), x, y, &to.normal);
    SetVector(albedo, x, y, &to.albedo);
    (refracted ? images_.refraction : images_.reflection)(x, y) = static_cast<uint8_t>(kind);
  }

 private:
  const SeenLayers& layers_;
  const Seen& seen_;
  Frame& frame_;
  FrameImages& images_;
};

/// Virtual images in planar mirrors and panes of glass.
/// \return 1 on surfaces with a virtual image
Plane<uint8_t> SetImagesOfPlanes(const SeenLayers& layers, Seen* seen, Frame* frame,
                                 FrameImages* set) {
  const Guides& g = frame->guides;
  const Patches patches(g, seen->depth, OnSamePlane);
  const std::vector<PatchKind> kinds = PlanarKinds(*seen, patches, g, SeenLobes::kEither);
  const Plane<uint8_t> dropped = DropOtherLobes(*frame, patches, kinds, seen);
  Plane<uint8_t> taken(frame->width, frame->height);
  Images images(layers, *seen, frame, set);
  ForEachPixel(frame->width, frame->height, [&](int x, int y) {
    const int32_t patch = patches.Of(x, y);
    const PatchKind kind = patch < 0 ? PatchKind() : kinds[static_cast<size_t>(patch)];
    taken(x, y) = kind.shows_image ? 1 : 0;
    const ivec2 from =
        kind.shows_image ? PlanarSource(*seen, patches, dropped(x, y) != 0, x, y) : ivec2(-1, -1);
    if (from.x >= 0) {
      images.Set(kind.refracted, from, images.AlbedoAt(kind.refracted, from.x, from.y),
                 ImageKind::kPlanar, x, y);
    }
  });
  return taken;
}

/// The mean albedo of neighbours with the same seen surface as pixel `from`.
vec3 MeanAlbedo(const Images& images, const Seen& seen, const Plane<int32_t>& sources,
                bool refracted, ivec2 from, int x, int y) {
  vec3 sum(0.0f);
  float count = 0;
  for (const auto& [dx, dy] : kNeighbourOffsets) {
    const int u = x + dx;
    const int v = y + dy;
    if (IsInside(seen.depth, u, v) && sources(u, v) == v * seen.depth.width() + u &&
        SeesSame(seen, from.x, from.y, u, v)) {
      sum += images.AlbedoAt(refracted, u, v);
      count += 1;
    }
  }
  return count > 0 ? sum / count : images.AlbedoAt(refracted, from.x, from.y);
}

/// Virtual images in curved mirrors and glass. Images behind glass get the motion of the glass, as
/// the refracted path is unknown.
void SetImagesOfCurves(const SeenLayers& layers, const Plane<uint8_t>& taken, Seen seen,
                       Frame* frame, FrameImages* set) {
  const Guides& g = frame->guides;
  ForEachPixel(frame->width, frame->height, [&](int x, int y) {
    seen.depth(x, y) = taken(x, y) != 0 ? 0.0f : seen.depth(x, y);
  });
  const Patches patches(g, seen.depth, OnSameCurve);
  const std::vector<PatchKind> kinds = CurvedKinds(*frame, patches, SeenLobes::kEither, &seen);
  if (std::none_of(kinds.begin(), kinds.end(), [](PatchKind kind) { return kind.shows_image; })) {
    return;
  }
  const Plane<int32_t> sources = CurvedSources(seen, g, patches, kinds);
  Images images(layers, seen, frame, set);
  ForEachPixel(frame->width, frame->height, [&](int x, int y) {
    const int32_t source = sources(x, y);
    if (source < 0) {
      return;
    }
    const bool refracted = kinds[static_cast<size_t>(patches.Of(x, y))].refracted;
    const ivec2 from(source % frame->width, source / frame->width);
    const bool is_own = from == ivec2(x, y) || (!refracted && seen.depth(x, y) > 0);
    const vec3 albedo = is_own ? images.AlbedoAt(refracted, x, y)
                               : MeanAlbedo(images, seen, sources, refracted, from, x, y);
    images.Set(refracted, from, albedo, refracted ? ImageKind::kSurface : ImageKind::kReflected, x,
               y);
  });
}

}  // namespace

std::optional<mat3> FitToWorld(const Image3& own, const Image3& seen) {
  constexpr float kLeastVolume = 0.5f;  // 1 for all changes of axes
  mat3 to_camera = FitNormalMap(own, seen);
  if (!(std::abs(glm::determinant(to_camera)) > kLeastVolume)) {
    to_camera = Completed(to_camera);
  }
  return std::abs(glm::determinant(to_camera)) > kLeastVolume
             ? std::optional<mat3>(glm::inverse(to_camera))
             : std::nullopt;
}

NoSeenGuides CheckSeenGuides(const SeenLayers& seen, const Guides& guides, bool has_camera) {
  SeenFit fit;
  const NoSeenGuides why = Fit(seen, guides, &fit);
  if (why != NoSeenGuides::kNone || has_camera) {
    return why;
  }
  CameraFits fits(guides);
  return WhyUnknown(&fits);
}

void SetSeenGuides(const SeenLayers& layers, Frame* frame, FrameImages* images) {
  const Guides& g = frame->guides;
  MakeImages(frame, images);
  if (!AnyPixel(g.depth, IsSurface)) {
    return;
  }
  SeenFit fit;
  images->missing = Fit(layers, g, &fit);
  if (images->missing != NoSeenGuides::kNone) {
    return;
  }
  images->lens = fit.lens;
  Seen seen = FindSeen(layers, fit.lens, fit.to_world, g);
  const Plane<uint8_t> taken = SetImagesOfPlanes(layers, &seen, frame, images);
  SetImagesOfCurves(layers, taken, std::move(seen), frame, images);
}

void MoveSeenGuides(CameraFits* fits, Frame* frame, FrameImages* images) {
  const bool moves_reflection = !images->has_reflection_motion && HasImage(images->reflection);
  const bool moves_refraction = HasImage(images->refraction);
  if (images->missing != NoSeenGuides::kNone || (!moves_reflection && !moves_refraction)) {
    return;
  }
  images->missing = WhyUnknown(fits);
  if (images->missing != NoSeenGuides::kNone) {
    if (moves_reflection) {
      MakePlanes(frame->width, frame->height, &frame->reflection, &images->reflection);
    }
    if (moves_refraction) {
      MakePlanes(frame->width, frame->height, &frame->refraction, &images->refraction);
    }
    return;
  }
  const Guides& g = frame->guides;
  if (moves_reflection) {
    SetImageMotion(images->reflection, images->lens, *fits->Motion(), fits, g, &frame->reflection);
  }
  if (moves_refraction) {
    SetImageMotion(images->refraction, images->lens, *fits->Motion(), fits, g, &frame->refraction);
  }
}

}  // namespace stillray::io
