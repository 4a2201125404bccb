// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/scene_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "render/lens.h"
#include "scene/material_textures.h"
#include "scene/mesh_tools.h"

namespace stillray::render {
namespace {

Status CheckIndex(const std::string& what, int index, size_t count) {
  if (index >= 0 && static_cast<size_t>(index) < count) {
    return Status::Ok();
  }
  return Status::InvalidArgument(fmt::format("{} is {}, but there are {}", what, index, count));
}

template <typename T>
Status CheckCount(const std::string& mesh, const char* what, const std::vector<T>& values,
                  size_t expected) {
  if (values.empty() || values.size() == expected) {
    return Status::Ok();
  }
  return Status::InvalidArgument(
      fmt::format("{} has {} {}, expected {} as positions", mesh, values.size(), what, expected));
}

Status CheckMesh(const Scene& scene, size_t index) {
  const Mesh& mesh = scene.meshes[index];
  const std::string name = fmt::format("mesh {} (\"{}\")", index, mesh.name);
  const size_t count = mesh.positions.size();
  if (mesh.normals.size() != count) {
    return Status::InvalidArgument(fmt::format("{} has {} normals, expected {} as positions", name,
                                               mesh.normals.size(), count));
  }
  STILLRAY_RETURN_IF_ERROR(CheckCount(name, "tangents", mesh.tangents, count));
  STILLRAY_RETURN_IF_ERROR(CheckCount(name, "uv of set 0", mesh.uv[0], count));
  STILLRAY_RETURN_IF_ERROR(CheckCount(name, "uv of set 1", mesh.uv[1], count));
  STILLRAY_RETURN_IF_ERROR(CheckCount(name, "colours", mesh.colors, count));
  STILLRAY_RETURN_IF_ERROR(
      CheckIndex(name + ": its material", mesh.material, scene.materials.size()));
  if (mesh.indices.size() % 3 != 0) {
    return Status::InvalidArgument(
        fmt::format("{} has {} indices, expected a multiple of 3", name, mesh.indices.size()));
  }
  const auto largest = std::max_element(mesh.indices.begin(), mesh.indices.end());
  if (largest != mesh.indices.end() && *largest >= count) {
    return Status::InvalidArgument(
        fmt::format("{} has the index {}, but {} vertices", name, *largest, count));
  }
  return Status::Ok();
}

Status CheckDeformation(const Scene& scene, size_t index) {
  const Mesh& mesh = scene.meshes[index];
  const std::string name = fmt::format("mesh {} (\"{}\")", index, mesh.name);
  const size_t count = mesh.positions.size();
  const auto joints = static_cast<size_t>(std::max(mesh.influences, 0)) * count;
  if (mesh.influences < 0 || mesh.joints.size() != joints || mesh.weights.size() != joints) {
    return Status::InvalidArgument(
        fmt::format("{} has {} joints and {} weights, expected {} for each of {} vertices", name,
                    mesh.joints.size(), mesh.weights.size(), mesh.influences, count));
  }
  for (const float weight : mesh.weights) {
    if (!(weight >= 0.0f && weight <= 1.0f)) {
      return Status::InvalidArgument(
          fmt::format("{} has a joint of weight {}, expected 0 to 1", name, weight));
    }
  }
  for (size_t t = 0; t < mesh.targets.size(); ++t) {
    const MorphTarget& target = mesh.targets[t];
    const std::string of = fmt::format("{}: morph target {}", name, t);
    const std::vector<uint32_t>& vertices = target.vertices;
    STILLRAY_RETURN_IF_ERROR(CheckCount(of, "positions", target.positions, vertices.size()));
    STILLRAY_RETURN_IF_ERROR(CheckCount(of, "normals", target.normals, vertices.size()));
    STILLRAY_RETURN_IF_ERROR(CheckCount(of, "tangents", target.tangents, vertices.size()));
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] >= count || (i != 0 && vertices[i] <= vertices[i - 1])) {
        return Status::InvalidArgument(
            fmt::format("{} moves vertex {} at position {}, expected increasing numbers below {}",
                        of, vertices[i], i, count));
      }
    }
  }
  return Status::Ok();
}

