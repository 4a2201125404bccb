// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/seen_guides.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "core/pixels.h"
#include "io/camera_fit.h"

namespace stillray::io {
namespace {

/// Relative difference of depth between a surface and what is seen in it. At the foot of a mirror
/// both agree, and so do their guides.
constexpr float kOtherDepth = 0.01f;
/// Neighbours on one planar surface. Normals have the precision of halves.
constexpr float kFlatCosine = 0.9999f;
constexpr float kFlatDepth = 0.02f;
/// Neighbours that see one surface.
constexpr float kSeenDepth = 0.03f;
constexpr float kSeenCosine = 0.9f;
/// Least part of a surface's pixels that lie on its plane, and that see what their neighbours see.
constexpr float kLeastPlanar = 0.8f;
constexpr float kLeastCoherent = 0.8f;
constexpr int kLeastPixels = 32;
/// Albedos below are those of the mirror's edge, or noise.
constexpr float kLeastAlbedo = 0.02f;

void Set(vec3 value, int x, int y, Image3* image) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

float Sum(const Image3& image, int x, int y) {
  return image.empty() ? 0.0f : image[0](x, y) + image[1](x, y) + image[2](x, y);
}

constexpr int kNeighbours[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0},
                                   {1, 0},   {-1, 1}, {0, 1},  {1, 1}};

bool IsInside(const Image1& plane, int x, int y) {
  return x >= 0 && y >= 0 && x < plane.width() && y < plane.height();
}

/// What each pixel sees, as linear view-space depth and world-space normal.
struct Seen {
  Image1 depth;  ///< infinite: the sky; 0: the surface itself
  Image3 normal;
  const Image3& albedo;
};

/// Planar surfaces in which something else is seen, as sets of connected pixels.
class Patches {
 public:
  Patches(const Guides& guides, const Image1& seen);

  /// The patch of a pixel, or -1.
  int32_t Of(int x, int y) const { return patch_[Index(x, y)]; }
  size_t count() const { return count_; }

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }
  int32_t Root(int32_t i);
  void Join(const Guides& guides, const Image1& seen);
  void Number(const Image1& seen);
  void FillGaps(const Guides& guides);

  int width_ = 0;
  int height_ = 0;
  size_t count_ = 0;
  std::vector<int32_t> patch_;
};

int32_t Patches::Root(int32_t i) {
  while (patch_[static_cast<size_t>(i)] != i) {
    auto& parent = patch_[static_cast<size_t>(i)];
    parent = patch_[static_cast<size_t>(parent)];
    i = parent;
  }
  return i;
}

bool SamePlane(const Guides& g, int x, int y, int u, int v) {
  const float a = g.depth(x, y);
  const float b = g.depth(u, v);
  const bool same_id = g.id.empty() || g.id(x, y) == g.id(u, v);
  return same_id && std::abs(a - b) < kFlatDepth * a &&
         dot(VectorAt(g.normal, x, y), VectorAt(g.normal, u, v)) > kFlatCosine;
}

Patches::Patches(const Guides& g, const Image1& seen)
    : width_(g.depth.width()),
      height_(g.depth.height()),
      patch_(static_cast<size_t>(width_) * static_cast<size_t>(height_)) {
  Join(g, seen);
  Number(seen);
  FillGaps(g);
}

