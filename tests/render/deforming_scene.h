// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Scenes whose meshes deform, by skins and by morph targets.
#pragma once

#include "render/test_scenes.h"
#include "scene/deform.h"

namespace stillray::render {

/// A tube along x from 0 to 2 around the axis, smooth, with texture coordinates. Joint 0 moves its
/// start and joint 1 its end; the weight of joint 1 grows linearly between.
inline Mesh Tube(int rings, int sides, float radius) {
  Mesh mesh;
  mesh.influences = 4;
  for (int i = 0; i <= rings; ++i) {
    const float s = static_cast<float>(i) / static_cast<float>(rings);
    for (int k = 0; k <= sides; ++k) {
      const float t = static_cast<float>(k) / static_cast<float>(sides);
      const vec3 out(0, std::cos(6.2831853f * t), std::sin(6.2831853f * t));
      mesh.positions.push_back(vec3(2 * s, 0, 0) + out * radius);
      mesh.normals.push_back(out);
      mesh.tangents.push_back(vec4(1, 0, 0, 1));
      mesh.uv[0].push_back(vec2(s, t));
      mesh.joints.insert(mesh.joints.end(), {0, 1, 0, 0});
      mesh.weights.insert(mesh.weights.end(), {1 - s, s, 0, 0});
    }
  }
  const auto columns = static_cast<uint32_t>(sides) + 1;
  for (uint32_t i = 0; i < static_cast<uint32_t>(rings); ++i) {
    for (uint32_t k = 0; k < static_cast<uint32_t>(sides); ++k) {
      const uint32_t o = i * columns + k;
      mesh.indices.insert(mesh.indices.end(), {o, o + columns, o + columns + 1});
      mesh.indices.insert(mesh.indices.end(), {o, o + columns + 1, o + 1});
    }
  }
  return mesh;
}

/// Gives an instance of a Tube two joints: one at `place`, the other one 1 unit along its x.
/// \return the node of the second joint
inline int AddSkin(SceneBuilder* builder, int instance, const Transform& place) {
  Skin skin;
  skin.joints.push_back(builder->AddNode(place));
  skin.joints.push_back(builder->AddNode(At(vec3(1, 0, 0))));
  builder->scene.nodes.back().parent = skin.joints[0];
  skin.inverse_bind = {mat4(1.0f), mat4(1.0f)};
  skin.inverse_bind[1][3] = vec4(-1, 0, 0, 1);
  builder->scene.instances[static_cast<size_t>(instance)].skin =
      static_cast<int>(builder->scene.skins.size());
  builder->scene.skins.push_back(skin);
  return skin.joints[1];
}

/// Animates the weights of a node's morph targets, from 0 to 1 s.
inline void AnimateWeights(SceneBuilder* builder, int node, const std::vector<float>& from,
                           const std::vector<float>& to) {
  builder->scene.nodes[static_cast<size_t>(node)].weights = from;
  AnimationChannel channel;
  channel.node = node;
  channel.property = AnimatedProperty::kWeights;
  channel.times = {0.0f, 1.0f};
  channel.weights = from;
  channel.weights.insert(channel.weights.end(), to.begin(), to.end());
  builder->scene.animation.push_back(channel);
}

/// Adds a target that moves every vertex by delta(position).
template <typename Delta>
void AddTarget(Mesh* mesh, const Delta& delta) {
  MorphTarget target;
  for (size_t i = 0; i < mesh->positions.size(); ++i) {
    target.vertices.push_back(static_cast<uint32_t>(i));
    target.positions.push_back(delta(mesh->positions[i]));
  }
  mesh->targets.push_back(target);
}

/// A tube that bends, one of the same mesh that stands in a mirrored pose, one of see-through
/// material, a moving sphere that becomes flat, and a lamp that turns and grows.
/// \param rings  of the tubes: 20 or less for less than 4096 triangles in all
inline Scene DeformingScene(int rings) {
  SceneBuilder builder;
  builder.scene.environment.radiance = vec3(0.3f, 0.35f, 0.4f);
  builder.Add(Quad(vec3(-9, -1.3f, 0), vec3(18, 0, 0), vec3(0, 0, -18)), Lambert(vec3(0.5f)));
  const Mesh tube = Tube(rings, 16, 0.3f);
  const int bends = builder.Add(tube, Metal(vec3(0.9f, 0.6f, 0.3f), 0.4f), At(vec3(9, 9, 9)));
  const int elbow = AddSkin(&builder, bends, At(vec3(-1.8f, -0.4f, -5)));
  builder.Turn(elbow, glm::normalize(vec3(0, 1, 2)), {-0.2f, 0.3f, 0.8f, 1.1f, 1.2f, 0.9f});
  const int mirrored = builder.Add(tube, Lambert(vec3(0.2f, 0.7f, 0.3f)));
  Transform mirror = At(vec3(1.9f, -0.9f, -5.5f));
  mirror.scale = vec3(-1, 1, 1);
  const int still = AddSkin(&builder, mirrored, mirror);
  builder.scene.nodes[static_cast<size_t>(still)].local.rotation = Rotation(vec3(0, 0, 1), 0.6f);
  Material glass = Lambert(vec3(0.8f, 0.3f, 0.3f));
  glass.alpha_mode = AlphaMode::kBlend;
  glass.base_color.w = 0.6f;
  const int veil = builder.Add(tube, glass);
  const int end = AddSkin(&builder, veil, At(vec3(0.2f, 0.7f, -6)));
  builder.Move(end, vec3(0.4f, -1.5f, 1));
  Mesh ball = FacetedSphere(vec3(0), 0.5f, 2);
  ball.flat_normals = true;
  AddTarget(&ball, [](vec3 p) { return vec3(p.x, -0.8f * p.y, 0); });
  AddTarget(&ball, [](vec3 p) { return vec3(0, 0, p.x * p.x); });
  const int sphere = builder.Add(ball, Lambert(vec3(0.3f, 0.3f, 0.8f)), At(vec3(0.8f, -0.6f, -4)));
  AnimateWeights(&builder, builder.InstanceNode(sphere), {0, 0.2f}, {1, 1});
  builder.Move(builder.InstanceNode(sphere), vec3(-1, 0, 0));
  Mesh lamp = Quad(vec3(-0.4f, 0, 0.4f), vec3(0, 0, -0.8f), vec3(0.8f, 0, 0));
  AddTarget(&lamp, [](vec3 p) { return p; });
  Material light = Emitter(vec3(6, 5, 4));
  light.double_sided = true;
  const int lit = builder.Add(lamp, light, At(vec3(-0.5f, 1.6f, -4.5f)));
  AnimateWeights(&builder, builder.InstanceNode(lit), {-0.3f}, {1.5f});
  builder.Turn(builder.InstanceNode(lit), vec3(1, 0, 0), {0.0f, 0.2f, 0.4f, 0.6f, 0.8f});
  return builder.scene;
}

/// The scene at one moment, without animation, skins and targets: vertices of instances that deform
/// are in the meshes.
inline Scene Baked(const Scene& scene, double seconds) {
  Scene baked = scene;
  const std::vector<mat4> nodes = NodeTransforms(scene, seconds);
  for (size_t i = 0; i < nodes.size(); ++i) {
    baked.nodes[i] = {};
    baked.nodes[i].has_matrix = true;
    baked.nodes[i].matrix = nodes[i];
  }
  baked.animation.clear();
  baked.skins.clear();
  for (Instance& instance : baked.instances) {
    const Instance original = instance;
    if (!MayDeform(scene, original)) {
      continue;
    }
    Mesh mesh = scene.meshes[static_cast<size_t>(original.mesh)];
    const Pose pose = PoseOf(scene, original, nodes, seconds);
    DeformedMesh deformed;
    Deform(mesh, pose, &deformed);
    mesh.positions = deformed.positions;
    mesh.normals = deformed.normals;
    mesh.tangents = deformed.tangents;
    mesh.targets.clear();
    mesh.influences = 0;
    mesh.joints.clear();
    mesh.weights.clear();
    if (PoseOrientation(pose) < 0) {
      for (size_t k = 0; k + 2 < mesh.indices.size(); k += 3) {
        std::swap(mesh.indices[k + 1], mesh.indices[k + 2]);
      }
    }
    instance.mesh = static_cast<int>(baked.meshes.size());
    if (original.skin >= 0) {
      instance.skin = -1;
      instance.node = static_cast<int>(baked.nodes.size());
      baked.nodes.emplace_back();
    }
    baked.meshes.push_back(std::move(mesh));
  }
  for (Mesh& mesh : baked.meshes) {
    mesh.targets.clear();
  }
  return baked;
}

}  // namespace stillray::render