Status CheckSkin(const Scene& scene, size_t index) {
  const Skin& skin = scene.skins[index];
  const std::string name = fmt::format("skin {} (\"{}\")", index, skin.name);
  if (skin.joints.empty() || skin.joints.size() != skin.inverse_bind.size()) {
    return Status::InvalidArgument(
        fmt::format("{} has {} joints and {} matrices, expected as many of both, at least one",
                    name, skin.joints.size(), skin.inverse_bind.size()));
  }
  for (size_t i = 0; i < skin.joints.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(
        CheckIndex(fmt::format("{}: joint {}", name, i), skin.joints[i], scene.nodes.size()));
  }
  return Status::Ok();
}

/// \param joint_counts  per mesh: one more than its largest joint index
Status CheckPosed(const Scene& scene, size_t index, const std::vector<size_t>& joint_counts) {
  const Instance& instance = scene.instances[index];
  const Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
  const size_t weights = scene.nodes[static_cast<size_t>(instance.node)].weights.size();
  if (!mesh.targets.empty() && weights != 0 && weights != mesh.targets.size()) {
    return Status::InvalidArgument(
        fmt::format("instance {}: its node has {} weights, its mesh {} "
                    "morph targets",
                    index, weights, mesh.targets.size()));
  }
  if (instance.skin == -1) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(
      CheckIndex(fmt::format("instance {}: its skin", index), instance.skin, scene.skins.size()));
  const size_t used = joint_counts[static_cast<size_t>(instance.mesh)];
  const size_t joints = scene.skins[static_cast<size_t>(instance.skin)].joints.size();
  if (used == 0 || used > joints) {
    return Status::InvalidArgument(
        fmt::format("instance {}: its mesh uses {} joints, its skin has {}", index, used, joints));
  }
  return Status::Ok();
}

Status CheckDeformations(const Scene& scene) {
  std::vector<size_t> joint_counts;
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckDeformation(scene, i));
    const std::vector<uint16_t>& joints = scene.meshes[i].joints;
    const auto largest = std::max_element(joints.begin(), joints.end());
    joint_counts.push_back(largest == joints.end() ? 0 : size_t{*largest} + 1);
  }
  for (size_t i = 0; i < scene.skins.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckSkin(scene, i));
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckPosed(scene, i, joint_counts));
  }
  for (size_t i = 0; i < scene.animation.size(); ++i) {
    const AnimationChannel& channel = scene.animation[i];
    const size_t per_key = channel.interpolation == Interpolation::kCubicSpline ? 3 : 1;
    const size_t expected = scene.nodes[static_cast<size_t>(channel.node)].weights.size() *
                            channel.times.size() * per_key;
    if (channel.property == AnimatedProperty::kWeights && channel.weights.size() != expected) {
      return Status::InvalidArgument(
          fmt::format("animation channel {}: {} weights for {} keys, expected {}", i,
                      channel.weights.size(), channel.times.size(), expected));
    }
  }
  return Status::Ok();
}

Status CheckTexture(const Scene& scene, size_t index) {
  const Texture& texture = scene.textures[index];
  const std::string name = fmt::format("texture {} (\"{}\")", index, texture.name);
  if (texture.width < 1 || texture.height < 1) {
    return Status::InvalidArgument(
        fmt::format("{} is {}x{}, expected at least 1x1", name, texture.width, texture.height));
  }
  const size_t expected =
      4 * static_cast<size_t>(texture.width) * static_cast<size_t>(texture.height);
  if (texture.texels.size() != expected) {
    return Status::InvalidArgument(fmt::format("{} has {} bytes, expected {} for {}x{} RGBA", name,
                                               texture.texels.size(), expected, texture.width,
                                               texture.height));
  }
  return Status::Ok();
}

/// A factor of a material and its maximum.
struct Factor {
  const char* name;
  float value;
  float most;
};

