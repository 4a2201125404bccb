// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Free memory of a device, to choose the sizes of buffers by.
#pragma once

#include <cstdint>

#include "gpu/device.h"

namespace stillray::gpu {

/// Bytes that this program can still allocate in the device's own memory: of its largest heap, the
/// driver's estimate (VK_EXT_memory_budget), which counts other programs too. Where the driver has
/// none, half of the heap: what else is in it is unknown.
uint64_t FreeMemory(const Device& device);

}  // namespace stillray::gpu
