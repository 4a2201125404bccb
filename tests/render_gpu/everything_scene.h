// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene with everything that a path can meet.
#pragma once

#include "core/random.h"
#include "render/test_scenes.h"

namespace stillray::render {

inline Texture Noise(int width, int height, uint32_t seed) {
  Texture texture;
  texture.width = width;
  texture.height = height;
  for (int i = 0; i < 4 * width * height; ++i) {
    texture.texels.push_back(
        static_cast<uint8_t>(HashCombine(seed, static_cast<uint32_t>(i)) & 255u));
  }
  return texture;
}

inline Transform Pose(vec3 translation, vec4 rotation, vec3 scale) {
  Transform transform;
  transform.translation = translation;
  transform.rotation = rotation;
  transform.scale = scale;
  return transform;
}

inline std::vector<Texture> EverythingTextures() {
  std::vector<Texture> textures = {Noise(64, 64, 1), Noise(16, 9, 2), Noise(7, 13, 3)};
  textures[2].wrap_u = Wrap::kMirror;
  return textures;
}

// One for each extension of glTF's materials, with textures 0 to 2.
inline std::vector<Material> LayeredMaterials() {
  std::vector<Material> materials;
  Material specular = Lambert(vec3(0.2f, 0.4f, 0.8f));
  specular.ior = 1.6f;
  specular.roughness = 0.4f;
  specular.specular = 0.8f;
  specular.specular_color = vec3(3, 1, 0.5f);
  specular.specular_texture.texture = 0;
  specular.specular_color_texture.texture = 1;
  materials.push_back(specular);
  Material coated = Metal(vec3(0.9f, 0.3f, 0.2f), 0.5f);
  coated.normal_texture.texture = 2;
  coated.normal_scale = 0.4f;
  coated.clearcoat = 0.9f;
  coated.clearcoat_roughness = 0.3f;
  coated.clearcoat_texture.texture = 1;
  materials.push_back(coated);
  coated.clearcoat_roughness = 0.6f;
  coated.clearcoat_roughness_texture.texture = 0;
  coated.clearcoat_normal_texture.texture = 1;
  coated.clearcoat_normal_scale = 0.3f;
  materials.push_back(coated);
  Material coated_sheet = Glass(1.5f, 0.0f);
  coated_sheet.solid = false;
  coated_sheet.clearcoat = 1.0f;
  materials.push_back(coated_sheet);
  Material coated_glass = Glass(1.4f, 0.3f);
  coated_glass.clearcoat = 1.0f;
  coated_glass.clearcoat_roughness = 0.5f;
  materials.push_back(coated_glass);
  Material cloth = Lambert(vec3(0.3f, 0.1f, 0.4f));
  cloth.sheen_color = vec3(0.9f, 0.6f, 1.0f);
  cloth.sheen_roughness = 0.9f;
  cloth.sheen_color_texture.texture = 0;
  cloth.sheen_roughness_texture.texture = 1;
  cloth.clearcoat = 0.4f;
  cloth.clearcoat_roughness = 0.5f;
  materials.push_back(cloth);
  Material leaf = Lambert(vec3(0.2f, 0.5f, 0.1f));
  leaf.ior = 1.5f;
  leaf.diffuse_transmission = 0.8f;
  leaf.diffuse_transmission_color = vec3(0.9f, 1.0f, 0.4f);
  leaf.diffuse_transmission_texture.texture = 0;
  leaf.diffuse_transmission_color_texture.texture = 1;
  materials.push_back(leaf);
  leaf.solid = true;
  leaf.attenuation_color = vec3(0.9f, 0.5f, 0.4f);
  leaf.attenuation_distance = 0.3f;
  leaf.sheen_color = vec3(0.5f);
  leaf.sheen_roughness = 0.4f;
  leaf.multiscatter_color = vec3(0.5f, 0.9f, 0.2f);
  leaf.scatter_anisotropy = -0.3f;
  materials.push_back(leaf);
  Material brushed = Metal(vec3(0.9f, 0.7f, 0.4f), 0.25f);
  brushed.anisotropy = 0.8f;
  brushed.anisotropy_rotation = 0.6f;
  brushed.normal_texture.texture = 2;
  brushed.normal_scale = 0.3f;
  materials.push_back(brushed);
  brushed.metallic = 0.4f;
  brushed.normal_texture.texture = -1;
  brushed.anisotropy_texture.texture = 0;
  brushed.clearcoat = 0.3f;
  materials.push_back(brushed);
  Material beetle = Metal(vec3(0.7f, 0.6f, 0.5f), 0.3f);
  beetle.metallic = 0.6f;
  beetle.iridescence = 0.9f;
  beetle.iridescence_ior = 1.6f;
  beetle.iridescence_thickness_max = 700.0f;
  beetle.iridescence_texture.texture = 1;
  beetle.iridescence_thickness_texture.texture = 0;
  beetle.anisotropy = 0.5f;
  materials.push_back(beetle);
  Material bubble = Glass(1.4f, 0.0f);
  bubble.solid = false;
  bubble.iridescence = 1.0f;
  bubble.iridescence_thickness_max = 350.0f;
  materials.push_back(bubble);
  Material vase = Glass(1.5f, 0.3f);
  vase.iridescence = 0.8f;
  vase.iridescence_ior = 1.9f;
  vase.iridescence_thickness_max = 300.0f;
  vase.clearcoat = 0.2f;
  vase.multiscatter_color = vec3(0.9f, 0.6f, 0.3f);
  vase.scatter_anisotropy = 0.6f;
  vase.attenuation_color = vec3(0.3f, 0.4f, 0.5f);
  vase.attenuation_distance = 0.8f;
  materials.push_back(vase);
  return materials;
}

// The sphere with texture coordinates and with tangents around its vertical axis.
inline Mesh TexturedSphere(vec3 centre, float radius, int subdivisions) {
  Mesh mesh = FacetedSphere(centre, radius, subdivisions);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 offset = mesh.positions[i] - centre;
    mesh.uv[0].push_back(vec2(offset) / radius);
    const vec3 around = glm::cross(vec3(0, 1, 0), mesh.normals[i]);
    mesh.tangents.push_back(vec4(glm::normalize(around), 1));
  }
  return mesh;
}