Status CheckLayers(const Material& material, const std::string& name) {
  const vec3 specular = material.specular_color;
  constexpr float kMost = std::numeric_limits<float>::max();
  constexpr float kThickestFilm = 1e6f;  // nm; far beyond visible interference
  const vec3 scatters = material.multiscatter_color;
  const Factor factors[] = {
      {"multi-scatter colour", scatters.x, 1.0f},
      {"multi-scatter colour", scatters.y, 1.0f},
      {"multi-scatter colour", scatters.z, 1.0f},
      {"specular", material.specular, 1.0f},
      {"specular colour", specular.x, kMost},
      {"specular colour", specular.y, kMost},
      {"specular colour", specular.z, kMost},
      {"clear coat", material.clearcoat, 1.0f},
      {"clear coat roughness", material.clearcoat_roughness, 1.0f},
      {"sheen colour", material.sheen_color.x, 1.0f},
      {"sheen colour", material.sheen_color.y, 1.0f},
      {"sheen colour", material.sheen_color.z, 1.0f},
      {"sheen roughness", material.sheen_roughness, 1.0f},
      {"diffuse transmission", material.diffuse_transmission, 1.0f},
      {"diffuse transmission colour", material.diffuse_transmission_color.x, 1.0f},
      {"diffuse transmission colour", material.diffuse_transmission_color.y, 1.0f},
      {"diffuse transmission colour", material.diffuse_transmission_color.z, 1.0f},
      {"anisotropy", material.anisotropy, 1.0f},
      {"iridescence", material.iridescence, 1.0f},
      {"iridescence thickness minimum", material.iridescence_thickness_min, kThickestFilm},
      {"iridescence thickness maximum", material.iridescence_thickness_max, kThickestFilm},
  };
  for (const Factor& factor : factors) {
    if (!(factor.value >= 0.0f && factor.value <= factor.most)) {
      return Status::InvalidArgument(fmt::format("{}: {} is {}, expected 0 to {:g}", name,
                                                 factor.name, factor.value, factor.most));
    }
  }
  if (!(std::abs(material.scatter_anisotropy) < 1.0f)) {
    return Status::InvalidArgument(
        fmt::format("{}: scatter anisotropy is {}, expected more than -1 and less than 1", name,
                    material.scatter_anisotropy));
  }
  if (!(material.iridescence_ior >= 1.0f && material.iridescence_ior <= kMost)) {
    return Status::InvalidArgument(fmt::format("{}: iridescence ior is {}, expected at least 1",
                                               name, material.iridescence_ior));
  }
  if (!std::isfinite(material.anisotropy_rotation)) {
    return Status::InvalidArgument(fmt::format("{}: anisotropy rotation is {}, expected a number",
                                               name, material.anisotropy_rotation));
  }
  return Status::Ok();
}

Status CheckMaterial(const Scene& scene, size_t index) {
  const Material& material = scene.materials[index];
  const std::string name = fmt::format("material {} (\"{}\")", index, material.name);
  for (const auto& [slot, member] : kMaterialTextures) {
    const TextureRef& ref = material.*member;
    if (ref.texture != -1) {
      STILLRAY_RETURN_IF_ERROR(
          CheckIndex(fmt::format("{}: its {}", name, slot), ref.texture, scene.textures.size()));
    }
    if (ref.uv_set < 0 || ref.uv_set > 1) {
      return Status::InvalidArgument(
          fmt::format("{}: its {} uses uv set {}, expected 0 or 1", name, slot, ref.uv_set));
    }
  }
  const vec3 e = material.emission;
  if (!(e.x >= 0 && e.y >= 0 && e.z >= 0) || !std::isfinite(e.x + e.y + e.z)) {
    return Status::InvalidArgument(fmt::format(
        "{}: emission is ({}, {}, {}), expected finite and at least 0", name, e.x, e.y, e.z));
  }
  if (!(material.ior >= 1.0f && material.ior <= 10.0f)) {
    return Status::InvalidArgument(
        fmt::format("{}: ior is {}, expected 1 to 10", name, material.ior));
  }
  return CheckLayers(material, name);
}

