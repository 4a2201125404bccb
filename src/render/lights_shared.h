// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// All lights of a scene at one moment, and importance sampling of them.
//
// Lights with a position (emissive triangles, point and spot lights) are grouped into a few
// clusters. A shading point selects a cluster, the environment or the directional lights by an
// upper bound on their irradiance (power, distance, the cone of the emitters' normals), then one
// light of the cluster in proportion to its power through an alias table: constant time with
// thousands of lights. The bounds follow Conty Estevez and Kulla (2018), "Importance Sampling of
// Many Lights with Adaptive Tree Splitting", for one level of clusters.
//
// In C++ the lights, including the environment, are an argument, LIGHTS_IN. In GLSL, the including
// shader declares the variables and functions of environment_shared.h, a variable `lights` of
// LightShape, and
//   AliasEntry LightEntry(uint i)           an entry of the tables
//   AreaLight AreaLightAt(uint i)
//   PunctualSource PunctualSourceAt(uint i)
#ifndef STILLRAY_RENDER_LIGHTS_SHARED_H
#define STILLRAY_RENDER_LIGHTS_SHARED_H

#ifdef __cplusplus
#include "render/alias_shared.h"
#include "render/environment_shared.h"
#include "render/punctual_shared.h"
#endif

STILLRAY_RENDER_BEGIN

#ifdef __cplusplus
struct LightArrays : LightShape {
  EnvironmentArrays environment;
  const AliasEntry* entries = nullptr;
  const AreaLight* areas = nullptr;
  const PunctualSource* punctuals = nullptr;
};
inline const AliasEntry& LightEntry(const LightArrays& lights, uint i) {
  return lights.entries[i];
}
inline const AreaLight& AreaLightAt(const LightArrays& lights, uint i) {
  return lights.areas[i];
}
inline const PunctualSource& PunctualSourceAt(const LightArrays& lights, uint i) {
  return lights.punctuals[i];
}
#define LIGHTS_IN const LightArrays &lights,
#define LIGHTS lights,
#define LIGHTS_ENVIRONMENT lights.environment,
#else
#define LIGHTS_IN
#define LIGHTS
#define LIGHTS_ENVIRONMENT
#endif

// Importances of the light choices at a shading point, as running sums.
struct LightChoices {
  int count;
  float sums[kMaxLightChoices];
};

SHARED_FN float TotalOf(SHARED_IN(LightChoices) choices) {
  return choices.count > 0 ? choices.sums[choices.count - 1] : 0.0f;
}

struct LightSample {
  vec3 direction;  // unit vector towards the light
  float distance;  // infinite for lights without a position
  vec3 radiance;   // radiance of the environment; irradiance of punctual lights
  float density;   // PDF per solid angle, including the choice of the light; 0: no light
  vec3 point;      // sampled point on an area light
  int delta;       // 1: delta light, `density` is the probability of the choice alone
  vec3 normal;     // normal of an area light, on the side of the shading point
  int area;        // index of the area light, whose emission at (u, v) is the radiance; -1: none
  float u;
  float v;
};

SHARED_FN LightSample NoLight() {
  LightSample none;
  none.direction = vec3(0.0f);
  none.distance = 0.0f;
  none.radiance = vec3(0.0f);
  none.density = 0.0f;
  none.point = vec3(0.0f);
  none.delta = 0;
  none.normal = vec3(0.0f);
  none.area = -1;
  none.u = 0.0f;
  none.v = 0.0f;
  return none;
}

// An angle in 0..pi.
struct LightAngle {
  float cosine;
  float sine;
};

SHARED_FN LightAngle MakeAngle(float cosine, float sine) {
  LightAngle angle;
  angle.cosine = cosine;
  angle.sine = sine;
  return angle;
}

// max(a - b, 0).
SHARED_FN LightAngle LessAngle(LightAngle a, LightAngle b) {
  if (a.cosine >= b.cosine) {
    return MakeAngle(1.0f, 0.0f);
  }
  return MakeAngle(a.cosine * b.cosine + a.sine * b.sine, a.sine * b.cosine - a.cosine * b.sine);
}

