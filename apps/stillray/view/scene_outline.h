// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The numbers of elements in a glTF file, read quickly before the long import.
#pragma once

#include <cstddef>
#include <string>

namespace stillray::view {

struct SceneOutline {
  size_t textures = 0;
  size_t meshes = 0;
};

/// Reads only the JSON, at most 64 MiB of it. Errors are ignored here, since the importer reports
/// them: unknown numbers are 0.
SceneOutline OutlineOf(const std::string& path);

/// "14 textures and 251 meshes"; empty if all are unknown.
std::string ToText(const SceneOutline& outline);

}  // namespace stillray::view
