// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The lens of a frame: combination of settings and scene camera, sampling tables of aperture
/// masks, and autofocus.
#pragma once

#include <vector>

#include "render/camera.h"
#include "render/lens_shared.h"
#include "render/scene_state.h"
#include "stillray/render.h"

namespace stillray::render {

/// Cumulative sums for sampling one aperture mask.
struct LensMask {
  int texture = -1;  ///< index of the scene's texture
  int width = 0;
  int height = 0;
  std::vector<float> sums;
};

/// The aperture masks of all cameras of a scene.
class LensMasks {
 public:
  /// \param scene  checked (CheckScene)
  explicit LensMasks(const Scene& scene);
  /// The mask made from a texture; null if there is none.
  const LensMask* Find(int texture) const;
  const std::vector<LensMask>& all() const { return masks_; }

 private:
  std::vector<LensMask> masks_;
};

/// Mean luminance of a mask, 0 to 1.
double MaskBrightness(const Texture& mask);

/// The lens of the scene's camera; settings that are given override its members.
Lens LensOf(const Scene& scene, const RenderSettings& settings, int camera);
/// Whether the camera may have a lens at any moment.
bool MayHaveLens(const Scene& scene, const RenderSettings& settings);

/// The radius of the aperture in scene units: see Lens::f_number.
float LensRadius(const Lens& lens, const CameraView& view);

/// Depth of the surface at the image centre, at the state's current or (`previous`) previous
/// moment; +infinity if there is none. Surfaces with an opacity below 1/2 are ignored.
float FindFocus(const SceneState& state, const CameraView& view, bool previous);

LensArrays MakeLensArrays(const Lens& lens, const LensMasks& masks);

}  // namespace stillray::render
