// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene ready to be traced, and the renderer settings that a view stands for.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/trace_device.h"
#include "stillray/render.h"
#include "stillray/scene.h"
#include "view/view_settings.h"

namespace stillray::view {

struct SceneRequest {
  std::string scene;        ///< path of a .gltf or .glb file, or "builtin:NAME"
  std::string environment;  ///< path of an .hdr or .exr file; empty: as the scene says
};

struct LoadedScene {
  SceneRequest request;
  std::unique_ptr<Scene> scene;  ///< stands still in memory: the renderer points to it
  std::unique_ptr<DeviceRenderer> renderer;
};

/// What is being done while a scene loads.
struct LoadPhase {
  std::string what;      ///< "building the BVH of 1442338 triangles"
  int step = 0;          ///< of `steps`, from 0
  int steps = 1;         ///< the same from the first to the last phase of a scene
  double fraction = -1;  ///< of this step, 0..1; below 0: not known
};

/// Told at the beginning of every phase, and within it where it can tell how far it is.
/// \return false to give the scene up
using LoadReport = std::function<bool(const LoadPhase& phase)>;

/// \param device  where the scene is to be traced; the CPU where that cannot be
/// \return what LoadScene, ReadImage and Renderer::Create return; kInvalidArgument for an
///         environment that is no radiance; kCancelled
Result<LoadedScene> LoadForView(const SceneRequest& request, const ViewSettings& settings,
                                const LoadReport& report, const Device& device = Device());

/// Size of the picture for an area of the screen, each side at least 16.
void PictureSize(const ViewSettings& settings, float scale, int* width, int* height);
RenderSettings RenderSettingsFor(const ViewSettings& settings, const SampleRate& rate, float scale);
}  // namespace stillray::view
