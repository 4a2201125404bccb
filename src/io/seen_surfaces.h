// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Surfaces with virtual images, reflected or transmitted, as sets of connected pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/pixels.h"
#include "stillray/frame.h"
#include "stillray/vec.h"

namespace stillray::io {

/// The seen surface of each pixel: the first rough surface after mirrors and glass.
struct Seen {
  Image1 depth;   ///< view-space z; infinite: the sky; 0: the visible surface itself, or invalid
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

/// Minimum cosine between normals of one seen surface.
inline constexpr float kSeenCosine = 0.9f;

/// Whether two pixels have the same seen surface.
bool SeesSame(const Seen& seen, int x, int y, int u, int v);

/// Whether two pixels are on one surface, by its own guides: the same id if there is any, depth
/// that differs by less than `depth` of it, and a cosine of the normals above `cosine`.
bool OnSameSurface(const Guides& guides, int x, int y, int u, int v, float depth, float cosine);

using SameSurface = bool (*)(const Guides& guides, int x, int y, int u, int v);
bool OnSamePlane(const Guides& guides, int x, int y, int u, int v);
bool OnSameCurve(const Guides& guides, int x, int y, int u, int v);

/// The albedo of the seen surface, without the path throughput. The albedo of a lamp includes its
/// emission; above 1 it is limited by the pixel's radiance.
/// \param mirror  albedo of the mirror; may be empty
vec3 SeenAlbedoAt(const Image3& albedo, const Image3& mirror, vec3 light, int x, int y);

/// The normal of a lamp is negated, so that no filter joins it with adjacent surfaces, whose
/// radiance would else be multiplied by the lamp's albedo.
vec3 SeenNormal(vec3 normal, vec3 albedo);

/// The specular radiance of a pixel.
vec3 ReflectedLightAt(const Frame& frame, int x, int y);

/// Patches: connected pixels of surfaces with virtual images.
class Patches {
 public:
  /// \param seen  depth of the seen surface, 0 without a virtual image
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
  int known = 0;  ///< number of them with a seen surface
  int same = 0;   ///< number of them with the pixel's seen surface
};
Support SupportOf(const Seen& seen, const Patches& patches, int x, int y);

/// Which virtual images a layer describes.
enum class SeenLobes : uint8_t {
  kEither,     ///< reflected or refracted, whichever has the larger albedo
  kReflected,  ///< reflected, also in glass
};

/// The properties of a patch.
struct PatchKind {
  bool shows_image = false;
  bool refracted = false;  ///< more light is transmitted than reflected
};

/// Clears the seen surface of pixels whose path took the other lobe of their surface: the only
/// sample was reflected by glass that is otherwise transmissive, or the reverse. Its radiance and
/// layers belong to that lobe alone.
Plane<uint8_t> DropOtherLobes(const Frame& frame, const Patches& patches,
                              const std::vector<PatchKind>& kinds, Seen* seen);

}  // namespace stillray::io
