// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include "scene/gltf_accessor.h"
#include "scene/gltf_import.h"

namespace stillray {

namespace {

/// Larger animated values are treated as damage; see also kMaxCoordinate.
constexpr float kMaxAnimatedValue = 1e18f;

struct ChannelTarget {
  int node = -1;  ///< in Scene::nodes; -1: the channel is ignored
  AnimatedProperty property = AnimatedProperty::kTranslation;
};

ChannelTarget ReadTarget(GltfImport* import, const JsonView& channel) {
  const JsonView target = channel.Object("target");
  ChannelTarget result;
  const std::string path = target.String("path");
  if (path == "translation") {
    result.property = AnimatedProperty::kTranslation;
  } else if (path == "rotation") {
    result.property = AnimatedProperty::kRotation;
  } else if (path == "scale") {
    result.property = AnimatedProperty::kScale;
  } else if (path == "weights") {
    result.property = AnimatedProperty::kWeights;
  } else {
    target.Warn("path", fmt::format("'{}' is not supported and was left out", Printable(path)));
    return result;
  }
  const int node = target.Index("node", import->node_of_gltf.size(), "nodes");
  // Channels without a node may have a target defined by an extension; nodes outside the scene are
  // invisible.
  result.node = node < 0 ? -1 : import->node_of_gltf[static_cast<size_t>(node)];
  return result;
}

bool ReadTimes(GltfImport* import, const JsonView& sampler, int accessor_index,
               std::vector<float>* times) {
  Accessor accessor;
  const std::string user = sampler.path() + ".input";
  if (!OpenAccessor(import->document, &import->log, accessor_index, user, &accessor) ||
      !import->Charge(user, accessor.count())) {
    return false;
  }
  if (accessor.components() != 1 || !accessor.is_float()) {
    sampler.Fail("input", fmt::format("accessors[{}] does not hold float scalars", accessor_index));
    return false;
  }
  times->resize(accessor.count());
  for (size_t i = 0; i < times->size(); ++i) {
    float& time = (*times)[i];
    accessor.Read(i, &time);
    if (!(time >= 0.0f) || !std::isfinite(time)) {
      sampler.Fail("input", fmt::format("time {} of keyframe {} is not finite and >= 0", time, i));
      return false;
    }
    if (i != 0 && !(time > (*times)[i - 1])) {
      sampler.Fail("input", fmt::format("time {} of keyframe {} does not lie after {}", time, i,
                                        (*times)[i - 1]));
      return false;
    }
  }
  return true;
}

Interpolation ReadInterpolation(const JsonView& sampler) {
  const std::string name = sampler.String("interpolation", "LINEAR");
  if (name == "STEP") {
    return Interpolation::kStep;
  }
  if (name == "CUBICSPLINE") {
    return Interpolation::kCubicSpline;
  }
  if (name != "LINEAR") {
    sampler.Fail("interpolation",
                 fmt::format("'{}' is not STEP, LINEAR or CUBICSPLINE", Printable(name)));
  }
  return Interpolation::kLinear;
}

/// Reads morph weights: per key one scalar for each target of the node's mesh.
bool ReadWeights(GltfImport* import, const JsonView& sampler, int accessor_index, size_t expected,
                 const Accessor& accessor, AnimationChannel* channel) {
  if (accessor.components() != 1 || accessor.count() != expected) {
    sampler.Fail("output",
                 fmt::format("accessors[{}] has {} elements of {} components, expected "
                             "{} of 1: the node's morph targets for each keyframe",
                             accessor_index, accessor.count(), accessor.components(), expected));
    return false;
  }
  channel->weights.resize(accessor.count());
  for (size_t i = 0; i < channel->weights.size(); ++i) {
    float& value = channel->weights[i];
    accessor.Read(i, &value);
    if (!(std::abs(value) <= kMaxAnimatedValue)) {
      sampler.Fail("output", fmt::format("value {} of element {} is no usable number", value, i));
      return false;
    }
  }
  return import->log.ok();
}

bool ReadValues(GltfImport* import, const JsonView& sampler, int accessor_index,
                AnimationChannel* channel) {
  Accessor accessor;
  const std::string user = sampler.path() + ".output";
  if (!OpenAccessor(import->document, &import->log, accessor_index, user, &accessor) ||
      !import->Charge(user, accessor.count())) {
    return false;
  }
  const int components = channel->property == AnimatedProperty::kRotation ? 4 : 3;
  const size_t per_key = channel->interpolation == Interpolation::kCubicSpline ? 3 : 1;
  if (channel->property == AnimatedProperty::kWeights) {
    const size_t targets = import->scene.nodes[static_cast<size_t>(channel->node)].weights.size();
    return ReadWeights(import, sampler, accessor_index, channel->times.size() * per_key * targets,
                       accessor, channel);
  }
  if (accessor.components() != components || accessor.count() != channel->times.size() * per_key) {
    sampler.Fail("output", fmt::format("accessors[{}] has {} elements of {} components, expected "
                                       "{} of {}",
                                       accessor_index, accessor.count(), accessor.components(),
                                       channel->times.size() * per_key, components));
    return false;
  }
  channel->values.resize(accessor.count());
  for (size_t i = 0; i < channel->values.size(); ++i) {
    vec4& value = channel->values[i];
    accessor.Read(i, &value.x);
    for (int c = 0; c < components; ++c) {
      if (!(std::abs(value[c]) <= kMaxAnimatedValue)) {
        sampler.Fail("output",
                     fmt::format("value {} of element {} is no usable number", value[c], i));
        return false;
      }
    }
  }
  return true;
}

/// Decomposes a node's matrix (losing shear), so that channels can animate its parts.
void SplitMatrix(Node* node) {
  const mat4& m = node->matrix;
  vec3 scale(glm::length(vec3(m[0])), glm::length(vec3(m[1])), glm::length(vec3(m[2])));
  if (glm::determinant(mat3(m)) < 0) {
    scale.x = -scale.x;
  }
  node->local.translation = vec3(m[3]);
  node->local.scale = scale;
  node->has_matrix = false;
  if (scale.x != 0 && scale.y != 0 && scale.z != 0) {
    const mat3 turn(vec3(m[0]) / scale.x, vec3(m[1]) / scale.y, vec3(m[2]) / scale.z);
    const glm::quat q = glm::normalize(glm::quat_cast(turn));
    node->local.rotation = vec4(q.x, q.y, q.z, q.w);
  }
}

using ChannelKey = std::pair<int, AnimatedProperty>;

void ReadChannel(GltfImport* import, const JsonView& animation, const JsonView& view,
                 std::set<ChannelKey>* seen) {
  const ChannelTarget target = ReadTarget(import, view);
  const int index = view.Index("sampler", animation.Size("samplers"), "samplers");
  if (!import->log.ok() || target.node < 0) {
    return;
  }
  if (index < 0) {
    view.Fail("sampler", "missing");
    return;
  }
  if (target.property == AnimatedProperty::kWeights &&
      import->scene.nodes[static_cast<size_t>(target.node)].weights.empty()) {
    view.Warn("target.node", "has no morph targets, so its animated weights were left out");
    return;
  }
  if (!seen->insert({target.node, target.property}).second) {
    view.Warn("target", "animates what another channel animates, and was left out");
    return;
  }
  const JsonView sampler = animation.Item("samplers", static_cast<size_t>(index));
  const size_t accessors = import->Root().Size("accessors");
  const int input = sampler.Index("input", accessors, "accessors");
  const int output = sampler.Index("output", accessors, "accessors");
  AnimationChannel channel;
  channel.node = target.node;
  channel.property = target.property;
  channel.interpolation = ReadInterpolation(sampler);
  if (import->log.ok() && (input < 0 || output < 0)) {
    sampler.Fail(input < 0 ? "input" : "output", "missing");
  }
  if (!import->log.ok() || !ReadTimes(import, sampler, input, &channel.times) ||
      !ReadValues(import, sampler, output, &channel)) {
    return;
  }
  Node& node = import->scene.nodes[static_cast<size_t>(target.node)];
  if (node.has_matrix && target.property != AnimatedProperty::kWeights) {
    view.Warn("target.node", "is animated but has a matrix, which was taken apart");
    SplitMatrix(&node);
  }
  import->scene.animation.push_back(std::move(channel));
}

}  // namespace

void ImportAnimations(GltfImport* import) {
  const JsonView root = import->Root();
  const size_t animations = root.Size("animations");
  std::set<ChannelKey> seen;
  for (size_t a = 0; a < animations; ++a) {
    const JsonView animation = root.Item("animations", a);
    const size_t channels = animation.Size("channels");
    for (size_t c = 0; c < channels && import->log.ok(); ++c) {
      ReadChannel(import, animation, animation.Item("channels", c), &seen);
    }
  }
}

}  // namespace stillray
