// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser's bench on a Vulkan device.
#pragma once

#include <memory>

#include "benchmarks/device_bench.h"
#include "gpu/device.h"

namespace stillray::vulkan {

/// Bytes that a filter of five levels must read and write per pixel at least: those of the guides,
/// and those of each signal.
inline constexpr int kLeastSharedBytes = 62;
inline constexpr int kLeastSignalBytes = 192;

/// See BenchOnDevice; `device` of the result is left empty.
Result<DeviceBenchResult> RunDeviceBench(const std::shared_ptr<gpu::Device>& device,
                                         const DeviceBenchOptions& options);

}  // namespace stillray::vulkan
