// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene prepared for tracing, and the renderer settings of a view.
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
  std::string scene;        ///< path of a .gltf, .glb or .obj file, or "builtin:NAME"
  std::string environment;  ///< path of an .hdr or .exr file; empty: the environment of the scene
};

struct LoadedScene {
  SceneRequest request;
  std::unique_ptr<Scene> scene;  ///< at a fixed address, since the renderer references it
  std::unique_ptr<DeviceRenderer> renderer;
};

/// The current phase of loading a scene.
struct LoadPhase {
  std::string what;      ///< "building the BVH of 1442338 triangles"
  int step = 0;          ///< of `steps`, from 0
  int steps = 1;         ///< constant over all phases of a scene
  double fraction = -1;  ///< progress of this step, 0..1; below 0: unknown
};

/// Called at the beginning of every phase, and within phases with known progress.
/// \return false to cancel loading
using LoadReport = std::function<bool(const LoadPhase& phase)>;

/// \param device  device that traces the scene; falls back to the CPU
/// \return errors of LoadScene, ReadImage and Renderer::Create; kInvalidArgument for an environment
///     that does not contain radiance; kCancelled
Result<LoadedScene> LoadForView(const SceneRequest& request, const ViewSettings& settings,
                                const LoadReport& report, const Device& device = Device());

/// Image size for an area of the screen, each side at least 16 pixels.
void PictureSize(const ViewSettings& settings, float scale, int* width, int* height);
RenderSettings RenderSettingsFor(const ViewSettings& settings, const SampleRate& rate, float scale);
}  // namespace stillray::view
