// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Views of the primary hit of each pixel: triangle, barycentric coordinates, material. These
/// planes are not part of a frame: separate rays compute them, on the CPU.
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

/// The first surface with an opacity of at least 1/2 along the pinhole primary ray through the
/// pixel centre plus the frame's jitter. All values are 0 without a surface.
struct HitViews {
  Image3 barycentrics;       ///< barycentric weights of the vertices, in the order of the indices
  Plane<uint32_t> triangle;  ///< index in the mesh plus one
  Plane<uint32_t> material;  ///< index in Scene::materials plus one
};

/// A scene with a separate BVH.
class HitFinder {
 public:
  /// \param scene  valid; must outlive the result
  /// \return kOutOfMemory
  static Result<std::unique_ptr<HitFinder>> Create(const Scene& scene);
  /// \param moment  moment of the frame, with its camera pose
  /// \param frame   frame with size and jitter
  /// \return kOutOfMemory
  Result<HitViews> Find(const RenderMoment& moment, const Frame& frame);

 private:
  explicit HitFinder(const Scene& scene) : state_(scene), filter_(state_) {}

  render::SceneState state_;
  render::SceneShadowFilter filter_;
  std::unique_ptr<render::Accel> accel_;
};

}  // namespace stillray::view
