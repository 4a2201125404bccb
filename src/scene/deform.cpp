// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/deform.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "core/check.h"

namespace stillray {

namespace {

/// Vertices per task.
constexpr size_t kGrain = 1024;

template <typename Body>
void ForAll(size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) {
                        body(i);
                      }
                    });
}

/// v normalised, or `fallback` if v is zero.
vec3 UnitOr(vec3 v, vec3 fallback) {
  // In double precision: cofactors are products of up to 1e18 each.
  const glm::dvec3 exact(v);
  const double length2 = glm::dot(exact, exact);
  return length2 > 0.0 && std::isfinite(length2) ? vec3(exact / std::sqrt(length2)) : fallback;
}

/// Adds the deltas of the morph targets: deterministic, since a target has no duplicate vertices
/// and targets are applied in order.
void AddTargets(const Mesh& mesh, const std::vector<float>& weights, DeformedMesh* out) {
  STILLRAY_CHECK_EQ(weights.size(), mesh.targets.size());
  for (size_t t = 0; t < weights.size(); ++t) {
    const MorphTarget& target = mesh.targets[t];
    const float weight = weights[t];
    if (weight == 0.0f) {
      continue;
    }
    ForAll(target.vertices.size(), [&](size_t i) {
      const uint32_t vertex = target.vertices[i];
      if (!target.positions.empty()) {
        out->positions[vertex] += target.positions[i] * weight;
      }
      if (!target.normals.empty()) {
        out->normals[vertex] += target.normals[i] * weight;
      }
      if (!target.tangents.empty() && !out->tangents.empty()) {
        out->tangents[vertex] += vec4(target.tangents[i] * weight, 0.0f);
      }
    });
  }
  ForAll(mesh.positions.size(), [&](size_t i) {
    if (out->normals[i] != mesh.normals[i]) {
      out->normals[i] = UnitOr(out->normals[i], mesh.normals[i]);
    }
    if (!out->tangents.empty() && out->tangents[i] != mesh.tangents[i]) {
      out->tangents[i] =
          vec4(UnitOr(vec3(out->tangents[i]), vec3(mesh.tangents[i])), mesh.tangents[i].w);
    }
  });
}

/// The weighted sum of the matrices of a vertex's joints.
mat4 BlendJoints(const Mesh& mesh, const std::vector<mat4>& joints, size_t vertex) {
  const auto influences = static_cast<size_t>(mesh.influences);
  mat4 sum(0.0f);
  for (size_t k = vertex * influences; k < (vertex + 1) * influences; ++k) {
    const float weight = mesh.weights[k];
    if (weight != 0.0f) {
      sum += joints[mesh.joints[k]] * weight;
    }
  }
  return sum;
}

void ApplySkin(const Mesh& mesh, const std::vector<mat4>& joints, DeformedMesh* out) {
  ForAll(mesh.positions.size(), [&](size_t i) {
    const mat4 skin = BlendJoints(mesh, joints, i);
    const mat3 linear(skin);
    out->positions[i] = vec3(skin * vec4(out->positions[i], 1.0f));
    const float side = glm::determinant(linear) < 0.0f ? -1.0f : 1.0f;
    out->normals[i] = UnitOr(CofactorMatrix(linear) * out->normals[i] * side, vec3(0.0f));
    if (!out->tangents.empty()) {
      const vec4 tangent = out->tangents[i];
      out->tangents[i] = vec4(UnitOr(linear * vec3(tangent), vec3(0.0f)), tangent.w);
    }
  });
}

void SetFlatNormals(const Mesh& mesh, DeformedMesh* out) {
  ForAll(mesh.indices.size() / 3, [&](size_t i) {
    const uint32_t* corner = mesh.indices.data() + 3 * i;
    const glm::dvec3 p0(out->positions[corner[0]]);
    const vec3 normal = UnitOr(vec3(glm::cross(glm::dvec3(out->positions[corner[1]]) - p0,
                                               glm::dvec3(out->positions[corner[2]]) - p0)),
                               vec3(0.0f));
    for (size_t k = 0; k < 3; ++k) {
      out->normals[corner[k]] = normal;
    }
  });
}

}  // namespace

bool HasAnimatedWeights(const Scene& scene, const Instance& instance) {
  if (scene.meshes[static_cast<size_t>(instance.mesh)].targets.empty()) {
    return false;
  }
  return std::any_of(scene.animation.begin(), scene.animation.end(),
                     [&](const AnimationChannel& channel) {
                       return channel.property == AnimatedProperty::kWeights &&
                              channel.node == instance.node && !channel.times.empty();
                     });
}

bool MayDeform(const Scene& scene, const Instance& instance) {
  if (instance.skin >= 0 || HasAnimatedWeights(scene, instance)) {
    return true;
  }
  const std::vector<float>& weights = scene.nodes[static_cast<size_t>(instance.node)].weights;
  return !scene.meshes[static_cast<size_t>(instance.mesh)].targets.empty() &&
         std::any_of(weights.begin(), weights.end(), [](float weight) { return weight != 0.0f; });
}

Pose PoseOf(const Scene& scene, const Instance& instance, const std::vector<mat4>& nodes,
            double seconds) {
  Pose pose;
  if (instance.skin >= 0) {
    const Skin& skin = scene.skins[static_cast<size_t>(instance.skin)];
    pose.joints.resize(skin.joints.size());
    for (size_t i = 0; i < pose.joints.size(); ++i) {
      pose.joints[i] = nodes[static_cast<size_t>(skin.joints[i])] * skin.inverse_bind[i];
    }
  }
  if (!scene.meshes[static_cast<size_t>(instance.mesh)].targets.empty()) {
    pose.weights = MorphWeights(scene, instance.node, seconds);
  }
  return pose;
}

void Deform(const Mesh& mesh, const Pose& pose, DeformedMesh* out) {
  out->positions = mesh.positions;
  out->normals = mesh.normals;
  out->tangents = mesh.tangents;
  if (!pose.weights.empty()) {
    AddTargets(mesh, pose.weights, out);
  }
  if (!pose.joints.empty()) {
    ApplySkin(mesh, pose.joints, out);
  }
  if (mesh.flat_normals) {
    SetFlatNormals(mesh, out);
  }
}

float PoseOrientation(const Pose& pose) {
  const auto mirrors = std::count_if(pose.joints.begin(), pose.joints.end(), [](const mat4& joint) {
    return glm::determinant(mat3(joint)) < 0.0f;
  });
  return 2 * static_cast<size_t>(mirrors) > pose.joints.size() ? -1.0f : 1.0f;
}

}  // namespace stillray
