// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The lens of a frame: settings and the scene's camera together, the tables of masks, and the
/// focus found by a ray.
#pragma once

#include <vector>

#include "render/camera.h"
#include "render/lens_shared.h"
#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

/// Cumulative sums for sampling one mask.
struct LensMask {
  int texture = -1;  ///< of the scene
  int width = 0;
  int height = 0;
  std::vector<float> sums;
};

/// The masks of all cameras of a scene.
class LensMasks {
 public:
  /// \param scene  checked (CheckScene)
  explicit LensMasks(const Scene& scene);
  /// The mask of a texture; null: none.
  const LensMask* Find(int texture) const;
  const std::vector<LensMask>& all() const { return masks_; }

 private:
  std::vector<LensMask> masks_;
};

/// Mean luminance of a mask, 0 to 1.
double MaskBrightness(const Texture& mask);

/// The scene's lens with the settings in its place where they are given.
Lens LensOf(const Scene& scene, const RenderSettings& settings, int camera);
/// Whether any moment may have a lens.
bool MayHaveLens(const Scene& scene, const RenderSettings& settings);

/// The radius of the aperture in scene units: see Lens::f_number.
float LensRadius(const Lens& lens, const CameraView& view);

/// Depth of the surface in the centre of the picture, at the state's moment or (`previous`) the
/// moment before; +infinity if there is none. Surfaces of an opacity below 1/2 do not count.
float FindFocus(const SceneState& state, const CameraView& view, bool previous);

LensArrays MakeLensArrays(const Lens& lens, const LensMasks& masks);

}  // namespace stillray::render
