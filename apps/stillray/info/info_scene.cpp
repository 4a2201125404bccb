// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "info/info_scene.h"

#include <cstdint>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/lower_case.h"
#include "core/printable.h"
#include "render/scene_state.h"

namespace stillray {

namespace {

/// Counts in addition to the sizes of the scene's lists.
struct SceneCounts {
  uint64_t stored_triangles = 0;    ///< each mesh counted once
  uint64_t emissive_triangles = 0;  ///< including all instances
  uint64_t geometry_bytes = 0;
  uint64_t texture_bytes = 0;
  uint64_t emissive_materials = 0;
  uint64_t transmissive_materials = 0;
  uint64_t scattering_materials = 0;  ///< materials of solids with a scattering medium
  uint64_t cutout_materials = 0;
  uint64_t skinned = 0;  ///< number of instances
  uint64_t morphed = 0;  ///< number of instances
};

template <typename T>
uint64_t BytesOf(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

const Material* MaterialOf(const Scene& scene, const Mesh& mesh) {
  const bool known =
      mesh.material >= 0 && static_cast<size_t>(mesh.material) < scene.materials.size();
  return known ? &scene.materials[static_cast<size_t>(mesh.material)] : nullptr;
}

SceneCounts Count(const Scene& scene) {
  SceneCounts counts;
  for (const Mesh& mesh : scene.meshes) {
    counts.stored_triangles += mesh.indices.size() / 3;
    counts.geometry_bytes += BytesOf(mesh.positions) + BytesOf(mesh.normals) +
                             BytesOf(mesh.tangents) + BytesOf(mesh.uv[0]) + BytesOf(mesh.uv[1]) +
                             BytesOf(mesh.colors) + BytesOf(mesh.indices) + BytesOf(mesh.joints) +
                             BytesOf(mesh.weights);
    for (const MorphTarget& target : mesh.targets) {
      counts.geometry_bytes += BytesOf(target.vertices) + BytesOf(target.positions) +
                               BytesOf(target.normals) + BytesOf(target.tangents);
    }
  }
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    const Material* material = MaterialOf(scene, mesh);
    counts.skinned += instance.skin >= 0 ? 1 : 0;
    counts.morphed += mesh.targets.empty() ? 0 : 1;
    if (material != nullptr && material->emits()) {
      counts.emissive_triangles += mesh.indices.size() / 3;
    }
  }
  for (const Texture& texture : scene.textures) {
    counts.texture_bytes += texture.texels.size();
  }
  for (const Material& material : scene.materials) {
    counts.emissive_materials += material.emits();
    counts.transmissive_materials += material.transmission > 0;
    counts.scattering_materials += render::ScattersInside(material);
    counts.cutout_materials += material.alpha_mode != AlphaMode::kOpaque;
  }
  return counts;
}

const char* TypeName(LightType type) {
  switch (type) {
    case LightType::kPoint:
      return "point";
    case LightType::kSpot:
      return "spot";
    case LightType::kDirectional:
      return "directional";
  }
  return "?";
}

double Degrees(float radians) {
  return static_cast<double>(radians) * 180.0 / std::numbers::pi;
}

std::string Mebibytes(uint64_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / (1 << 20));
}

/// The name as a single line without control characters, since names come from files.
std::string WithoutControls(const std::string& name) {
  std::string text = name;
  for (char& c : text) {
    c = static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
  }
  return text;
}

std::string VectorText(vec3 v) {
  return fmt::format("({:.5g}, {:.5g}, {:.5g})", v.x, v.y, v.z);
}

std::string EnvironmentText(const Environment& environment) {
  const std::string radiance = VectorText(environment.radiance);
  if (!environment.map.empty()) {
    return fmt::format("map of {} x {} pixels times {}", environment.map.width(),
                       environment.map.height(), radiance);
  }
  const vec3 r = environment.radiance;
  return r.x == 0 && r.y == 0 && r.z == 0 ? "none" : "constant " + radiance;
}

bool IsEmpty(const Aabb& bounds) {
  return !(bounds.min.x <= bounds.max.x);
}

nlohmann::ordered_json VectorJson(vec3 v) {
  return nlohmann::ordered_json::array({v.x, v.y, v.z});
}

nlohmann::ordered_json CamerasJson(const Scene& scene) {
  auto cameras = nlohmann::ordered_json::array();
  for (const Camera& camera : scene.cameras) {
    nlohmann::ordered_json json;
    json["name"] = camera.name;
    json["yfov_degrees"] = Degrees(camera.yfov);
    json["aspect"] = camera.aspect > 0 ? nlohmann::ordered_json(camera.aspect) : nullptr;
    cameras.push_back(std::move(json));
  }
  return cameras;
}

nlohmann::ordered_json LightsJson(const Scene& scene) {
  auto lights = nlohmann::ordered_json::array();
  for (const PunctualLight& light : scene.lights) {
    lights.push_back({{"name", light.name},
                      {"type", TypeName(light.type)},
                      {"intensity", VectorJson(light.intensity)}});
  }
  return lights;
}

}  // namespace

