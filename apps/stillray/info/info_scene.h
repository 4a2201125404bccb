// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Describes a scene for `stillray info`.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "stillray/scene.h"
#include "stillray/status.h"

namespace stillray {

/// Whether `spec` is a scene rather than an image: "builtin:NAME", or a name that ends in .gltf or
/// .glb.
bool LooksLikeScene(const std::string& spec);

std::string SceneText(const std::string& spec, const Scene& scene);
nlohmann::ordered_json SceneJson(const std::string& spec, const Scene& scene);

}  // namespace stillray
