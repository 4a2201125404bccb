// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The steps of a path, one vertex at a time.
//
// At every vertex direct light is estimated by light sampling (a shadow ray) and by BSDF sampling
// (the scattered ray), combined by multiple importance sampling (Veach 1997), or by one strategy
// alone. The diffuse and specular lobes of the first surface are kept separate: the path carries
// one weight for each. Frames that separate transmitted light trace a second path in pixels of
// smooth glass and of alpha-blended layers: for the reflection, or for the layers behind the first
// one.
#ifndef STILLRAY_RENDER_PATH_SHARED_H
#define STILLRAY_RENDER_PATH_SHARED_H

#ifdef __cplusplus
#include "render/lights_shared.h"
#include "render/medium_shared.h"
#include "render/shading_point_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Maximum number of scattering events that do not count as bounces (ideally smooth glass,
// undeflected passes).
const int kMaxFreeEvents = 24;
// Path-space regularisation (SVGF, section 3; after Kaplanyan and Dachsbacher 2013): the GGX alpha
// of a surface is at least this factor times the largest mean alpha of the earlier path vertices.
// The mean of a vertex is weighted by the selection probabilities of its lobes, with diffuse lobes
// at 1. Ideally smooth thin sheets are unchanged.
const float kRegularisation = 0.3f;
// Bounces before Russian roulette starts.
const int kRouletteBounces = 3;
const float kLeastSurvival = 0.05f;
// Length of shadow rays as a fraction of the distance to the light.
const float kShadowEnd = 1.0f - 1e-5f;

// Values of LightSampling.
const int kSampleNone = 0;
const int kSampleBsdf = 1;
const int kSampleLight = 2;
const int kSampleMis = 3;

// Properties of the light that a path collects, as bits.
const int kLightDirect = 1;
// Transmitted by the specular lobe of the first surface, which is glass.
const int kLightTransmitted = 2;
// From behind an alpha-blended surface: the path started at a later layer.
const int kLightBehind = 4;

// State of a path between two vertices.
struct PathState {
  vec3 throughput;    // throughput after the first surface
  float density;      // PDF of the ray per solid angle; 0: ideally smooth lobe
  vec3 diffuse;       // throughput of the first surface's lobes, for light from beyond it
  float light_total;  // TotalOf the light choices at the point where `density` was sampled
  vec3 specular;
  float roughest;       // largest mean alpha so far, for regularisation
  vec3 extinction;      // extinction coefficient of the solid around the path, per unit length
  int collisions;       // number of medium collisions so far
  vec3 scatter_albedo;  // single-scattering albedo of that solid; 0: absorption only
  float scatter_anisotropy;
  vec3 origin;  // last vertex that deflected the path, or its first vertex
  int step;     // number of surface and medium steps so far
  vec3 normal;  // shading normal at `origin`
  int bounces;  // number of scattering events after the first surface
  int free_events;
  int first;  // at the first surface: 1 + the subset of lobes to sample (kAllLobes...); 0 after it
  int light;  // kLight...: properties of the light that the next hit contributes
  uint seed;  // seed of the pixel's random numbers
};

SHARED_FN PathState StartPath(uint seed) {
  PathState path;
  path.throughput = vec3(1.0f);
  path.density = 0.0f;
  path.diffuse = vec3(0.0f);
  path.light_total = 0.0f;
  path.specular = vec3(0.0f);
  path.roughest = 0.0f;
  path.extinction = vec3(0.0f);
  path.collisions = 0;
  path.scatter_albedo = vec3(0.0f);
  path.scatter_anisotropy = 0.0f;
  path.origin = vec3(0.0f);
  path.step = 0;
  path.normal = vec3(0.0f);
  path.bounces = 0;
  path.free_events = 0;
  path.first = 1 + kAllLobes;
  path.light = 0;
  path.seed = seed;
  return path;
}

// Weighted contribution of a ray; for light sampling it counts only if the shadow ray is
// unoccluded.
struct FoundLight {
  vec3 diffuse;
  vec3 specular;
};

struct PathRay {
  vec3 origin;
  float end;
  vec3 direction;
};

// NaN, infinite and negative contributions must not reach the image.
SHARED_FN bool IsUsableLight(vec3 v) {
  return v.x >= 0.0f && v.y >= 0.0f && v.z >= 0.0f && v.x + v.y + v.z <= kLargestFloat;
}

SHARED_FN float ExtinctionOf(float colour, float distance) {
  const float kDarkest = 1e-6f;
  return -log(clamp(colour, kDarkest, 1.0f)) / distance;
}