bool LooksLikeScene(const std::string& spec) {
  const std::string lower = LowerCase(spec);
  return spec.starts_with("builtin:") || lower.ends_with(".gltf") || lower.ends_with(".glb") ||
         lower.ends_with(".obj");
}

std::string SceneText(const std::string& spec, const Scene& scene) {
  const SceneCounts counts = Count(scene);
  const Aabb bounds = SceneBounds(scene, 0);
  std::string text =
      fmt::format("{}: scene{}\n", Printable(spec),
                  scene.name.empty() ? "" : " \"" + WithoutControls(scene.name) + "\"");
  const auto line = [&](const char* what, const std::string& value) {
    text += fmt::format("{:<20}{}\n", what, value);
  };
  line("triangles", fmt::format("{} ({} stored, {})", scene.TriangleCount(),
                                counts.stored_triangles, Mebibytes(counts.geometry_bytes)));
  line("emissive triangles", fmt::format("{}", counts.emissive_triangles));
  line("instances", fmt::format("{} of {} meshes", scene.instances.size(), scene.meshes.size()));
  if (counts.skinned + counts.morphed != 0) {
    line("deforming",
         fmt::format("{} instances by skins, {} by morph targets", counts.skinned, counts.morphed));
  }
  line("nodes", fmt::format("{}", scene.nodes.size()));
  line("materials",
       fmt::format("{} ({} emissive, {} transmissive, {} scattering, {} with alpha)",
                   scene.materials.size(), counts.emissive_materials, counts.transmissive_materials,
                   counts.scattering_materials, counts.cutout_materials));
  line("textures", fmt::format("{} ({})", scene.textures.size(), Mebibytes(counts.texture_bytes)));
  line("bounds",
       IsEmpty(bounds) ? "empty" : VectorText(bounds.min) + " - " + VectorText(bounds.max));
  line("environment", EnvironmentText(scene.environment));
  line("animation",
       scene.animation.empty()
           ? "none"
           : fmt::format("{:.5g} s, {} channels", scene.AnimationLength(), scene.animation.size()));
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    const Camera& camera = scene.cameras[i];
    line("camera", fmt::format("{} \"{}\", {:.4g} degrees high{}", i, WithoutControls(camera.name),
                               Degrees(camera.yfov),
                               camera.aspect > 0 ? fmt::format(", aspect {:.4g}", camera.aspect)
                                                 : std::string()));
  }
  for (const PunctualLight& light : scene.lights) {
    line("light", fmt::format("{} \"{}\", intensity {}", TypeName(light.type),
                              WithoutControls(light.name), VectorText(light.intensity)));
  }
  for (const std::string& warning : scene.warnings) {
    line("warning", WithoutControls(warning));
  }
  return text;
}

nlohmann::ordered_json SceneJson(const std::string& spec, const Scene& scene) {
  const SceneCounts counts = Count(scene);
  const Aabb bounds = SceneBounds(scene, 0);
  nlohmann::ordered_json json;
  json["file"] = spec;
  json["kind"] = "scene";
  json["name"] = scene.name;
  json["triangles"] = scene.TriangleCount();
  json["stored_triangles"] = counts.stored_triangles;
  json["emissive_triangles"] = counts.emissive_triangles;
  json["geometry_bytes"] = counts.geometry_bytes;
  json["instances"] = scene.instances.size();
  json["meshes"] = scene.meshes.size();
  json["skinned_instances"] = counts.skinned;
  json["morphed_instances"] = counts.morphed;
  json["nodes"] = scene.nodes.size();
  json["materials"] = scene.materials.size();
  json["emissive_materials"] = counts.emissive_materials;
  json["transmissive_materials"] = counts.transmissive_materials;
  json["scattering_materials"] = counts.scattering_materials;
  json["alpha_materials"] = counts.cutout_materials;
  json["textures"] = scene.textures.size();
  json["texture_bytes"] = counts.texture_bytes;
  json["bounds"] = IsEmpty(bounds) ? nlohmann::ordered_json(nullptr)
                                   : nlohmann::ordered_json{{"min", VectorJson(bounds.min)},
                                                            {"max", VectorJson(bounds.max)}};
  json["environment"] = {{"radiance", VectorJson(scene.environment.radiance)},
                         {"map_width", scene.environment.map.width()},
                         {"map_height", scene.environment.map.height()}};
  json["animation_seconds"] = scene.AnimationLength();
  json["animation_channels"] = scene.animation.size();
  json["cameras"] = CamerasJson(scene);
  json["lights"] = LightsJson(scene);
  json["warnings"] = scene.warnings;
  return json;
}

}  // namespace stillray
