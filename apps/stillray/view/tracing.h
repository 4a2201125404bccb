// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Traces a frame of a view and measures it.
#pragma once

#include <string>
#include <vector>

#include "common/trace_device.h"
#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray::view {

/// Copy of times, memory and device of a traced frame, since the renderer may already trace the
/// next.
struct Tracing {
  double milliseconds = 0;  ///< wall time
  double fixed_ms = 0;      ///< part of milliseconds that is independent of the samples
  std::vector<StageTime> stages;
  size_t memory_bytes = 0;  ///< memory of the renderer
  std::string place;        ///< tracing device
  std::string remark;       ///< reason for a fallback to the CPU; empty: none
};

/// \param tracing  [out] valid if the frame was traced
Status TraceFrame(const RenderSettings& settings, const RenderMoment& moment,
                  const RenderProgress& keep_going, DeviceRenderer* renderer, Frame* frame,
                  Tracing* tracing);

}  // namespace stillray::view
