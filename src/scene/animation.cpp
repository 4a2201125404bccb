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
  // At smaller angles the sine is too imprecise, and linear interpolation is as accurate.
  constexpr float kNearlyEqual = 0.9999f;
  if (cosine > kNearlyEqual) {
    return UnitRotation(a + (b - a) * t);
  }
  const float angle = std::acos(cosine);
  return UnitRotation((a * std::sin((1.0f - t) * angle) + b * std::sin(t * angle)) /
                      std::sin(angle));
}

/// Cubic Hermite spline (glTF 2.0, C.5) between two keys that lie `gap` seconds apart.
/// \param out_tangent, in_tangent  outgoing tangent of the first key, incoming tangent of the
///     second
template <typename T>
T Hermite(T p0, T out_tangent, T in_tangent, T p1, float t, float gap) {
  const T m0 = out_tangent * gap;
  const T m1 = in_tangent * gap;
  const float t2 = t * t;
  const float t3 = t2 * t;
  return p0 * (2.0f * t3 - 3.0f * t2 + 1.0f) + m0 * (t3 - 2.0f * t2 + t) +
         p1 * (3.0f * t2 - 2.0f * t3) + m1 * (t3 - t2);
}

size_t ValuesPerKey(const AnimationChannel& channel) {
  return channel.interpolation == Interpolation::kCubicSpline ? 3 : 1;
}

/// The position of a time among the keys of a channel.
struct KeyPlace {
  size_t key = 0;        ///< the key whose value applies, or the first key of the interpolation
  bool between = false;  ///< whether to interpolate to the next key
  float t = 0;           ///< interpolation parameter 0..1
  float gap = 0;         ///< seconds to the next key
};

/// \param channel  has at least one key
KeyPlace FindKey(const AnimationChannel& channel, double seconds) {
  const std::vector<float>& times = channel.times;
  // The first key after `seconds`.
  const size_t next = static_cast<size_t>(
      std::upper_bound(times.begin(), times.end(), seconds,
                       [](double s, float time) { return s < static_cast<double>(time); }) -
      times.begin());
  KeyPlace place;
  if (next == 0) {
    return place;
  }
  place.key = next - 1;
  if (next == times.size() || channel.interpolation == Interpolation::kStep) {
    return place;
  }
  const auto start = static_cast<double>(times[place.key]);
  const double gap = static_cast<double>(times[next]) - start;
  place.between = true;
  place.t = static_cast<float>((seconds - start) / gap);
  place.gap = static_cast<float>(gap);
  return place;
}

vec4 ChannelValue(const AnimationChannel& channel, double seconds) {
  const KeyPlace at = FindKey(channel, seconds);
  const vec4* v = channel.values.data();
  const size_t i = at.key;
  if (channel.interpolation == Interpolation::kCubicSpline) {
    return at.between
               ? Hermite(v[3 * i + 1], v[3 * i + 2], v[3 * i + 3], v[3 * i + 4], at.t, at.gap)
               : v[3 * i + 1];
  }
  if (!at.between) {
    return v[i];
  }
  return channel.property == AnimatedProperty::kRotation ? Slerp(v[i], v[i + 1], at.t)
                                                         : v[i] + (v[i + 1] - v[i]) * at.t;
}

/// \param weights  [out] all elements are set
void ChannelWeights(const AnimationChannel& channel, double seconds, std::vector<float>* weights) {
  const KeyPlace at = FindKey(channel, seconds);
  const size_t n = weights->size();
  for (size_t k = 0; k < n; ++k) {
    const auto value = [&](size_t i) { return channel.weights[i * n + k]; };
    const size_t i = at.key;
    float& weight = (*weights)[k];
    if (channel.interpolation == Interpolation::kCubicSpline) {
      weight = at.between ? Hermite(value(3 * i + 1), value(3 * i + 2), value(3 * i + 3),
                                    value(3 * i + 4), at.t, at.gap)
                          : value(3 * i + 1);
    } else {
      weight = at.between ? value(i) + (value(i + 1) - value(i)) * at.t : value(i);
    }
  }
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
    case AnimatedProperty::kWeights:
      break;  // not a part of the transform
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
    STILLRAY_CHECK_LT(static_cast<size_t>(channel.node), locals.size());
    if (channel.property != AnimatedProperty::kWeights && !channel.times.empty()) {
      STILLRAY_CHECK_EQ(channel.values.size(), channel.times.size() * ValuesPerKey(channel));
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

std::vector<float> MorphWeights(const Scene& scene, int node, double seconds) {
  std::vector<float> weights = scene.nodes[static_cast<size_t>(node)].weights;
  for (const AnimationChannel& channel : scene.animation) {
    if (channel.node == node && channel.property == AnimatedProperty::kWeights &&
        !channel.times.empty()) {
      STILLRAY_CHECK_EQ(channel.weights.size(),
                        channel.times.size() * ValuesPerKey(channel) * weights.size());
      ChannelWeights(channel, seconds, &weights);
    }
  }
  return weights;
}

}  // namespace stillray
