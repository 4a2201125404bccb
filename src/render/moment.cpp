// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/moment.h"

#include <algorithm>

namespace stillray::render {

CameraView ViewOf(const CameraPose& pose, int width, int height) {
  Camera camera;
  camera.yfov = pose.yfov;
  return MakeCameraView(camera, pose.world_from_camera, width, height);
}

CameraPair CamerasOf(const SceneState& state, const RenderMoment& moment, int width, int height) {
  if (moment.pose) {
    const CameraPose& previous = moment.previous_pose ? *moment.previous_pose : *moment.pose;
    return {ViewOf(*moment.pose, width, height), ViewOf(previous, width, height)};
  }
  const Camera& camera = state.scene().cameras[static_cast<size_t>(moment.camera)];
  const auto node = static_cast<size_t>(camera.node);
  return {MakeCameraView(camera, state.nodes()[node], width, height),
          MakeCameraView(camera, state.previous_nodes()[node], width, height)};
}

void SetLens(const SceneState& state, const Lens& lens, CameraPair* cameras) {
  cameras->now.lens_radius = LensRadius(lens, cameras->now);
  cameras->before.lens_radius = LensRadius(lens, cameras->before);
  if (cameras->now.lens_radius <= 0.0f && cameras->before.lens_radius <= 0.0f) {
    return;
  }
  const bool given = lens.focus > 0.0f;
  cameras->now.inverse_focus = 1.0f / (given ? lens.focus : FindFocus(state, cameras->now, false));
  cameras->before.inverse_focus =
      1.0f / (given ? lens.focus : FindFocus(state, cameras->before, true));
}

bool AnyTransmission(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const Material& material) { return material.transmission > 0.0f; });
}

}  // namespace stillray::render
