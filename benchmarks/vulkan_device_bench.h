// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser's bench on a Vulkan device.
#pragma once

#include <memory>

#include "benchmarks/device_bench.h"
#include "gpu/device.h"

namespace stillray::vulkan {

/// Minimum memory traffic of a filter with five levels in bytes per pixel: for the guides, and per
/// signal.
inline constexpr int kLeastSharedBytes = 62;
inline constexpr int kLeastSignalBytes = 192;

/// See BenchOnDevice; leaves `device` of the result empty.
Result<DeviceBenchResult> RunDeviceBench(const std::shared_ptr<gpu::Device>& device,
                                         const DeviceBenchOptions& options);

}  // namespace stillray::vulkan
