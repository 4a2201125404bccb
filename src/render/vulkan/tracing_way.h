// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The two ways in which rays are traced on a device. All else is the same code.
#pragma once

#include <cstdint>

namespace stillray::render {

enum class TracingWay : uint8_t {
  kAuto,      ///< hardware where a GPU offers it, else compute
  kHardware,  ///< VK_KHR_ray_tracing_pipeline
  kCompute,   ///< our own tree, walked by compute shaders: on any device
};

}  // namespace stillray::render
