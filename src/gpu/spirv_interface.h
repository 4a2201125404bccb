// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a compiled shader needs from its host, read from its SPIR-V.
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
  std::vector<uint32_t> path;  ///< its number in the block, then in the structure that this is, ...
  std::string type;            ///< "int", "float[4]", "vec4[]": of unknown length
  uint32_t offset = 0;         ///< in bytes from the start of the block
  uint32_t bytes = 0;          ///< 0: of unknown length
};

enum class BindingKind : uint8_t { kSampledImage, kStorageImage, kUniformBlock, kStorageBlock };

/// A resource that the entry point, or a function that it calls, uses.
struct ShaderBinding {
  uint32_t set = 0;
  uint32_t binding = 0;
  BindingKind kind = BindingKind::kSampledImage;
  bool reads = false;
  bool writes = false;  ///< atomic operations read and write
  // Of images:
  std::string texels;     ///< "float", "uint", "int"
  std::string format;     ///< as in GLSL: "rgba16f"; empty: any
  bool is_array = false;  ///< a view of layers
  // Of blocks:
  std::vector<BlockMember> members;  ///< structures are replaced by their members
};

struct SpecialisationConstant {
  uint32_t id = 0;
  std::string type;    ///< "bool", "int", "uint", "float"
  uint32_t value = 0;  ///< its default; of bool 0 or 1
};

struct ShaderInterface {
  std::array<uint32_t, 3> local_size = {1, 1, 1};  ///< invocations of a workgroup
  std::vector<ShaderBinding> bindings;             ///< by set and binding
  std::vector<BlockMember> push;                   ///< push constants
  std::vector<SpecialisationConstant> constants;   ///< by id
  uint32_t shared_bytes = 0;  ///< shared memory of a workgroup, with the given constants
};

/// Reads a module with one entry point, a compute shader of SPIR-V 1.3 or later.
/// \param constants  values of specialisation constants by id; others have their default
/// \return kBadData naming what is damaged or unknown
Result<ShaderInterface> ReadInterface(std::span<const uint32_t> code,
                                      const std::map<uint32_t, uint32_t>& constants = {});

}  // namespace stillray::gpu