// An upper bound on the irradiance at `point`, up to a constant factor; 0 only if the irradiance is
// 0.
SHARED_FN float ClusterImportance(SHARED_IN(LightCluster) cluster, vec3 point) {
  vec3 offset = point - cluster.centre;
  float radius2 = cluster.radius * cluster.radius;
  float distance2 = dot(offset, offset);
  float base = cluster.intensity / max(max(distance2, radius2), 1e-30f);
  if (cluster.cone_cosine <= -1.0f || distance2 <= radius2) {
    return base;
  }
  float inverse2 = 1.0f / distance2;
  float cosine = min(dot(offset, cluster.axis) * sqrt(inverse2), 1.0f);
  cosine = cluster.two_sided != 0 ? abs(cosine) : max(cosine, -1.0f);
  LightAngle to_axis = MakeAngle(cosine, sqrt(max(1.0f - cosine * cosine, 0.0f)));
  float seen2 = min(radius2 * inverse2, 1.0f);
  LightAngle seen = MakeAngle(sqrt(1.0f - seen2), sqrt(seen2));
  LightAngle cone = MakeAngle(cluster.cone_cosine, cluster.cone_sine);
  return base * max(LessAngle(LessAngle(to_axis, cone), seen).cosine, 0.0f);
}

// The importance of each choice at `point`.
SHARED_FN LightChoices WeighLights(LIGHTS_IN vec3 point) {
  LightChoices choices;
  choices.count = lights.choice_count;
  if (choices.count == 0) {
    return choices;
  }
  float sum = 0.0f;
  for (int i = 0; i < lights.cluster_count; ++i) {
    sum += ClusterImportance(lights.clusters[i], point);
    choices.sums[i] = sum;
  }
  choices.sums[lights.cluster_count] = sum + lights.distant_irradiance;
  choices.sums[lights.cluster_count + 1] =
      sum + lights.distant_irradiance + lights.environment_irradiance;
  return choices;
}

// Conservative test whether a ray may hit an emitter or the environment. False is certain as long
// as the ray is not deflected; the test costs much less than tracing the ray.
SHARED_FN bool LightMayBeMet(LIGHTS_IN vec3 origin, vec3 direction) {
  if (lights.environment_irradiance > 0.0f || lights.all_in_clusters == 0) {
    return true;
  }
  // The ray's origin is slightly offset from the surface, in an unknown direction.
  const float kSlack = 1e-4f;
  vec3 inverse = 1.0f / direction;
  for (int i = 0; i < lights.cluster_count; ++i) {
    vec3 low = lights.clusters[i].low;
    vec3 high = lights.clusters[i].high;
    vec3 slack = (abs(low) + abs(high) + abs(origin)) * kSlack + kSlack;
    vec3 t0 = (low - slack - origin) * inverse;
    vec3 t1 = (high + slack - origin) * inverse;
    vec3 nearer = min(t0, t1);
    vec3 farther = max(t0, t1);
    float enter = MaxComponent(nearer);
    float leave = min(farther.x, min(farther.y, farther.z));
    // NaN, if a direction component is zero and the origin exactly on the slab: counts as a hit.
    if (!(enter > leave) && !(leave < 0.0f)) {
      return true;
    }
  }
  return false;
}

// Samples the triangle uniformly. \param choice  selection probability of this light
SHARED_FN LightSample SampleArea(SHARED_IN(AreaLight) light, uint number, vec3 point, float choice,
                                 float u0, float u1) {
  LightSample found = NoLight();
  float root = sqrt(u0);
  found.u = root * (1.0f - u1);
  found.v = root * u1;
  found.point = light.p0 + light.edge1 * found.u + light.edge2 * found.v;
  vec3 offset = found.point - point;
  float distance2 = dot(offset, offset);
  if (!(distance2 > 0.0f)) {
    return found;
  }
  found.distance = sqrt(distance2);
  found.direction = offset / found.distance;
  float cosine = -dot(found.direction, light.normal);
  if (cosine == 0.0f || (cosine < 0.0f && light.two_sided == 0)) {
    return found;
  }
  found.normal = cosine > 0.0f ? light.normal : -light.normal;
  found.area = int(number);
  found.density = choice * distance2 / (light.area * abs(cosine));
  return found;
}

