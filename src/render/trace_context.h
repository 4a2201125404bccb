// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What tracing the rays of one frame needs to know; read by all threads, written by none.
#pragma once

#include "render/accel.h"
#include "render/camera.h"
#include "render/lights.h"
#include "render/sampler.h"
#include "render/scene_state.h"
#include "render/surface.h"
#include "stillray/render.h"

namespace stillray::render {

/// How light is found. All three have the same mean as long as both strategies can find it; the
/// single ones exist to show just that.
enum class LightStrategy : uint8_t {
  kBoth,       ///< weighted by multiple importance sampling
  kNextEvent,  ///< rays to lights only (and ideally smooth lobes)
  kScatter,    ///< rays that scatter by chance only (and lights that have no extent)
};

struct TraceContext {
  const SceneState& state;
  const BsdfTables& bsdfs;
  const LightSet& lights;
  const Accel& accel;
  RenderSettings settings;
  LightStrategy strategy = LightStrategy::kBoth;
  CameraView camera;
  CameraView previous_camera;
  /// No surface sends a ray on without counting a bounce, but straight through: a path at its last
  /// bounce meets an emitter by its next ray or not at all.
  bool ends_are_opaque = false;
};

/// Adds the time until it goes to a sum of milliseconds.
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
