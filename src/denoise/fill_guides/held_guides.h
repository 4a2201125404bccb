// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Held guides: guides carried over from earlier frames. Code shared by the scalar and the vector
/// version of fill_guides.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/guides.h"
#include "denoise/fill_guides/fill_guides_shared.h"
#include "stillray/frame.h"

namespace stillray {

/// Filled guides, emission and background of a frame. Images that the frames lack are empty, and so
/// are emission and background while all known values are black.
struct HeldGuides {
  Image1 known;   ///< 1: traced in this frame or carried over; 0: filled from the pyramid
  Guides guides;  ///< without roughness
  Image3 emission;
  Image3 background;

  // State of the vector version; false is always correct.
  bool motionless = false;         ///< motion is zero everywhere
  bool first_level_valid = false;  ///< the pyramids' first level is downsampled from these planes

  bool empty() const { return known.empty(); }
  size_t bytes() const;
};

/// Calls visit(plane) for every float plane in a fixed order, including empty planes.
template <typename Held, typename Visit>
void VisitHeldPlanes(Held& held, const Visit& visit) {
  visit(held.known);
  visit(held.guides.depth);
  for (auto* image : {&held.guides.normal, &held.guides.albedo, &held.guides.specular_albedo,
                      &held.guides.transmission_albedo, &held.emission, &held.background}) {
    for (auto& plane : image->channel) {
      visit(plane);
    }
  }
  for (auto& plane : held.guides.motion.channel) {
    visit(plane);
  }
}

/// The known pixels that fill a plane's holes, and the holes that become zero.
enum class FillRule : uint8_t {
  kSurfaceOnly,  ///< from surfaces; zero where the hole shows the sky
  kAnywhere,     ///< from surfaces
  kSkyOnly,      ///< from the sky; zero where the hole shows a surface
};

/// One plane of a frame and the plane that holds it.
struct HeldPlane {
  const Image1* from = nullptr;
  Image1* held = nullptr;
  FillRule rule = FillRule::kAnywhere;
};

/// The held planes except known, depth, motion and id.
struct HeldPlanes {
  static constexpr size_t kMaxPlanes = 18;

  std::array<HeldPlane, kMaxPlanes> plane;
  int count = 0;

  const HeldPlane* begin() const { return plane.data(); }
  const HeldPlane* end() const { return plane.data() + count; }
};

HeldPlanes PlanesOf(const Frame& frame, HeldGuides* held);

/// Whether emission and background have been non-black so far; only then they are held.
struct VisibleLight {
  bool emission = false;
  bool background = false;
};

/// Whether held guides have the size and the images of the frame.
bool Fits(const HeldGuides& held, const Frame& frame);
/// Allocates missing planes, all zero, and frees emission or background while it is black.
void MakeRoom(const Frame& frame, const VisibleLight& seen, HeldGuides* held);

/// Whether a component of the motion is not zero; true for NaN.
inline bool IsMoving(float motion) {
  return !(std::abs(motion) <= kMinMotion);
}

/// Finds held guides along the motion. The sum of position and motion is rounded with an offset per
/// frame, so that slow motion is correct on average over many frames.
struct Shift {
  float x;
  float y;

  explicit Shift(int64_t frame)
      : x(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.7548776662466927, 1.0))),
        y(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.5698402909980532, 1.0))) {}

  /// \return whether the position is inside the image
  bool Find(const Image2& motion, int x0, int y0, int* qx, int* qy) const {
    const float px = HeldCoordinate(x0, motion[0](x0, y0), x);
    const float py = HeldCoordinate(y0, motion[1](x0, y0), y);
    if (!(px >= 0 && py >= 0 && px < static_cast<float>(motion.width()) &&
          py < static_cast<float>(motion.height()))) {
      return false;
    }
    *qx = static_cast<int>(px);
    *qy = static_cast<int>(py);
    return true;
  }
};

/// Whether two pixels show different surfaces.
inline bool AreDifferentSurfaces(const Guides& a, int ax, int ay, const Guides& b, int bx, int by) {
  const float za = a.depth(ax, ay);
  const float zb = b.depth(bx, by);
  if (IsSurface(za) != IsSurface(zb)) {
    return true;
  }
  if (!a.id.empty()) {
    return a.id(ax, ay) != b.id(bx, by);
  }
  return IsSurface(za) && DepthsDiffer(za, zb);
}

/// \param known  number of known pixels of this frame
inline int GhostRadius(const Frame& frame, int64_t known) {
  return GhostRadius(static_cast<float>(known),
                     static_cast<float>(frame.width) * static_cast<float>(frame.height));
}

}  // namespace stillray
