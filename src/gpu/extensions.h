// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <span>

#include "gpu/functions.h"

namespace stillray::gpu {

/// Whether a device supports all of these extensions; false if the query fails.
bool HasExtensions(const InstanceFunctions& functions, VkPhysicalDevice device,
                   std::span<const char* const> wanted);

}  // namespace stillray::gpu
