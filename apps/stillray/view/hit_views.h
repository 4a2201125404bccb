// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Views of what each pixel's camera ray hits: the triangle, the point on it, the material. No
/// frame has these planes: rays of their own find them, on the CPU.
#pragma once

#include <memory>

#include "render/accel.h"
#include "render/scene_state.h"
#include "render/shadow_filter.h"
#include "stillray/frame.h"
#include "stillray/image.h"
#include "stillray/render.h"
#include "stillray/scene.h"

namespace stillray::view {

/// Of the first surface that is at least half opaque, seen through a pinhole at the pixel's centre,
/// offset by the frame's jitter. Where there is none all are 0.
struct HitViews {
  Image3 barycentrics;       ///< weights of the triangle's corners, in the order of its indices
  Plane<uint32_t> triangle;  ///< index in the mesh, plus one
  Plane<uint32_t> material;  ///< index in Scene::materials, plus one
};

/// A scene with a BVH of its own.
class HitFinder {
 public:
  /// \param scene  valid; must outlive the result
  /// \return kOutOfMemory
  static Result<std::unique_ptr<HitFinder>> Create(const Scene& scene);
  /// \param moment  of the frame, with its pose
  /// \param frame   its size and jitter
  /// \return kOutOfMemory
  Result<HitViews> Find(const RenderMoment& moment, const Frame& frame);

 private:
  explicit HitFinder(const Scene& scene) : state_(scene), filter_(state_) {}

  render::SceneState state_;
  render::SceneShadowFilter filter_;
  std::unique_ptr<render::Accel> accel_;
};

}  // namespace stillray::view
