// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Surfaces that show something else, reflected or through them, as sets of connected pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/pixels.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// What each pixel sees.
struct Seen {
  Image1 depth;   ///< as view-space z; infinite: the sky; 0: the surface itself, or invalid
  Image3 normal;  ///< in world space
  const Image3& albedo;
};

inline constexpr int kNeighbourOffsets[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0},
                                                {1, 0},   {-1, 1}, {0, 1},  {1, 1}};

/// 0 for an empty image.
inline float SumAt(const Image3& image, int x, int y) {
  return image.empty() ? 0.0f : image[0](x, y) + image[1](x, y) + image[2](x, y);
}

inline bool IsInside(const Image1& plane, int x, int y) {
  return x >= 0 && y >= 0 && x < plane.width() && y < plane.height();
}

/// Least cosine of the normals of one seen surface.
inline constexpr float kSeenCosine = 0.9f;

/// Whether two pixels see one surface.
bool SeesSame(const Seen& seen, int x, int y, int u, int v);

/// Whether two pixels are on one surface, by its own guides: the same id if there is any, depth
/// that differs by less than `depth` of it, and a cosine of the normals above `cosine`.
bool OnSameSurface(const Guides& guides, int x, int y, int u, int v, float depth, float cosine);

using SameSurface = bool (*)(const Guides& guides, int x, int y, int u, int v);
bool OnSamePlane(const Guides& guides, int x, int y, int u, int v);
bool OnSameCurve(const Guides& guides, int x, int y, int u, int v);

/// The albedo of what is seen, without the throughput of the path. That of a lamp contains what it
/// emits; above 1 it is as much as the pixel's light confirms.
/// \param mirror  albedo of the surface that shows it; may be empty
vec3 SeenAlbedoAt(const Image3& albedo, const Image3& mirror, vec3 light, int x, int y);

/// The normal of a lamp is negated: no filter takes it and what is beside it for one surface, and
/// its radiance, by which the light is divided, multiplies no other light.
vec3 SeenNormal(vec3 normal, vec3 albedo);

/// The specular light of a pixel.
vec3 ReflectedLightAt(const Frame& frame, int x, int y);

/// Surfaces in which something else is seen.
class Patches {
 public:
  /// \param seen  depth of what is seen, 0 where nothing else is
  Patches(const Guides& guides, const Image1& seen, SameSurface same);

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

  SameSurface same_;
  int width_ = 0;
  int height_ = 0;
  size_t count_ = 0;
  std::vector<int32_t> patch_;
};

/// Calls body(x, y, counts of the pixel's patch).
template <typename Counts, typename Body>
void ForEachPatchPixel(const Patches& patches, const Image1& depth, std::vector<Counts>* counts,
                       const Body& body) {
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      if (patches.Of(x, y) >= 0) {
        body(x, y, (*counts)[static_cast<size_t>(patches.Of(x, y))]);
      }
    }
  }
}

/// Neighbours of a pixel on its patch.
struct Support {
  int neighbours = 0;
  int known = 0;  ///< those of them that see something
  int same = 0;   ///< ... what the pixel sees
};
Support SupportOf(const Seen& seen, const Patches& patches, int x, int y);

/// Which images a layer describes.
enum class SeenLobes : uint8_t {
  kEither,     ///< reflected or refracted, whichever is brighter by the albedos
  kReflected,  ///< reflected, also in glass
};

/// What a patch is.
struct PatchKind {
  bool shows_image = false;
  bool refracted = false;  ///< more light comes through it than is reflected
};

/// Pixels whose path took the other lobe of their surface: the only sample was reflected by glass
/// through which one looks, or the reverse. It has light of that lobe alone, and its layers follow
/// it. Clears what they see.
Plane<uint8_t> DropOtherLobes(const Frame& frame, const Patches& patches,
                              const std::vector<PatchKind>& kinds, Seen* seen);

}  // namespace stillray::io
