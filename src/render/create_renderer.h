// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Renderers with another Accel, for benchmarks.
#pragma once

#include <functional>
#include <memory>

#include "render/accel.h"
#include "render/trace_context.h"

namespace stillray::render {

/// Returns the Accel to trace with in place of the given one.
using WrapAccel = std::function<std::unique_ptr<Accel>(std::unique_ptr<Accel>)>;

/// Renderer::Create with a given Accel.
/// \param wrap_accel  called once, with the scene's Accel; empty: the renderer uses that one
Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 const WrapAccel& wrap_accel = {},
                                                 const KeepGoing& keep_going = {});

}  // namespace stillray::render