/// Union and find over the neighbours to the left and above.
void Patches::Join(const Guides& g, const Image1& seen) {
  std::iota(patch_.begin(), patch_.end(), 0);
  const auto join = [&](int x, int y, int u, int v) {
    if (seen(u, v) > 0 && SamePlane(g, x, y, u, v)) {
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

/// Numbers the sets from 0. Their roots come before their other pixels.
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

/// A pixel that sees nothing, or something invalid, belongs to the patch that surrounds it.
void Patches::FillGaps(const Guides& g) {
  constexpr int kMost = 5;
  std::vector<int32_t> filled = patch_;
  ForEachPixel(width_, height_, [&](int x, int y) {
    if (Of(x, y) >= 0) {
      return;
    }
    int32_t patch = -1;
    int votes = 0;  // as many as of the patch's pixels less those of others (Boyer and Moore)
    for (const auto& [dx, dy] : kNeighbours) {
      const int u = x + dx;
      const int v = y + dy;
      const bool inside = u >= 0 && v >= 0 && u < width_ && v < height_;
      if (inside && Of(u, v) >= 0 && SamePlane(g, x, y, u, v)) {
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

vec2 PointOf(const Image1& plane, int x, int y) {
  return PicturePoint(plane.width(), plane.height(), static_cast<float>(x) + 0.5f,
                      static_cast<float>(y) + 0.5f);
}

/// View-space z of what a pixel sees.
double DepthOfSeen(const SeenLayers& layers, const Lens& lens, int x, int y) {
  return lens.DepthOf(static_cast<double>(layers.depth(x, y)), PointOf(layers.depth, x, y));
}

/// Depth and normal of what is seen, where it is not the surface itself.
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
      Set(normal / length, x, y, &seen.normal);
    }
  });
  return seen;
}

bool SeesSame(const Seen& seen, int x, int y, int u, int v) {
  const float a = seen.depth(x, y);
  const float b = seen.depth(u, v);
  if (std::isinf(a) || std::isinf(b)) {
    return std::isinf(a) && std::isinf(b);
  }
  return a > 0 && std::abs(a - b) < kSeenDepth * a &&
         dot(VectorAt(seen.normal, x, y), VectorAt(seen.normal, u, v)) > kSeenCosine;
}

/// Neighbours of a pixel on its patch, and those of them that see the same.
struct Support {
  int neighbours = 0;
  int same = 0;
};

Support SupportOf(const Seen& seen, const Patches& patches, int x, int y) {
  Support support;
  for (const auto& [dx, dy] : kNeighbours) {
    const int u = x + dx;
    const int v = y + dy;
    if (IsInside(seen.depth, u, v) && patches.Of(u, v) == patches.Of(x, y)) {
      ++support.neighbours;
      support.same += SeesSame(seen, x, y, u, v) ? 1 : 0;
    }
  }
  return support;
}

/// The neighbour on the same patch that sees what most pixels around it see, and at least `least`
/// of them. (-1, -1) if there is none.
ivec2 CommonNeighbour(const Seen& seen, const Patches& patches, int x, int y, int least) {
  ivec2 best = {-1, -1};
  int most = least - 1;
  for (const auto& [dx, dy] : kNeighbours) {
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

/// Neighbours of a pixel that see what `other` sees.
int Agreement(const Seen& seen, int x, int y, ivec2 other) {
  int same = 0;
  for (const auto& [dx, dy] : kNeighbours) {
    const int u = x + dx;
    const int v = y + dy;
    same += IsInside(seen.depth, u, v) && SeesSame(seen, other.x, other.y, u, v) ? 1 : 0;
  }
  return same;
}

/// Whether two pixels see one colour.
bool SeesColour(const Seen& seen, int x, int y, int u, int v) {
  constexpr float kOtherColour = 0.15f;
  const vec3 a = VectorAt(seen.albedo, x, y);
  const vec3 b = VectorAt(seen.albedo, u, v);
  const vec3 difference = glm::abs(a - b);
  return difference.x + difference.y + difference.z <=
         kOtherColour * (glm::length(a) + glm::length(b));
}

/// A neighbour whose colour nearly all neighbours see and the pixel does not; (-1, -1) if there is
/// none. A floor that is reflected by a pane stands in the unfolded space where it is seen through
/// it, with other tiles.
ivec2 NeighbourOfOtherColour(const Seen& seen, int x, int y) {
  constexpr int kNearlyAll = 6;
  const auto is_same = [&](int x0, int y0, int u, int v) {
    return IsInside(seen.depth, u, v) && SeesSame(seen, x0, y0, u, v) &&
           SeesColour(seen, x0, y0, u, v);
  };
  for (const auto& [i, j] : kNeighbours) {
    const int u = x + i;
    const int v = y + j;
    if (!IsInside(seen.depth, u, v) || !SeesSame(seen, x, y, u, v) ||
        SeesColour(seen, x, y, u, v)) {
      continue;
    }
    int count = 0;
    for (const auto& [dx, dy] : kNeighbours) {
      count += is_same(u, v, x + dx, y + dy) ? 1 : 0;
    }
    if (count >= kNearlyAll) {
      return {u, v};
    }
  }
  return {-1, -1};
}

/// The pixel whose guides a pixel takes: itself, a neighbour that sees what most see if the pixel
/// alone sees something else, or (-1, -1) where nothing is seen in common. Denoising Data are
/// random in some pixels of every mirror.
/// \param other_lobe  whether the pixel's own guides are those of the surface's other lobe
ivec2 SourceOf(const Seen& seen, const Patches& patches, bool other_lobe, int x, int y) {
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
  // What a pixel sees that has no guides, as in glass within a mirror, is unknown at edges.
  const bool unknown =
      seen.depth(x, y) == 0 && source.x >= 0 && Agreement(seen, x, y, source) < kAgreed;
  return unknown ? ivec2(-1, -1) : source;
}

/// What a patch is.
struct PatchKind {
  bool shows_image = false;  ///< it is planar, and neighbours see the same
  bool refracted = false;    ///< more light comes through it than is reflected
};

struct PatchCounts {
  int pixels = 0;
  int planar = 0;
  int coherent = 0;
  glm::dvec3 normal{0.0};  ///< sum
  double reflected = 0;
  double refracted = 0;
};

template <typename Body>
void ForEachPatchPixel(const Patches& patches, const Image1& depth,
                       std::vector<PatchCounts>* counts, const Body& body) {
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      if (patches.Of(x, y) >= 0) {
        body(x, y, (*counts)[static_cast<size_t>(patches.Of(x, y))]);
      }
    }
  }
}

PatchKind KindOf(const PatchCounts& c) {
  const auto pixels = static_cast<float>(c.pixels);
  const bool planar = static_cast<float>(c.planar) >= kLeastPlanar * pixels;
  const bool coherent = static_cast<float>(c.coherent) >= kLeastCoherent * pixels;
  return {c.pixels >= kLeastPixels && planar && coherent, c.refracted > c.reflected};
}

/// Neighbours on a large ball are as good as on one plane; its patch as a whole is not.
std::vector<PatchKind> KindsOf(const Seen& seen, const Patches& patches, const Guides& g) {
  std::vector<PatchCounts> counts(patches.count());
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, PatchCounts& c) {
    const Support support = SupportOf(seen, patches, x, y);
    ++c.pixels;
    c.coherent += support.neighbours > 0 && 2 * support.same >= support.neighbours;
    c.normal += glm::dvec3(VectorAt(g.normal, x, y));
    c.reflected += static_cast<double>(Sum(g.specular_albedo, x, y));
    c.refracted += static_cast<double>(Sum(g.transmission_albedo, x, y));
  });
  ForEachPatchPixel(patches, g.depth, &counts, [&](int x, int y, PatchCounts& c) {
    const glm::dvec3 normal(VectorAt(g.normal, x, y));
    c.planar +=
        glm::dot(normal, c.normal) > static_cast<double>(kFlatCosine) * glm::length(c.normal);
  });
  std::vector<PatchKind> kinds;
  kinds.reserve(counts.size());
  for (const PatchCounts& c : counts) {
    kinds.push_back(KindOf(c));
  }
  return kinds;
}

/// The albedo of what is seen, without the throughput of the path and without emission.
vec3 SeenAlbedoAt(const Image3& albedo, const Image3& mirror, int x, int y) {
  vec3 seen = VectorAt(albedo, x, y);
  for (int c = 0; c < 3; ++c) {
    const float colour = mirror.empty() ? 1.0f : std::max(mirror[c](x, y), kLeastAlbedo);
    const float value = seen[c] / colour;
    seen[c] = std::isfinite(value) ? std::clamp(value, kLeastAlbedo, 1.0f) : 1.0f;
  }
  return seen;
}

void MakePlanes(int width, int height, VirtualGuides* guides) {
  guides->depth = Image1(width, height);
  guides->normal = Image3(width, height);
  guides->albedo = Image3(width, height);
  guides->motion = Image2(width, height);
}

/// The normals of pixels in which nothing else is seen; others are zero.
Image3 OwnNormals(const SeenLayers& layers, const Lens& lens, const Guides& g) {
  const int width = g.depth.width();
  const int height = g.depth.height();
  Image3 own(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const double depth = DepthOfSeen(layers, lens, x, y);
    if (std::abs(depth / static_cast<double>(g.depth(x, y)) - 1) < kOtherDepth) {
      Set(VectorAt(g.normal, x, y), x, y, &own);
    }
  });
  return own;
}

/// Adds the direction that no normal has, if the normals have two others. It is mirrored: worlds
/// are right-handed, and Cycles' camera, with z into the scene, is left-handed.
mat3 Completed(const mat3& map) {
  const mat3 cofactors(glm::cross(map[1], map[2]), glm::cross(map[2], map[0]),
                       glm::cross(map[0], map[1]));
  return map - cofactors;
}

/// From layers to the frame.
struct SeenFit {
  Lens lens;
  mat3 to_world{1.0f};
  CameraMotion camera;
};

float LightAt(const Frame& frame, SignalKind direct, SignalKind indirect, int x, int y) {
  float sum = 0;
  for (const Signal& signal : frame.signals) {
    sum += signal.kind == direct || signal.kind == indirect ? Sum(signal.radiance, x, y) : 0.0f;
  }
  return sum;
}

/// Pixels whose path took the other lobe of their surface: the only sample was reflected by a pane
/// through which one looks, or the reverse. It has light of that lobe alone, and its layers follow
/// it. Clears what they see.
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

NoSeenGuides Fit(const SeenLayers& layers, const Guides& g, SeenFit* fit) {
  const std::optional<Lens> lens = FitLens(g.depth, layers.depth);
  if (!lens) {
    return NoSeenGuides::kLens;
  }
  fit->lens = *lens;
  constexpr float kLeastVolume = 0.5f;  // 1 for all changes of axes
  mat3 to_camera = FitNormalMap(OwnNormals(layers, *lens, g), layers.normal);
  if (!(std::abs(glm::determinant(to_camera)) > kLeastVolume)) {
    to_camera = Completed(to_camera);
  }
  if (!(std::abs(glm::determinant(to_camera)) > kLeastVolume)) {
    return NoSeenGuides::kNormal;
  }
  fit->to_world = glm::inverse(to_camera);
  const std::optional<CameraMotion> camera = FitCameraMotion(g.depth, g.motion);
  if (!camera) {
    return NoSeenGuides::kMotion;
  }
  fit->camera = *camera;
  return NoSeenGuides::kNone;
}

}  // namespace

