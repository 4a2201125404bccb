// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The inputs of tracing one frame; read-only for all threads.
#pragma once

#include "render/accel.h"
#include "render/lens.h"
#include "render/lights.h"
#include "render/sampler.h"
#include "render/scene_state.h"
#include "render/surface.h"
#include "stillray/render.h"

namespace stillray::render {

struct TraceContext {
  const SceneState& state;
  const BsdfTables& bsdfs;
  const LightSet& lights;
  const Accel& accel;
  RenderSettings settings;
  CameraView camera;
  CameraView previous_camera;
  /// Every deflected ray counts as a bounce: after its last bounce, a path can reach an emitter
  /// only with its next ray.
  bool ends_are_opaque = false;
  LensArrays lens{};
  /// Light transmitted by glass, and light from behind alpha-blended surfaces, is stored in
  /// separate signals.
  bool separates_transmission = false;
  bool filters_textures = false;  ///< FiltersTextures; ignored by references
};

/// Adds the duration of its lifetime to *sum_ms, in milliseconds.
class PhaseTimer {
 public:
  explicit PhaseTimer(double* sum_ms);
  ~PhaseTimer();
  PhaseTimer(const PhaseTimer&) = delete;
  PhaseTimer& operator=(const PhaseTimer&) = delete;

 private:
  double* sum_ms_;
  int64_t start_ns_;
};

}  // namespace stillray::render
