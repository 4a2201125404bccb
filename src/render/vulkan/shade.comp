// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// One step of all active paths: adds emission of the hit surfaces, samples lights, and scatters.
// The counterpart of Tracer::Shade on the CPU.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/base_colour.glsl"
#include "render/vulkan/pixel_light.glsl"
#include "render/vulkan/queue.glsl"

layout(local_size_x = 64) in;

// Ends a path whose ray left the scene.
void Leave(uint number, PathState path, vec3 direction) {
  if (lights.environment_irradiance <= 0.0f) {
    return;
  }
  float density = DensityOfEnvironment(path.normal, path.light_total, direction);
  vec3 radiance =
      EnvironmentRadiance(direction) * ScatterWeight(path.density, density, frame.light_sampling);
  FoundLight found = LightMet(path, radiance);
  AddFound(number, path.light, found.diffuse, found.specular);
}

float DensityOfHit(PathState path, GpuHit hit, vec3 direction, float distance) {
  uint first = first_areas[hit.instance];
  if (first == kNoArea) {
    return 0.0f;
  }
  return DensityOfArea(AreaLightAt(first + hit.primitive), path.origin, path.light_total, direction,
                       distance);
}

// Adds the emission of a hit surface.
void MeetLight(uint number, PathState path, GpuMaterial material, GpuInstance instance, GpuHit hit,
               ShadingPoint at, vec3 direction) {
  if (path.first != 0 || !Emits(material) || !(at.front != 0 || material.double_sided != 0u)) {
    return;
  }
  float distance = length(at.position - path.origin);
  float density = DensityOfHit(path, hit, direction, distance);
  vec3 radiance = EmissionOf(material, instance, hit) *
                  ScatterWeight(path.density, density, frame.light_sampling);
  FoundLight found = LightMet(path, radiance);
  AddFound(number, path.light, found.diffuse, found.specular);
}

// Emitted radiance at the sampled point of an area light.
vec3 RadianceOfArea(LightSample light) {
  AreaLight area = area_lights[light.area];
  GpuInstance instance = instances[area.instance];
  GpuMaterial material = materials[instance.material];
  GpuHit hit = GpuHit(light.distance, light.u, light.v, area.instance, area.primitive);
  vec3 radiance = EmissionOf(material, instance, hit);
  if (material.alpha_mode != kAlphaOpaque) {
    radiance *= OpacityOf(material, BaseColour(material, instance, hit).a);
  }
  return radiance;
}

// Light sampling by resampled candidates; `seeks`: `shadow` is the ray to the chosen candidate.
// Returns TotalOf the choices. u.w is used, and replaced by an independent number.
float SeekLight(uint number, PathState path, ShadingPoint at, Bsdf bsdf, inout vec4 u,
                out bool seeks, inout GpuShadow shadow) {
  LightChoices choices = WeighLights(at.position);
  int count = CandidateCount(frame.light_candidates, path.first != 0);
  CandidateChoice choice = NoCandidate(u.w);
  for (int i = 0; i < count; ++i) {
    LightSample light =
        SampleLights(at.position, at.frame.z, choices, CandidateNumbers(u, i, count));
    vec3 wi = ToLocal(at.frame, light.direction);
    if (!(light.density > 0.0f) || !IsConsistent(at, light.direction, wi.z)) {
      continue;
    }
    if (light.area >= 0) {
      light.radiance = RadianceOfArea(light);
    }
    BsdfValue value = EvaluateBsdf(bsdf, at.local_wo, wi, PartOfBsdf(path));
    float weight = SoughtWeight(light.density, value.density, light.delta, frame.light_sampling);
    FoundLight found = LightSought(path, at, light, value, wi.z, weight);
    if (!IsUsableLight(found.diffuse + found.specular)) {
      atomicAdd(counters.dropped, 1u);
      continue;
    }
    float candidate = CandidateWeight(found);
    if (candidate > 0.0f && TakesCandidate(choice, candidate)) {
      PathRay ray = ShadowRayTo(at, light, wi.z > 0.0f);
      shadow = GpuShadow(ray.origin, ray.end, ray.direction, number, found.diffuse,
                         LightSoughtBy(path, wi.z), found.specular, 0u);
    }
  }
  u.w = choice.u;
  seeks = choice.weight > 0.0f;
  if (seeks) {
    float factor = FactorOfChosen(choice, count);
    shadow.diffuse *= factor;
    shadow.specular *= factor;
  }
  return TotalOf(choices);
}

