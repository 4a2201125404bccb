// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The path tracer on the device that also denoises.
#pragma once

#include <memory>

#include "log_parts.h"
#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray {

/// A renderer on the device, the CPU too.
/// \return also kUnsupported: the device lacks something, or the scene does not fit into it
Result<std::unique_ptr<Renderer>> CreateRendererOn(const Device& device, const Scene& scene,
                                                   const RenderSettings& settings);

/// The device's own times of a frame, for a renderer that is not on the CPU.
std::vector<LoggedStage> TraceStages(const RenderTimings& timings);

}  // namespace stillray