// Extinction of the medium that a ray leaving the surface enters. `below`: the ray leaves on the
// side opposite to the viewer.
SHARED_FN vec3 ExtinctionBeyond(vec3 here, SHARED_IN(ShadingPoint) at, bool below) {
  if (!below || at.solid == 0) {
    return here;
  }
  float distance = at.attenuation_distance;
  if (at.front == 0 || !(distance > 0.0f && distance <= kLargestFloat)) {
    return vec3(0.0f);
  }
  return vec3(ExtinctionOf(at.attenuation_colour.x, distance),
              ExtinctionOf(at.attenuation_colour.y, distance),
              ExtinctionOf(at.attenuation_colour.z, distance));
}

// Beer's law.
SHARED_FN vec3 Absorb(vec3 absorption, float distance) {
  const float kFar = 1e30f;  // 0 times infinity is NaN
  return absorption == vec3(0.0f) ? vec3(1.0f) : exp(-absorption * min(distance, kFar));
}

// Updates the medium of the path for a ray that leaves the surface. `below`: the ray leaves on the
// side opposite to the viewer.
SHARED_FN void EnterMedium(SHARED_INOUT(PathState) path, SHARED_IN(ShadingPoint) at, bool below) {
  path.extinction = ExtinctionBeyond(path.extinction, at, below);
  if (!below || at.solid == 0) {
    return;
  }
  path.scatter_albedo = vec3(0.0f);
  if (at.front != 0 && Scatters(at)) {
    path.scatter_albedo = vec3(SingleScatterAlbedo(at.multiscatter_colour.x),
                               SingleScatterAlbedo(at.multiscatter_colour.y),
                               SingleScatterAlbedo(at.multiscatter_colour.z));
    path.scatter_anisotropy = at.scatter_anisotropy;
  }
}

// MIS weight of light hit by the scattered ray, for which light sampling has the PDF
// `light_density`.
// \param density   PDF of the ray; 0: ideally smooth, so that light sampling cannot generate it
// \param sampling  kSample...
SHARED_FN float ScatterWeight(float density, float light_density, int sampling) {
  if (density <= 0.0f || sampling <= kSampleBsdf) {
    return 1.0f;
  }
  if (sampling == kSampleLight) {
    return light_density > 0.0f ? 0.0f : 1.0f;
  }
  return MisWeight(density, light_density);
}

// MIS weight of a sampled light, for whose direction BSDF sampling has the PDF `density`.
// \param delta  1: scattered rays cannot hit the light
SHARED_FN float SoughtWeight(float light_density, float density, int delta, int sampling) {
  if (sampling == kSampleBsdf) {
    return delta != 0 ? 1.0f : 0.0f;
  }
  return delta != 0 || sampling == kSampleLight ? 1.0f : MisWeight(light_density, density);
}

// Firefly clamping: scales `found` so that no component of its sum exceeds `most`; 0: no limit.
// Both lobes keep their share and hue. A limit on luminance would admit saturated blue at 14 times
// the limit.
SHARED_FN FoundLight ClampLight(FoundLight found, float most) {
  float largest = MaxComponent(found.diffuse + found.specular);
  if (most > 0.0f && largest > most) {
    float scale = most / largest;
    found.diffuse *= scale;
    found.specular *= scale;
  }
  return found;
}

// Minimum GGX alpha of the next surface; 0: none.
SHARED_FN float LeastAlpha(SHARED_IN(PathState) path) {
  float alpha = kRegularisation * path.roughest;
  return alpha > kSmoothAlpha ? alpha : 0.0f;
}

// Restricts a path to one of the two parts that are traced in pixels with separate transmitted
// light.
// \param part     0 or 1
// \param layered  the pixel has several layers: its path starts at the first one or, with
//     `weight`, at a later one
SHARED_FN void StartPart(SHARED_INOUT(PathState) path, int part, bool layered, float weight) {
  if (layered) {
    path.throughput = vec3(weight);
    path.light = part != 0 ? kLightBehind : 0;
  } else {
    path.first = 1 + (part != 0 ? kReflectionOfGlass : kLobesWithoutReflection);
  }
}

// Signal indices in a frame, by SignalKind.
const int kDirectDiffuse = 0;
const int kIndirectDiffuse = 1;
const int kDirectSpecular = 2;
const int kIndirectSpecular = 3;
const int kDirectTransmission = 4;
const int kIndirectTransmission = 5;
// Number of signals in frames without and with separate transmitted light.
const int kSurfaceSignals = 4;
const int kAllSignals = 6;

SHARED_FN int DiffuseKind(int light) {
  return (light & kLightDirect) != 0 ? kDirectDiffuse : kIndirectDiffuse;
}

// Signal index of specular light.
SHARED_FN int SpecularKind(int light) {
  bool transmitted = (light & (kLightTransmitted | kLightBehind)) != 0;
  int direct = transmitted ? kDirectTransmission : kDirectSpecular;
  return (light & kLightDirect) != 0 ? direct : direct + 1;
}

