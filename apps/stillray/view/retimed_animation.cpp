// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/retimed_animation.h"

#include <algorithm>
#include <cstddef>

#include <glm/gtc/quaternion.hpp>

namespace stillray::view {
namespace {

/// Marks the node and its ancestors.
void MarkUp(const Scene& scene, int node, std::vector<bool>* marked) {
  for (; node >= 0; node = scene.nodes[static_cast<size_t>(node)].parent) {
    (*marked)[static_cast<size_t>(node)] = true;
  }
}

std::vector<bool> NodesThatCarryLights(const Scene& scene) {
  std::vector<bool> lights(scene.nodes.size(), false);
  for (const PunctualLight& light : scene.lights) {
    MarkUp(scene, light.node, &lights);
  }
  for (const Instance& instance : scene.instances) {
    const int material = scene.meshes[static_cast<size_t>(instance.mesh)].material;
    if (scene.materials[static_cast<size_t>(material)].emits()) {
      MarkUp(scene, instance.node, &lights);
      if (instance.skin >= 0) {
        for (const int joint : scene.skins[static_cast<size_t>(instance.skin)].joints) {
          MarkUp(scene, joint, &lights);
        }
      }
    }
  }
  std::vector<bool> cameras(scene.nodes.size(), false);
  for (const Camera& camera : scene.cameras) {
    MarkUp(scene, camera.node, &cameras);
  }
  for (size_t i = 0; i < lights.size(); ++i) {
    lights[i] = lights[i] && !cameras[i];
  }
  return lights;
}

/// A scene of one node with only this channel, whose value is given by the node's matrix or morph
/// weights.
/// \param weights  number of morph weights of the channel's node
Scene ProbeOf(const AnimationChannel& channel, size_t weights) {
  Scene probe;
  probe.nodes.emplace_back();
  probe.nodes[0].weights.resize(weights);
  probe.animation.push_back(channel);
  probe.animation[0].node = 0;
  return probe;
}

vec4 ValueAt(const Scene& probe, double seconds) {
  const mat4 m = NodeTransforms(probe, seconds)[0];
  switch (probe.animation[0].property) {
    case AnimatedProperty::kTranslation:
      return m[3];
    case AnimatedProperty::kScale:
      return {m[0][0], m[1][1], m[2][2], 0};
    case AnimatedProperty::kRotation:
    case AnimatedProperty::kWeights:
      break;
  }
  const glm::quat q = glm::quat_cast(mat3(m));
  return {q.x, q.y, q.z, q.w};
}

}  // namespace

RetimedAnimation::RetimedAnimation(Scene* scene) : scene_(scene) {
  original_.nodes = scene->nodes;
  original_.cameras = scene->cameras;
  original_.animation = scene->animation;
  const std::vector<bool> lights = NodesThatCarryLights(*scene);
  for (const AnimationChannel& channel : original_.animation) {
    const Node& node = scene->nodes[static_cast<size_t>(channel.node)];
    probes_.push_back(ProbeOf(channel, node.weights.size()));
    of_lights_.push_back(lights[static_cast<size_t>(channel.node)]);
    has_lights_ = has_lights_ || (of_lights_.back() && channel.times.size() > 1);
  }
}

void RetimedAnimation::Set(const AnimationTime& now, const AnimationTime& before, double* seconds,
                           double* previous_seconds) {
  const bool apart = has_lights_ && (now.all != now.lights || before.all != before.lights);
  if (!apart) {
    if (replaced_) {
      scene_->animation = original_.animation;
      replaced_ = false;
    }
    *seconds = now.all;
    *previous_seconds = before.all;
    return;
  }
  for (size_t i = 0; i < original_.animation.size(); ++i) {
    AnimationChannel& channel = scene_->animation[i];
    if (original_.animation[i].times.empty()) {
      continue;
    }
    const bool light = of_lights_[i];
    channel.interpolation = Interpolation::kStep;
    channel.times = {0.0f, 1.0f};
    const double before_at = light ? before.lights : before.all;
    const double now_at = light ? now.lights : now.all;
    if (channel.property == AnimatedProperty::kWeights) {
      channel.weights = MorphWeights(probes_[i], 0, before_at);
      const std::vector<float> weights = MorphWeights(probes_[i], 0, now_at);
      channel.weights.insert(channel.weights.end(), weights.begin(), weights.end());
      continue;
    }
    channel.values = {ValueAt(probes_[i], before_at), ValueAt(probes_[i], now_at)};
  }
  replaced_ = true;
  *seconds = 1;
  *previous_seconds = 0;
}

}  // namespace stillray::view
