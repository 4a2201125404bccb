// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The devices of path tracer and denoiser.
#pragma once

#include "stillray/denoise.hpp"

namespace stillray {

/// The default is the CPU.
struct RenderDevices {
  RenderDevices() = default;
  RenderDevices(const Device& both) : filter(both), tracer(both) {}
  RenderDevices(const Device& filters, const Device& traces) : filter(filters), tracer(traces) {}

  Device filter;
  Device tracer;

  /// Whether the devices can work concurrently: each frame is then traced while the previous frame
  /// is filtered (TraceAhead).
  bool differ() const { return filter.description() != tracer.description(); }
};

}  // namespace stillray