// Assigns the contributions of both lobes to signals: all light from behind an alpha-blended
// surface is transmitted light.
SHARED_FN FoundLight SortLight(FoundLight found, int light) {
  if ((light & kLightBehind) != 0) {
    found.specular += found.diffuse;
    found.diffuse = vec3(0.0f);
  }
  return found;
}

// The subset of lobes that the path samples at the current surface.
SHARED_FN int PartOfBsdf(SHARED_IN(PathState) path) {
  return max(path.first - 1, kAllLobes);
}

// Whether a direction carries separate transmitted light of glass. \param local_z  z of the
// direction
SHARED_FN bool IsTransmitted(SHARED_IN(PathState) path, float local_z) {
  return PartOfBsdf(path) == kLobesWithoutReflection && local_z < 0.0f;
}

// Properties of light sampled at a surface. \param local_z  z of its direction
SHARED_FN int LightSoughtBy(SHARED_IN(PathState) path, float local_z) {
  int light = path.light & ~kLightDirect;
  light |= path.first != 0 ? kLightDirect : 0;
  return light | (IsTransmitted(path, local_z) ? kLightTransmitted : 0);
}

// Contribution of emitted radiance hit by the path's ray.
SHARED_FN FoundLight LightMet(SHARED_IN(PathState) path, vec3 radiance) {
  vec3 light = path.throughput * radiance;
  FoundLight found;
  found.diffuse = path.diffuse * light;
  found.specular = path.specular * light;
  return found;
}

// Contribution of light sampling.
// \param value    value of the BSDF for the light's direction
// \param local_z  z of that direction
// \param weight   MIS weight of this strategy
SHARED_FN FoundLight LightSought(SHARED_IN(PathState) path, SHARED_IN(ShadingPoint) at,
                                 SHARED_IN(LightSample) light, SHARED_IN(BsdfValue) value,
                                 float local_z, float weight) {
  vec3 arriving = path.throughput * light.radiance * (weight / light.density) *
                  Absorb(ExtinctionBeyond(path.extinction, at, local_z < 0.0f), light.distance);
  FoundLight found;
  if (path.first != 0) {
    found.diffuse = value.diffuse * arriving;
    found.specular = value.specular * arriving;
  } else {
    vec3 scattered = (value.diffuse + value.specular) * arriving;
    found.diffuse = path.diffuse * scattered;
    found.specular = path.specular * scattered;
  }
  return found;
}

// The shadow ray to the sampled light.
SHARED_FN PathRay ShadowRayTo(SHARED_IN(ShadingPoint) at, SHARED_IN(LightSample) light,
                              bool above) {
  PathRay ray;
  ray.origin = OffsetPoint(at.position, above ? at.geometric : -at.geometric);
  ray.direction = light.direction;
  ray.end = light.distance;
  if (light.area >= 0) {
    vec3 offset = OffsetPoint(light.point, light.normal) - ray.origin;
    ray.end = length(offset);
    ray.direction = offset / ray.end;
  }
  ray.end *= kShadowEnd;
  return ray;
}

SHARED_FN bool IsBlack(SHARED_IN(Bsdf) bsdf) {
  float of_layers = bsdf.layered != 0 ? bsdf.pick_through + bsdf.pick_sheen + bsdf.pick_coat : 0.0f;
  return bsdf.pick_diffuse + bsdf.pick_specular + bsdf.pick_glass + of_layers <= 0.0f;
}

// Whether light sampling is possible: at least one lobe must not be ideally smooth.
SHARED_FN bool MaySeekLight(SHARED_IN(PathState) path, SHARED_IN(Bsdf) bsdf, int most_bounces,
                            int sampling) {
  bool any_rough = bsdf.pick_diffuse > 0.0f || bsdf.specular_alpha > 0.0f ||
                   (bsdf.pick_glass > 0.0f && bsdf.glass_alpha > 0.0f) ||
                   (bsdf.layered != 0 && (bsdf.pick_through > 0.0f || bsdf.pick_sheen > 0.0f ||
                                          (bsdf.pick_coat > 0.0f && bsdf.coat_alpha > 0.0f)));
  return sampling != kSampleNone && any_rough && (path.first != 0 || path.bounces < most_bounces);
}

// Mean alpha of the lobes, weighted by their selection probabilities.
SHARED_FN float MeanAlpha(SHARED_IN(Bsdf) bsdf) {
  float mean = bsdf.pick_diffuse + bsdf.pick_specular * SpecularMeanAlpha(bsdf) +
               bsdf.pick_glass * bsdf.glass_alpha;
  return bsdf.layered != 0
             ? mean + bsdf.pick_through + bsdf.pick_sheen + bsdf.pick_coat * bsdf.coat_alpha
             : mean;
}