Status CheckEnvironment(const Environment& environment) {
  const vec3 e = environment.radiance;
  if (!(e.x >= 0 && e.y >= 0 && e.z >= 0) || !std::isfinite(e.x + e.y + e.z)) {
    return Status::InvalidArgument(fmt::format(
        "environment: radiance is ({}, {}, {}), expected finite and at least 0", e.x, e.y, e.z));
  }
  // Texels and sums are indexed by an int, with three values per texel.
  constexpr int64_t kMostTexels = int64_t{1} << 29;
  const int64_t texels = int64_t{environment.map.width()} * environment.map.height();
  if (texels > kMostTexels) {
    return Status::InvalidArgument(fmt::format("environment map: {}x{} pixels, expected at most {}",
                                               environment.map.width(), environment.map.height(),
                                               kMostTexels));
  }
  for (int c = 0; c < 3 && !environment.map.empty(); ++c) {
    for (int y = 0; y < environment.map.height(); ++y) {
      for (int x = 0; x < environment.map.width(); ++x) {
        const float value = environment.map[c](x, y);
        if (!(value >= 0) || !std::isfinite(value)) {
          return Status::InvalidArgument(
              fmt::format("environment map: channel {} of pixel ({}, {}) is {}, expected finite "
                          "and at least 0",
                          c, x, y, value));
        }
      }
    }
  }
  return Status::Ok();
}

Status CheckLens(const Scene& scene, size_t index) {
  const Lens& lens = scene.cameras[index].lens;
  const auto bad = [index](const char* what, auto value, const char* expected) {
    return Status::InvalidArgument(
        fmt::format("camera {}: {} of its lens is {}, expected {}", index, what, value, expected));
  };
  if (!(lens.radius >= 0.0f && lens.radius <= kMaxAperture)) {
    return bad("the radius", lens.radius, "0 to 1e6");
  }
  if (lens.f_number != 0.0f && !(lens.f_number >= kMinFNumber && lens.f_number <= kMaxFNumber)) {
    return bad("the f-number", lens.f_number, "0.1 to 1000, or 0: none");
  }
  if (!(lens.focus >= 0.0f)) {
    return bad("the focus", lens.focus, "a distance above 0, or 0: by itself");
  }
  if (lens.blades != 0 && (lens.blades < 3 || lens.blades > kMaxBlades)) {
    return bad("the number of blades", lens.blades, "0, or 3 to 32");
  }
  if (!std::isfinite(lens.rotation)) {
    return bad("the rotation", lens.rotation, "a finite number of degrees");
  }
  if (lens.mask < 0) {
    return Status::Ok();
  }
  STILLRAY_RETURN_IF_ERROR(CheckIndex(fmt::format("camera {}: the mask of its lens", index),
                                      lens.mask, scene.textures.size()));
  const Texture& mask = scene.textures[static_cast<size_t>(lens.mask)];
  if (std::max(mask.width, mask.height) > kMaxLensMaskSide) {
    return Status::InvalidArgument(
        fmt::format("camera {}: the mask of its lens has {}x{} pixels, expected up to {} a side",
                    index, mask.width, mask.height, kMaxLensMaskSide));
  }
  if (!(MaskBrightness(mask) > 0.0)) {
    return Status::InvalidArgument(fmt::format("camera {}: the mask of its lens is black", index));
  }
  return Status::Ok();
}

Status CheckNodes(const Scene& scene) {
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].parent < -1 || scene.nodes[i].parent >= static_cast<int>(i)) {
      return Status::InvalidArgument(fmt::format(
          "node {}: its parent is {}, expected -1 or a node before it", i, scene.nodes[i].parent));
    }
  }
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckIndex(fmt::format("instance {}: its mesh", i),
                                        scene.instances[i].mesh, scene.meshes.size()));
    STILLRAY_RETURN_IF_ERROR(CheckIndex(fmt::format("instance {}: its node", i),
                                        scene.instances[i].node, scene.nodes.size()));
  }
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckIndex(fmt::format("camera {}: its node", i),
                                        scene.cameras[i].node, scene.nodes.size()));
    const float yfov = scene.cameras[i].yfov;
    if (!(yfov > 0.0f && yfov < 3.1415925f)) {
      return Status::InvalidArgument(
          fmt::format("camera {}: yfov is {}, expected above 0 and below pi", i, yfov));
    }
    STILLRAY_RETURN_IF_ERROR(CheckLens(scene, i));
  }
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(
        CheckIndex(fmt::format("light {}: its node", i), scene.lights[i].node, scene.nodes.size()));
    const vec3 e = scene.lights[i].intensity;
    if (!(e.x >= 0 && e.y >= 0 && e.z >= 0) || !std::isfinite(e.x + e.y + e.z)) {
      return Status::InvalidArgument(fmt::format(
          "light {}: intensity is ({}, {}, {}), expected finite and at least 0", i, e.x, e.y, e.z));
    }
  }
  for (size_t i = 0; i < scene.animation.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckIndex(fmt::format("animation channel {}: its node", i),
                                        scene.animation[i].node, scene.nodes.size()));
  }
  return Status::Ok();
}

