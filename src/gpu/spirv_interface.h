// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Reflection of a compiled shader's interface (bindings, push constants, workgroup size) from its
/// SPIR-V.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray::gpu {

/// A member of a block, or of a structure in it.
struct BlockMember {
  std::vector<uint32_t> path;  ///< member index in the block, then in each nested structure
  std::string type;            ///< "int", "float[4]"; "vec4[]" is a runtime array
  uint32_t offset = 0;         ///< in bytes from the start of the block
  uint32_t bytes = 0;          ///< 0: runtime array
};

enum class BindingKind : uint8_t { kSampledImage, kStorageImage, kUniformBlock, kStorageBlock };

/// A resource that is statically used by the entry point or by functions it calls.
struct ShaderBinding {
  uint32_t set = 0;
  uint32_t binding = 0;
  BindingKind kind = BindingKind::kSampledImage;
  bool reads = false;
  bool writes = false;  ///< atomic operations read and write
  // Only for images:
  std::string texels;     ///< "float", "uint", "int"
  std::string format;     ///< GLSL layout qualifier such as "rgba16f"; empty: any format
  bool is_array = false;  ///< array view
  // Only for blocks:
  std::vector<BlockMember> members;  ///< structures are replaced by their members
};

struct SpecialisationConstant {
  uint32_t id = 0;
  std::string type;    ///< "bool", "int", "uint", "float"
  uint32_t value = 0;  ///< default value; 0 or 1 for bool
};

struct ShaderInterface {
  std::array<uint32_t, 3> local_size = {1, 1, 1};  ///< invocations per workgroup
  std::vector<ShaderBinding> bindings;             ///< sorted by set and binding
  std::vector<BlockMember> push;                   ///< push constants
  std::vector<SpecialisationConstant> constants;   ///< sorted by id
  uint32_t shared_bytes = 0;  ///< shared memory of a workgroup, with the given constants
};

/// Reads a module with one entry point, a compute shader of SPIR-V 1.3 or later.
/// \param constants  values of specialisation constants by id; missing ids have their default
/// \return kBadData naming the damaged or unknown part
Result<ShaderInterface> ReadInterface(std::span<const uint32_t> code,
                                      const std::map<uint32_t, uint32_t>& constants = {});

}  // namespace stillray::gpu