// \param was_first  whether it has just scattered at the first surface
void Continue(uint number, PathState path, bool was_first, vec3 origin, vec3 direction) {
  path.step += 1;
  StorePath(number, path, was_first);
  rays[number] = GpuRay(origin, kInfinity, direction, 0u);
}

// Continues the ray behind a transparent surface. Returns whether the path continues.
bool PassOn(uint number, PathState path, GpuInstance instance, GpuHit hit, vec3 direction) {
  path.free_events += 1;
  if (path.free_events > kMaxFreeEvents) {
    return false;
  }
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  vec3 point = t.p0 * weight.x + t.p1 * weight.y + t.p2 * weight.z;
  Continue(number, path, false, OriginBehindTriangle(t.p0, t.p1, t.p2, point, direction),
           direction);
  return true;
}

// Samples lights at the surface and continues the path. u: LightDimensions of this step. Returns
// whether the path continues.
bool ScatterAt(uint number, PathState path, ShadingPoint at, Bsdf bsdf, vec3 direction, vec4 u,
               out bool seeks, inout GpuShadow shadow) {
  seeks = false;
  if (IsBlack(bsdf)) {
    return false;
  }
  float total = 0.0f;
  if (lights.choice_count > 0 && MaySeekLight(path, bsdf, frame.bounces, frame.light_sampling)) {
    total = SeekLight(number, path, at, bsdf, u, seeks, shadow);
  }
  bool was_first = path.first != 0;
  vec3 onward = vec3(0.0f);
  vec4 scatter_u = NumbersOf(path.seed, ScatterDimensions(path.step));
  if (!ScatterPath(path, at, bsdf, scatter_u, frame.bounces, onward) ||
      !SurvivesRoulette(path, u.w)) {
    return false;
  }
  if (was_first || onward != direction) {
    path.light_total = total;
  }
  // The last ray contributes only if it hits an emitter: it is not traced if there is none to hit.
  if (frame.ends_are_opaque != 0 && path.bounces >= frame.bounces &&
      !LightMayBeMet(at.position, onward)) {
    return false;
  }
  Continue(number, path, was_first, OriginOf(at, onward), onward);
  return true;
}

bool Shade(uint number, out bool seeks, inout GpuShadow shadow) {
  seeks = false;
  PathState path = LoadPath(number);
  GpuHit hit = hits[number];
  vec3 direction = rays[number].direction;
  if (path.first == 0) {
    if (!IsInScatteringMedium(path)) {  // otherwise applied by cross_media
      path.throughput *= Absorb(path.extinction, hit.t);
    }
    if (hit.instance == kNoInstance) {
      Leave(number, path, direction);
      return false;
    }
  }
  GpuInstance instance = instances[hit.instance];
  GpuMaterial material = materials[instance.material];
  vec4 colour = BaseColourOfVertex(number, path.first != 0, material, instance, hit);
  vec4 u = NumbersOf(path.seed, LightDimensions(path.step));
  if (path.first == 0) {
    float opacity = OpacityOf(material, colour.a);
    if (u.w >= opacity) {
      return PassOn(number, path, instance, hit, direction);
    }
    u.w = min(u.w / opacity, kBelowOne);
  }
  // After the last bounce only emission contributes, possibly through smooth glass.
  bool at_end = path.bounces >= frame.bounces && material.transmission <= 0.0f;
  if (at_end && !Emits(material)) {
    return false;
  }
  Surface surface = MakeSurface(material, instance, hit, colour.rgb, direction);
  MeetLight(number, path, material, instance, hit, surface.at, direction);
  if (at_end) {
    return false;
  }
  SpecularAlbedo specular;
  Bsdf bsdf =
      MakeSurfaceBsdf(material, surface, frame.regularise != 0 ? LeastAlpha(path) : 0.0f, specular);
  return ScatterAt(number, path, surface.at, bsdf, direction, u, seeks, shadow);
}

void main() {
  uint parity = batch.phase;
  uint number = 0u;
  bool alive = false;
  bool seeks = false;
  GpuShadow shadow = GpuShadow(vec3(0.0f), 0.0f, vec3(0.0f), 0u, vec3(0.0f), 0, vec3(0.0f), 0u);
  if (gl_GlobalInvocationID.x < queues[kQueueActive + parity].count) {
    number = lists[ListStart(parity) + gl_GlobalInvocationID.x];
    alive = Shade(number, seeks, shadow);
  }
  uint place = TakePlace(kQueueActive + 1u - parity, alive);
  if (alive) {
    lists[ListStart(1u - parity) + place] = number;
  }
  place = TakePlace(kQueueShadow + parity, seeks);
  if (seeks) {
    shadows[place] = shadow;
  }
}
