// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What both versions of CompleteGuides do alike.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/fill_guides/fill_guides_shared.h"

namespace stillray {

/// What a hole of a plane gets.
enum class FillRule : uint8_t {
  kSurfaceOnly,  ///< what surfaces around it have; zero in the sky
  kAnywhere,     ///< what surfaces around it have
  kSkyOnly,      ///< what the sky around it has; zero on surfaces
};

/// One plane of a frame beside those that hold it.
struct HeldPlane {
  const Image1* from = nullptr;
  Image1* held = nullptr;
  FillRule rule = FillRule::kAnywhere;
};

/// The planes that are held, but for known, depth, motion and ids.
struct HeldPlanes {
  std::array<HeldPlane, SparseGuidesWork::kMostPlanes> plane;
  int count = 0;

  const HeldPlane* begin() const { return plane.data(); }
  const HeldPlane* end() const { return plane.data() + count; }
};

HeldPlanes PlanesOf(const Frame& frame, HeldGuides* held);

/// Which images a frame asks for beyond those that it always holds.
struct LightSeen {
  bool emission = false;
  bool background = false;
};

/// Whether what is held can go on with this frame.
bool Fits(const HeldGuides& held, const Frame& frame);
/// Makes the planes that are missing, all zero, and drops those that nothing was seen of.
void MakeRoom(const Frame& frame, const LightSeen& seen, HeldGuides* held);

inline bool IsSurface(float depth) {
  return std::isfinite(depth) && depth > 0;
}

/// Whether a value counts as moving; NaN does.
inline bool IsMoving(float motion) {
  return !(std::abs(motion) <= kStill);
}

/// Where a frame's held guides are looked up: along the motion, rounded up or down so that over
/// many frames of slow motion the mean is right.
struct Shift {
  float x;
  float y;

  explicit Shift(int64_t frame)
      : x(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.7548776662466927, 1.0))),
        y(static_cast<float>(
            std::fmod(static_cast<double>(frame & 0xffff) * 0.5698402909980532, 1.0))) {}

  /// \return whether the place lies in the picture
  bool Find(const Image2& motion, int x0, int y0, int* qx, int* qy) const {
    const float px = HeldPlace(x0, motion[0](x0, y0), x);
    const float py = HeldPlace(y0, motion[1](x0, y0), y);
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
inline bool Differ(const Guides& a, int ax, int ay, const Guides& b, int bx, int by) {
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

/// \param known  pixels of the picture, by this frame
inline int GhostRadius(const Frame& frame, int64_t known) {
  return GhostRadius(static_cast<float>(known),
                     static_cast<float>(frame.width) * static_cast<float>(frame.height));
}

}  // namespace stillray
