// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The two ways of tracing rays on a device. All other code is the same.
#pragma once

#include <cstdint>

namespace stillray::render {

enum class TracingWay : uint8_t {
  kAuto,      ///< hardware if a GPU supports it, else compute
  kHardware,  ///< VK_KHR_ray_tracing_pipeline
  kCompute,   ///< stillray's BVH, traversed by compute shaders: on any device
};

}  // namespace stillray::render