// One of everything that guides depend on: textures of each kind, normal maps with tangents and
// without, cut-out and blended layers, glass of all kinds, mirrored and moving instances, a moving
// camera, emitters seen from both sides.
inline Scene EverythingScene() {
  SceneBuilder builder;
  builder.scene.textures = EverythingTextures();
  const auto panel = [&](float x, float y) {
    return Quad(vec3(x, y, -6), vec3(1.6f, 0, 0.3f), vec3(0.1f, 1.6f, 0));
  };
  Material textured = Lambert(vec3(0.8f, 0.7f, 0.6f));
  textured.ior = 1.5f;
  textured.base_color_texture.texture = 0;
  textured.metallic = 1.0f;
  textured.metallic_roughness_texture.texture = 1;
  textured.normal_texture.texture = 2;
  textured.normal_scale = 0.5f;
  builder.Add(panel(-4, 0.5f), textured);
  Mesh with_tangents = panel(-2, 0.5f);
  with_tangents.tangents.assign(4, vec4(glm::normalize(vec3(1.6f, 0, 0.3f)), -1));
  builder.Add(with_tangents, textured, Pose(vec3(0), vec4(0, 0, 0, 1), vec3(1, 1, 1.2f)));
  Material cut = Lambert(vec3(0.9f, 0.2f, 0.2f));
  cut.base_color_texture.texture = 1;
  cut.alpha_mode = AlphaMode::kMask;
  builder.Add(panel(0, 0.5f), cut);
  Material blended = cut;
  blended.alpha_mode = AlphaMode::kBlend;
  for (int i = 0; i < 3; ++i) {
    builder.Add(panel(2, 0.5f), blended, At(vec3(0, 0, -0.5f * static_cast<float>(i))));
  }
  const float roughnesses[] = {0.0f, 0.5f, 0.3f, 0.0f};
  for (int i = 0; i < 4; ++i) {
    Material glass = Glass(1.3f + 0.1f * static_cast<float>(i), roughnesses[i]);
    glass.solid = i < 2;
    glass.base_color = vec4(0.9f, 0.8f, 0.3f, 1);
    builder.Add(FacetedSphere(vec3(0), 0.7f, 2), glass,
                At(vec3(-3 + 2 * static_cast<float>(i), -1.3f, -5)));
  }
  const int moving = builder.Add(
      FacetedSphere(vec3(0), 0.6f, 2), Metal(vec3(0.9f, 0.6f, 0.3f), 0.3f),
      Pose(vec3(0, -0.3f, -4), Rotation(glm::normalize(vec3(1, 2, 3)), 1), vec3(-1, 0.7f, 1)));
  builder.Move(builder.InstanceNode(moving), vec3(0.4f, 0.2f, -0.3f));
  for (int i = 0; i < static_cast<int>(LayeredMaterials().size()); ++i) {
    const float turn = 0.9f * static_cast<float>(i);
    builder.Add(TexturedSphere(vec3(0), 0.4f, 2), LayeredMaterials()[static_cast<size_t>(i)],
                At(vec3(3 * std::cos(turn), 2 * std::sin(turn), -4.5f)));
  }
  Material light = Emitter(vec3(3, 2, 1));
  light.emissive_texture.texture = 1;
  builder.Add(panel(-4, -3), light);
  Mesh back = panel(2.4f, -3);
  std::swap(back.indices[1], back.indices[2]);
  std::swap(back.indices[4], back.indices[5]);
  builder.Add(back, light);
  light.double_sided = true;
  builder.Add(back, light, At(vec3(-1.8f, 0, 0)));
  builder.Add(Quad(vec3(-20, -20, -12), vec3(40, 0, 0), vec3(0, 28, 0)), Lambert(vec3(0.4f)));
  builder.Move(0, vec3(0.2f, -0.1f, 0.3f));
  return builder.scene;
}

}  // namespace stillray::render
