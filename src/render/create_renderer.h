// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Renderers with a replaced or wrapped Accel, for benchmarks.
#pragma once

#include <functional>
#include <memory>

#include "render/accel.h"
#include "render/trace_context.h"

namespace stillray::render {

/// Returns the Accel that replaces the given one.
using WrapAccel = std::function<std::unique_ptr<Accel>(std::unique_ptr<Accel>)>;

/// Renderer::Create with a replaced Accel.
/// \param wrap_accel  called once, with the scene's Accel; if empty, the renderer uses the scene's
///     Accel
Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 const WrapAccel& wrap_accel = {},
                                                 const KeepGoing& keep_going = {});

}  // namespace stillray::render
