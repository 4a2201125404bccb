// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What every imported scene must keep.
#pragma once

#include "core/check.h"
#include "scene/material_textures.h"
#include "stillray/scene.h"

namespace stillray {

inline void CheckMesh(const Scene& scene, const Mesh& mesh) {
  const size_t vertices = mesh.positions.size();
  STILLRAY_CHECK_EQ(mesh.normals.size(), vertices);
  STILLRAY_CHECK(mesh.uv[0].empty() || mesh.uv[0].size() == vertices);
  STILLRAY_CHECK(mesh.uv[1].empty() || mesh.uv[1].size() == vertices);
  STILLRAY_CHECK(mesh.colors.empty() || mesh.colors.size() == vertices);
  STILLRAY_CHECK(mesh.tangents.empty() || mesh.tangents.size() == vertices);
  STILLRAY_CHECK_EQ(mesh.indices.size() % 3, 0u);
  STILLRAY_CHECK(!mesh.indices.empty());
  for (const uint32_t index : mesh.indices) {
    STILLRAY_CHECK_LT(index, vertices);
  }
  for (size_t i = 0; i < vertices; ++i) {
    const float length = glm::length(mesh.normals[i]);
    STILLRAY_CHECK(length > 0.999f && length < 1.001f);
    STILLRAY_CHECK(mesh.positions[i] == mesh.positions[i]);
  }
  STILLRAY_CHECK_LT(static_cast<size_t>(mesh.material), scene.materials.size());
  const Material& material = scene.materials[static_cast<size_t>(mesh.material)];
  STILLRAY_CHECK(material.normal_texture.texture < 0 || !mesh.tangents.empty());
  for (const MaterialTexture& texture : kMaterialTextures) {
    const TextureRef& ref = material.*texture.slot;
    STILLRAY_CHECK_LT(ref.texture, static_cast<int>(scene.textures.size()));
    STILLRAY_CHECK(ref.texture < 0 || mesh.uv[ref.uv_set].size() == vertices);
  }
}

inline void CheckDeformation(const Mesh& mesh) {
  const size_t vertices = mesh.positions.size();
  const size_t joints = static_cast<size_t>(mesh.influences) * vertices;
  STILLRAY_CHECK_EQ(mesh.joints.size(), joints);
  STILLRAY_CHECK_EQ(mesh.weights.size(), joints);
  for (size_t i = 0; i < joints; i += static_cast<size_t>(mesh.influences)) {
    float sum = 0;
    for (size_t k = i; k < i + static_cast<size_t>(mesh.influences); ++k) {
      STILLRAY_CHECK(mesh.weights[k] >= 0.0f);
      sum += mesh.weights[k];
    }
    STILLRAY_CHECK(sum > 0.999f && sum < 1.001f);
  }
  for (const MorphTarget& target : mesh.targets) {
    const size_t moved = target.vertices.size();
    STILLRAY_CHECK(moved == 0 || target.vertices.back() < vertices);
    STILLRAY_CHECK(target.positions.empty() || target.positions.size() == moved);
    STILLRAY_CHECK(target.normals.empty() || target.normals.size() == moved);
    STILLRAY_CHECK(target.tangents.empty() || target.tangents.size() == moved);
  }
}

inline void CheckInstance(const Scene& scene, const Instance& instance) {
  STILLRAY_CHECK_LT(static_cast<size_t>(instance.mesh), scene.meshes.size());
  STILLRAY_CHECK_LT(static_cast<size_t>(instance.node), scene.nodes.size());
  const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
  const size_t weights = scene.nodes[static_cast<size_t>(instance.node)].weights.size();
  STILLRAY_CHECK(mesh.targets.empty() || weights == mesh.targets.size());
  if (instance.skin >= 0) {
    STILLRAY_CHECK_LT(static_cast<size_t>(instance.skin), scene.skins.size());
    const Skin& skin = scene.skins[static_cast<size_t>(instance.skin)];
    STILLRAY_CHECK_EQ(skin.joints.size(), skin.inverse_bind.size());
    for (const uint16_t joint : mesh.joints) {
      STILLRAY_CHECK_LT(size_t{joint}, skin.joints.size());
    }
  }
}

inline void CheckScene(const Scene& scene) {
  STILLRAY_CHECK(!scene.cameras.empty());
  STILLRAY_CHECK(!scene.instances.empty());
  for (const Mesh& mesh : scene.meshes) {
    CheckMesh(scene, mesh);
    CheckDeformation(mesh);
  }
  for (const Texture& texture : scene.textures) {
    STILLRAY_CHECK_EQ(texture.texels.size(),
                      static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height) * 4);
  }
  for (const Instance& instance : scene.instances) {
    CheckInstance(scene, instance);
  }
  for (const double seconds : {0.0, 0.4, scene.AnimationLength(), 1e9}) {
    STILLRAY_CHECK_EQ(NodeTransforms(scene, seconds).size(), scene.nodes.size());
    SceneBounds(scene, seconds);
  }
}

}  // namespace stillray
