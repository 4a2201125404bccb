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

/// Times, memory and device of a traced frame, copied: the renderer may already trace another.
struct Tracing {
  double milliseconds = 0;  ///< wall time
  double fixed_ms = 0;      ///< part of it that does not depend on the samples
  std::vector<StageTime> stages;
  size_t memory_bytes = 0;  ///< of the renderer
  std::string place;        ///< device that traced
  std::string remark;       ///< why the CPU traced instead of the device; empty: it did not
};

/// \param tracing  [out] valid if the frame was traced
Status TraceFrame(const RenderSettings& settings, const RenderMoment& moment,
                  const RenderProgress& keep_going, DeviceRenderer* renderer, Frame* frame,
                  Tracing* tracing);

}  // namespace stillray::view