// Samples the next ray and updates the throughput. Returns whether the path continues.
// \param direction  [out] direction of the next ray
SHARED_FN bool ScatterPath(SHARED_INOUT(PathState) path, SHARED_IN(ShadingPoint) at,
                           SHARED_IN(Bsdf) bsdf, vec4 u, int most_bounces,
                           SHARED_INOUT(vec3) direction) {
  BsdfSample drawn = SampleBsdf(bsdf, at.local_wo, u, PartOfBsdf(path));
  if (drawn.kind == kScatterNone) {
    return false;
  }
  direction = SafeNormalize(ToWorld(at.frame, drawn.wi), at.wo);
  if (drawn.kind == kScatterStraight) {
    direction = -at.wo;
  } else if (!IsConsistent(at, direction, drawn.wi.z)) {
    return false;
  }
  bool in_solid = at.solid != 0 && at.front == 0;
  bool is_free = drawn.kind == kScatterRefract || drawn.kind == kScatterStraight ||
                 (drawn.kind == kScatterMirror && in_solid && bsdf.pick_glass > 0.0f);
  if (is_free) {
    path.free_events += 1;
    if (path.free_events > kMaxFreeEvents) {
      return false;
    }
  } else if (path.first == 0) {
    path.bounces += 1;
    if (path.bounces > most_bounces) {
      return false;
    }
  }
  if (path.first != 0) {
    path.diffuse = drawn.diffuse;
    path.specular = drawn.specular;
    path.light |= kLightDirect | (IsTransmitted(path, drawn.wi.z) ? kLightTransmitted : 0);
  } else {
    path.throughput *= drawn.diffuse + drawn.specular;
    // Light through an undeflecting sheet stays direct: shadow rays pass the sheet too.
    path.light = drawn.kind == kScatterStraight ? path.light : path.light & ~kLightDirect;
  }
  EnterMedium(path, at, drawn.wi.z < 0.0f);
  if (drawn.kind == kScatterRough) {
    path.roughest = max(path.roughest, MeanAlpha(bsdf));
  }
  if (path.first != 0 || drawn.kind != kScatterStraight) {
    path.origin = at.position;
    path.normal = at.frame.z;
    path.density = drawn.density;
  }
  path.first = 0;
  return true;
}

// Russian roulette.
SHARED_FN bool SurvivesRoulette(SHARED_INOUT(PathState) path, float u) {
  if (path.bounces < kRouletteBounces && path.collisions < kRouletteCollisions) {
    return true;
  }
  float weight = MaxComponent(path.throughput * max(path.diffuse, path.specular));
  float survival = clamp(weight, kLeastSurvival, 1.0f);
  if (u >= survival) {
    return false;
  }
  path.throughput /= survival;
  return true;
}

// Whether the medium around the path scatters light.
SHARED_FN bool IsInScatteringMedium(SHARED_IN(PathState) path) {
  return path.scatter_albedo != vec3(0.0f);
}

// Outcome of CrossMedium.
const int kMediumPasses = 0;
const int kMediumScatters = 1;
const int kMediumEnds = 2;

// Advances the path through the medium around it. All collisions of a path together count as one
// bounce, since subsurface scattering looks like one surface and dense media need hundreds of
// collisions. There is no light sampling at collisions, since the boundary blocks shadow rays;
// scattered rays reach the lights.
// \param far        distance to the next surface along the ray
// \param u          random numbers of MediumDimensions; \param roulette  random number
// \param direction  direction of the ray; replaced by the scattered direction
// \param distance   [out] distance to the collision
// \return kMedium...
SHARED_FN int CrossMedium(SHARED_INOUT(PathState) path, float far, vec4 u, float roulette,
                          int most_bounces, SHARED_INOUT(vec3) direction,
                          SHARED_INOUT(float) distance) {
  vec3 share = path.throughput * max(path.diffuse, path.specular);
  Flight flight = FlyThrough(path.extinction, path.scatter_albedo, share, far, u.x, u.y);
  path.throughput *= flight.weight;
  if (flight.collides == 0) {
    return kMediumPasses;
  }
  path.bounces += path.collisions == 0 ? 1 : 0;
  path.collisions += 1;
  if (path.bounces > most_bounces || path.collisions > kMaxCollisions ||
      !SurvivesRoulette(path, roulette)) {
    return kMediumEnds;
  }
  path.density = 0.0f;
  path.light &= ~kLightDirect;
  direction = SampleScattering(direction, path.scatter_anisotropy, u.z, u.w);
  distance = flight.distance;
  return kMediumScatters;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_PATH_SHARED_H
