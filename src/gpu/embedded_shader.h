// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Registers a shader of the program. Every generated source of a shader includes this and nothing
/// else: it includes no header that takes time to compile.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stillray::gpu {

/// The name of a shader that is part of the program: made with its code, by stillray_embed_shader.
class EmbeddedShader {
 public:
  /// \param name  of its file in the folder of shader_folder.h, without `.spv`
  /// \param code  SPIR-V of static storage
  EmbeddedShader(const char* name, const std::uint32_t* code);
};

}  // namespace stillray::gpu
