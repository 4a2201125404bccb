// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Replaces embedded shaders by files from a folder: for testing a shader change without rebuilding
/// the program, on machines without a compiler.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray::gpu {

/// The environment variable with the path of the folder; unset or empty: no replacement.
inline constexpr const char* kShaderFolderVariable = "STILLRAY_SHADER_DIR";

/// The content of the shader's file in the folder.
/// \param code  of an embedded shader
/// \return empty without a folder or file; kNotFound: the variable is not the path of a folder;
///     kBadData: the file is not SPIR-V
Result<std::vector<uint32_t>> ReplacementOf(std::span<const uint32_t> code);

/// The name of an embedded shader; empty for other code.
std::string EmbeddedNameOf(std::span<const uint32_t> code);

/// Names of the shaders that are replaced by a file in the folder, in alphabetical order.
std::vector<std::string> ReplacedShaders();

}  // namespace stillray::gpu
