// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Renderers with one light sampling strategy, for tests, or that record their rays, for
/// benchmarks.
#pragma once

#include <memory>

#include "render/ray_recorder.h"
#include "render/trace_context.h"

namespace stillray::render {

/// Renderer::Create with a light sampling strategy.
/// \param logs  if not null, receives all rays and must outlive the renderer; frames must then be
///     rendered on one thread
Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 LightStrategy strategy, RayLogs* logs = nullptr,
                                                 const KeepGoing& keep_going = {});

}  // namespace stillray::render
