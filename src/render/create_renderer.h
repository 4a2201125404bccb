// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Renderers with a choice of strategy, for tests, or that keep their rays, for benchmarks.
#pragma once

#include <memory>

#include "render/ray_recorder.h"
#include "render/trace_context.h"

namespace stillray::render {

/// Renderer::Create, for one way to find light.
/// \param logs  if not null, must outlive the renderer and gets all its rays; frames must then be
///              rendered on one thread
Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 LightStrategy strategy, RayLogs* logs = nullptr,
                                                 const KeepGoing& keep_going = {});

}  // namespace stillray::render
