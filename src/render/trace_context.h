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
  /// Only undeflected rays do not count as a bounce: after its last bounce, a path hits an emitter
  /// with its next ray or not at all.
  bool ends_are_opaque = false;
  LensArrays lens{};
  /// Light that glass transmits, and that of surfaces behind alpha-blended ones, has signals of its
  /// own.
  bool separates_transmission = false;
};

/// Adds its lifetime to a sum of milliseconds.
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