SHARED_FN LightSample SamplePunctual(SHARED_IN(PunctualSource) light, vec3 point, float choice) {
  LightSample found = NoLight();
  found.delta = 1;
  if (light.type == kLightDirectional) {
    found.direction = -light.axis;
    found.distance = kInfinity;
    found.radiance = light.intensity;
    found.density = choice;
    return found;
  }
  vec3 offset = light.position - point;
  float distance2 = dot(offset, offset);
  if (!(distance2 > 0.0f)) {
    return found;
  }
  found.distance = sqrt(distance2);
  found.direction = offset / found.distance;
  float attenuation = RangeAttenuation(found.distance, light.range) / distance2;
  if (light.type == kLightSpot) {
    attenuation *=
        SpotAttenuation(-dot(found.direction, light.axis), light.inner_cosine, light.outer_cosine);
  }
  found.radiance = light.intensity * attenuation;
  found.density = attenuation > 0.0f ? choice : 0.0f;
  return found;
}

// Samples one of `count` entries from `first` on. \param choice  selection probability of the range
SHARED_FN LightSample SampleEntries(LIGHTS_IN uint first, uint count, vec3 point, float choice,
                                    vec4 u) {
  AliasColumn column = FindAliasColumn(count, u.z);
  AliasChoice picked = ChooseInColumn(column, LightEntry(LIGHTS first + column.index));
  AliasEntry entry = LightEntry(LIGHTS first + picked.index);
  float probability = choice * entry.probability;
  if ((entry.item & kPunctualItem) != 0u) {
    return SamplePunctual(PunctualSourceAt(LIGHTS entry.item & ~kPunctualItem), point, probability);
  }
  return SampleArea(AreaLightAt(LIGHTS entry.item), entry.item, point, probability, u.x, u.y);
}

// Samples a light for a shading point: (u.x, u.y) select the position, u.z the light.
// \param choices  WeighLights at `point`
SHARED_FN LightSample SampleLights(LIGHTS_IN vec3 point, vec3 normal,
                                   SHARED_IN(LightChoices) choices, vec4 u) {
  float total = TotalOf(choices);
  if (!(total > 0.0f && total <= kLargestFloat)) {
    return NoLight();
  }
  // The first choice whose running sum exceeds the mark: never one with importance zero, since the
  // mark is below the total.
  float mark = min(u.z * total, intBitsToFloat(floatBitsToInt(total) - 1));
  int choice = 0;
  while (choice < choices.count - 1 && choices.sums[choice] <= mark) {
    ++choice;
  }
  float below = choice > 0 ? choices.sums[choice - 1] : 0.0f;
  float importance = choices.sums[choice] - below;
  u.z = clamp((mark - below) / importance, 0.0f, kBelowOne);
  float probability = importance / total;
  if (choice < lights.cluster_count) {
    return SampleEntries(LIGHTS lights.clusters[choice].first, lights.clusters[choice].count, point,
                         probability, u);
  }
  if (choice == lights.cluster_count) {
    return SampleEntries(LIGHTS lights.first_distant, lights.distant_count, point, probability, u);
  }
  EnvironmentSample from = SampleEnvironment(LIGHTS_ENVIRONMENT normal, u.x, u.y);
  LightSample found = NoLight();
  found.direction = from.direction;
  found.distance = kInfinity;
  found.radiance = from.radiance;
  found.density = from.density * probability;
  return found;
}

// PDF of SampleLights at `point` for the position on an emitter that a ray of unit direction hit at
// `distance`.
// \param total  TotalOf the choices at `point`
SHARED_FN float DensityOfArea(LIGHTS_IN SHARED_IN(AreaLight) light, vec3 point, float total,
                              vec3 direction, float distance) {
  if (!(total > 0.0f && total <= kLargestFloat) || light.choice <= 0.0f) {
    return 0.0f;
  }
  float cosine = abs(dot(direction, light.normal));
  float choice = ClusterImportance(lights.clusters[light.cluster], point) / total * light.choice;
  return cosine > 0.0f ? choice * distance * distance / (light.area * cosine) : 0.0f;
}

// PDF of SampleLights for a direction of the environment.
SHARED_FN float DensityOfEnvironment(LIGHTS_IN vec3 normal, float total, vec3 direction) {
  if (!(total > 0.0f && total <= kLargestFloat)) {
    return 0.0f;
  }
  return EnvironmentDensity(LIGHTS_ENVIRONMENT normal, direction) * lights.environment_irradiance /
         total;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LIGHTS_SHARED_H