Status CheckPose(const char* name, const CameraPose& pose) {
  if (!(pose.yfov > 0.0f && pose.yfov < 3.1415925f)) {
    return Status::InvalidArgument(
        fmt::format("{}: yfov is {}, expected above 0 and below pi", name, pose.yfov));
  }
  const mat4& m = pose.world_from_camera;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!(std::abs(m[column][row]) <= kMaxCoordinate)) {
        return Status::InvalidArgument(fmt::format(
            "{}: world_from_camera has {} in column {}, row {}, expected finite numbers up to {:g}",
            name, m[column][row], column, row, kMaxCoordinate));
      }
    }
  }
  return Status::Ok();
}

Status CheckPlace(const Scene& scene, const std::vector<mat4>& worlds, int node, double seconds) {
  if (IsTraceable(worlds[static_cast<size_t>(node)])) {
    return Status::Ok();
  }
  return Status::InvalidArgument(
      fmt::format("node {} (\"{}\"): at {:g} s its transform to the world has components that are "
                  "not finite or "
                  "beyond {:g}",
                  node, scene.nodes[static_cast<size_t>(node)].name, seconds, kMaxCoordinate));
}

}  // namespace

Status CheckScene(const Scene& scene) {
  for (size_t i = 0; i < scene.textures.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckTexture(scene, i));
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckMaterial(scene, i));
  }
  for (size_t i = 0; i < scene.meshes.size(); ++i) {
    STILLRAY_RETURN_IF_ERROR(CheckMesh(scene, i));
  }
  STILLRAY_RETURN_IF_ERROR(CheckNodes(scene));
  STILLRAY_RETURN_IF_ERROR(CheckDeformations(scene));
  return CheckEnvironment(scene.environment);
}

Status CheckMoment(const Scene& scene, const RenderMoment& moment) {
  if (moment.pose) {
    STILLRAY_RETURN_IF_ERROR(CheckPose("pose", *moment.pose));
  } else {
    STILLRAY_RETURN_IF_ERROR(CheckIndex("camera", moment.camera, scene.cameras.size()));
  }
  if (moment.previous_pose) {
    if (!moment.pose) {
      return Status::InvalidArgument("previous_pose is given without pose");
    }
    STILLRAY_RETURN_IF_ERROR(CheckPose("previous_pose", *moment.previous_pose));
  }
  if (!std::isfinite(moment.seconds) || !std::isfinite(moment.previous_seconds)) {
    return Status::InvalidArgument(
        fmt::format("seconds is {} and previous_seconds {}, expected finite numbers",
                    moment.seconds, moment.previous_seconds));
  }
  return Status::Ok();
}

Status CheckPlaces(const SceneState& state, const RenderMoment& moment) {
  const Scene& scene = state.scene();
  const auto check = [&](int node) {
    STILLRAY_RETURN_IF_ERROR(CheckPlace(scene, state.nodes(), node, moment.seconds));
    return CheckPlace(scene, state.previous_nodes(), node, moment.previous_seconds);
  };
  if (!moment.pose) {
    STILLRAY_RETURN_IF_ERROR(check(scene.cameras[static_cast<size_t>(moment.camera)].node));
  }
  for (const Instance& instance : scene.instances) {
    if (instance.skin < 0) {
      STILLRAY_RETURN_IF_ERROR(check(instance.node));
      continue;
    }
    for (const int joint : scene.skins[static_cast<size_t>(instance.skin)].joints) {
      STILLRAY_RETURN_IF_ERROR(check(joint));
    }
  }
  return Status::Ok();
}

}  // namespace stillray::render
