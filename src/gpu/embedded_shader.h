// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Registers an embedded shader. Generated shader sources include only this header, which includes
/// no header that is slow to compile.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stillray::gpu {

/// Registers the name of an embedded shader; generated together with the code by
/// stillray_embed_shader.
class EmbeddedShader {
 public:
  /// \param name  file name in the folder of shader_folder.h, without `.spv`
  /// \param code  SPIR-V with static storage duration
  EmbeddedShader(const char* name, const std::uint32_t* code);
};

}  // namespace stillray::gpu