NoSeenGuides CheckSeenGuides(const SeenLayers& seen, const Guides& guides) {
  SeenFit fit;
  return Fit(seen, guides, &fit);
}

NoSeenGuides SetSeenGuides(const SeenLayers& layers, Frame* frame) {
  const Guides& g = frame->guides;
  const int width = frame->width;
  const int height = frame->height;
  MakePlanes(width, height, &frame->reflection);
  if (!g.transmission_albedo.empty()) {
    MakePlanes(width, height, &frame->refraction);
  }
  SeenFit fit;
  const NoSeenGuides why = Fit(layers, g, &fit);
  if (why != NoSeenGuides::kNone) {
    return why;
  }
  Seen seen = FindSeen(layers, fit.lens, fit.to_world, g);
  const Patches patches(g, seen.depth);
  const std::vector<PatchKind> kinds = KindsOf(seen, patches, g);
  const Plane<uint8_t> dropped = DropOtherLobes(*frame, patches, kinds, &seen);
  ForEachPixel(width, height, [&](int x, int y) {
    const int32_t patch = patches.Of(x, y);
    const PatchKind kind = patch < 0 ? PatchKind() : kinds[static_cast<size_t>(patch)];
    const ivec2 from =
        kind.shows_image ? SourceOf(seen, patches, dropped(x, y) != 0, x, y) : ivec2(-1, -1);
    if (from.x < 0) {
      return;
    }
    const float depth = seen.depth(from.x, from.y);
    VirtualGuides& to = kind.refracted ? frame->refraction : frame->reflection;
    const Image3& mirror = kind.refracted ? g.transmission_albedo : g.specular_albedo;
    const vec2 motion =
        fit.camera.MotionOf(PointOf(g.depth, x, y), static_cast<double>(depth), width);
    to.depth(x, y) = depth;
    Set(VectorAt(seen.normal, from.x, from.y), x, y, &to.normal);
    Set(SeenAlbedoAt(layers.albedo, mirror, from.x, from.y), x, y, &to.albedo);
    to.motion[0](x, y) = motion.x;
    to.motion[1](x, y) = motion.y;
  });
  return NoSeenGuides::kNone;
}

}  // namespace stillray::io
