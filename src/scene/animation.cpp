// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "stillray/scene.h"

namespace stillray {

namespace {

/// Unit quaternion, or no rotation if `q` is zero: keyframes may pass through zero.
vec4 UnitRotation(vec4 q) {
  const float length = std::sqrt(glm::dot(q, q));
  return length > 1e-12f && std::isfinite(length) ? q / length : vec4(0.0f, 0.0f, 0.0f, 1.0f);
}

/// Spherical interpolation along the shorter arc (glTF 2.0, C.4).
vec4 Slerp(vec4 a, vec4 b, float t) {
  a = UnitRotation(a);
  b = UnitRotation(b);
  float cosine = glm::dot(a, b);
  if (cosine < 0.0f) {
    b = -b;
    cosine = -cosine;
  }
  // Below this angle the sine is too imprecise, and linear interpolation is as good.
  constexpr float kNearlyEqual = 0.9999f;
  if (cosine > kNearlyEqual) {
    return UnitRotation(a + (b - a) * t);
  }
  const float angle = std::acos(cosine);
  return UnitRotation((a * std::sin((1.0f - t) * angle) + b * std::sin(t * angle)) /
                      std::sin(angle));
}

/// Cubic Hermite spline (glTF 2.0, C.5) between keys i and i + 1, which lie `gap` seconds apart.
vec4 Hermite(const std::vector<vec4>& values, size_t i, float t, float gap) {
  const vec4 p0 = values[3 * i + 1];
  const vec4 m0 = values[3 * i + 2] * gap;
  const vec4 m1 = values[3 * i + 3] * gap;
  const vec4 p1 = values[3 * i + 4];
  const float t2 = t * t;
  const float t3 = t2 * t;
  return p0 * (2.0f * t3 - 3.0f * t2 + 1.0f) + m0 * (t3 - 2.0f * t2 + t) +
         p1 * (3.0f * t2 - 2.0f * t3) + m1 * (t3 - t2);
}

vec4 KeyValue(const AnimationChannel& channel, size_t i) {
  return channel.interpolation == Interpolation::kCubicSpline ? channel.values[3 * i + 1]
                                                              : channel.values[i];
}

vec4 ChannelValue(const AnimationChannel& channel, double seconds) {
  const std::vector<float>& times = channel.times;
  // The first key after `seconds`.
  const size_t next = static_cast<size_t>(
      std::upper_bound(times.begin(), times.end(), seconds,
                       [](double s, float time) { return s < static_cast<double>(time); }) -
      times.begin());
  if (next == 0) {
    return KeyValue(channel, 0);
  }
  const size_t i = next - 1;
  if (next == times.size() || channel.interpolation == Interpolation::kStep) {
    return KeyValue(channel, i);
  }
  const double gap = static_cast<double>(times[next]) - static_cast<double>(times[i]);
  const float t = static_cast<float>((seconds - static_cast<double>(times[i])) / gap);
  if (channel.interpolation == Interpolation::kCubicSpline) {
    return Hermite(channel.values, i, t, static_cast<float>(gap));
  }
  const vec4 a = channel.values[i];
  const vec4 b = channel.values[next];
  return channel.property == AnimatedProperty::kRotation ? Slerp(a, b, t) : a + (b - a) * t;
}

void ApplyChannel(const AnimationChannel& channel, double seconds, Transform* local) {
  const vec4 value = ChannelValue(channel, seconds);
  switch (channel.property) {
    case AnimatedProperty::kTranslation:
      local->translation = vec3(value);
      break;
    case AnimatedProperty::kRotation:
      local->rotation = UnitRotation(value);
      break;
    case AnimatedProperty::kScale:
      local->scale = vec3(value);
      break;
  }
}

}  // namespace

mat4 Transform::ToMatrix() const {
  const float x = rotation.x;
  const float y = rotation.y;
  const float z = rotation.z;
  const float w = rotation.w;
  const vec3 right(1.0f - 2.0f * (y * y + z * z), 2.0f * (x * y + w * z), 2.0f * (x * z - w * y));
  const vec3 up(2.0f * (x * y - w * z), 1.0f - 2.0f * (x * x + z * z), 2.0f * (y * z + w * x));
  const vec3 back(2.0f * (x * z + w * y), 2.0f * (y * z - w * x), 1.0f - 2.0f * (x * x + y * y));
  return {vec4(right * scale.x, 0.0f), vec4(up * scale.y, 0.0f), vec4(back * scale.z, 0.0f),
          vec4(translation, 1.0f)};
}

double Scene::AnimationLength() const {
  double length = 0;
  for (const AnimationChannel& channel : animation) {
    if (!channel.times.empty()) {
      length = std::max(length, static_cast<double>(channel.times.back()));
    }
  }
  return length;
}

std::vector<mat4> NodeTransforms(const Scene& scene, double seconds) {
  std::vector<Transform> locals(scene.nodes.size());
  for (size_t i = 0; i < locals.size(); ++i) {
    locals[i] = scene.nodes[i].local;
  }
  for (const AnimationChannel& channel : scene.animation) {
    const size_t per_key = channel.interpolation == Interpolation::kCubicSpline ? 3 : 1;
    STILLRAY_CHECK_LT(static_cast<size_t>(channel.node), locals.size());
    STILLRAY_CHECK_EQ(channel.values.size(), channel.times.size() * per_key);
    if (!channel.times.empty()) {
      ApplyChannel(channel, seconds, &locals[static_cast<size_t>(channel.node)]);
    }
  }
  std::vector<mat4> worlds(scene.nodes.size());
  for (size_t i = 0; i < worlds.size(); ++i) {
    const Node& node = scene.nodes[i];
    const mat4 local = node.has_matrix ? node.matrix : locals[i].ToMatrix();
    STILLRAY_CHECK(node.parent < static_cast<int>(i));
    worlds[i] = node.parent < 0 ? local : worlds[static_cast<size_t>(node.parent)] * local;
  }
  return worlds;
}

}  // namespace stillray
