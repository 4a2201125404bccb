// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a glTF file says of its own size, before the long work of reading it begins.
#pragma once

#include <cstddef>
#include <string>

namespace stillray::view {

struct SceneOutline {
  size_t textures = 0;
  size_t meshes = 0;
};

/// Looks at the list of contents alone, 64 MiB of it at most. Whatever is wrong with the file, all
/// that cannot be told is 0: what is to be said of it is the importer's to say.
SceneOutline OutlineOf(const std::string& path);

/// "14 textures and 251 meshes"; empty if nothing is known.
std::string ToText(const SceneOutline& outline);

}  // namespace stillray::view
