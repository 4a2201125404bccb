// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Uniform buffers bound as storage buffers, for software drivers.
///
/// Mesa's software driver recompiles a shader, in seconds, for every uniform buffer value that
/// controls a branch; values in storage buffers are read at run time. GPUs keep uniform buffers:
/// many read them faster, and support too few storage buffers to replace them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace stillray::gpu {

/// Converts the uniform blocks of a shader to read-only storage blocks with unchanged bindings and
/// member layouts.
/// \param code  SPIR-V of version 1.3 or later, which has separate storage classes for uniform and
///     storage blocks. Code that ends within an instruction is returned unchanged
std::vector<uint32_t> WithStorageBlocks(std::span<const uint32_t> code);

}  // namespace stillray::gpu
