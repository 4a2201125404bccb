// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Free memory of a device, from which buffer sizes are derived.
#pragma once

#include <cstdint>

#include "gpu/device.h"

namespace stillray::gpu {

/// Bytes that this process can still allocate in the largest device-local heap: the driver's
/// estimate (VK_EXT_memory_budget), which includes other processes. Without the extension, half of
/// the heap size, since the heap's usage is unknown.
uint64_t FreeMemory(const Device& device);

}  // namespace stillray::gpu
