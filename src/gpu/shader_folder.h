// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Shaders from a folder in place of those in the program: for trying a change of a shader without
/// building the program, on a machine that has no compiler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray::gpu {

/// The environment variable that names the folder; unset or empty: there is none.
inline constexpr const char* kShaderFolderVariable = "STILLRAY_SHADER_DIR";

/// The content of the shader's file in the folder.
/// \param code  of an embedded shader
/// \return empty if there is no folder or no such file; kNotFound: the variable names no folder;
///     kBadData: the file is not SPIR-V
Result<std::vector<uint32_t>> ReplacementOf(std::span<const uint32_t> code);

/// The name of an embedded shader; empty for other code.
std::string EmbeddedNameOf(std::span<const uint32_t> code);

/// Names of the shaders that have a file in the folder, in alphabetic order.
std::vector<std::string> ReplacedShaders();

}  // namespace stillray::gpu
