// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Uniform buffers as storage buffers, for drivers that run on the CPU.
///
/// Mesa's compiles a shader again, in seconds, for every value in a uniform buffer that decides a
/// branch; values in storage buffers it reads. Devices keep uniform buffers: many read them faster,
/// and offer too few storage buffers to replace them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace stillray::gpu {

/// Makes the uniform blocks of a shader storage blocks that are only read, with the same bindings
/// and the same layout of their members.
/// \param code  SPIR-V of version 1.3 or later, where uniform blocks have a storage class of their
///     own. Code that ends within an instruction is returned unchanged
std::vector<uint32_t> WithStorageBlocks(std::span<const uint32_t> code);

}  // namespace stillray::gpu
