// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/scene.h"

#include <glm/common.hpp>

#include "scene/deform.h"

namespace stillray {

size_t Scene::TriangleCount() const {
  size_t count = 0;
  for (const Instance& instance : instances) {
    count += meshes[static_cast<size_t>(instance.mesh)].indices.size() / 3;
  }
  return count;
}

Aabb SceneBounds(const Scene& scene, double seconds) {
  const std::vector<mat4> worlds = NodeTransforms(scene, seconds);
  Aabb bounds;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    const bool deforms = MayDeform(scene, instance);
    DeformedMesh deformed;
    if (deforms) {
      Deform(mesh, PoseOf(scene, instance, worlds, seconds), &deformed);
    }
    const mat4 world = instance.skin >= 0 ? mat4(1.0f) : worlds[static_cast<size_t>(instance.node)];
    for (const vec3& position : deforms ? deformed.positions : mesh.positions) {
      const vec3 p(world * vec4(position, 1.0f));
      bounds.min = glm::min(bounds.min, p);
      bounds.max = glm::max(bounds.max, p);
    }
  }
  return bounds;
}

}  // namespace stillray
