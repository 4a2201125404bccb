// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Starts the paths of one sample of the batch at a visible surface: the single layer stored by
// find_guides.comp, or a randomly selected layer; in two parts if transmitted light is separate.
// With STILLRAY_REFERENCE no layer is stored: each sample traces its own primary ray, and emission
// along it is added to the guides.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/traversal.glsl"
#include "render/vulkan/camera.glsl"
#include "render/vulkan/queue.glsl"

layout(local_size_x = 64) in;

// Whether the ray hits the front face.
bool SeenFromFront(GpuInstance instance, GpuHit hit, vec3 direction) {
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  float volume = dot(cross(t.p1 - t.p0, t.p2 - t.p0), direction);
  return volume * Orientation(instance) <= 0.0f;
}

vec3 EmissionTowardsViewer(GpuHit hit, vec3 direction) {
  GpuInstance instance = instances[hit.instance];
  GpuMaterial material = materials[instance.material];
  if (!Emits(material) ||
      (material.double_sided == 0u && !SeenFromFront(instance, hit, direction))) {
    return vec3(0.0f);
  }
  return EmissionOf(material, instance, hit);
}

// Selects one of the layers along a primary ray in proportion to their weights; kNoInstance: the
// background. u in [0, 1).
// \param separates  select only the first layer in part 0, only the other layers in part 1
// \param weight     [out] total weight of the eligible layers
GpuHit PickLayer(uint number, CameraWalk walk, float u, bool separates, out float weight,
                 out uint traced) {
  GpuHit hit = GpuHit(kInfinity, 0.0f, 0.0f, kNoInstance, 0u);
  vec3 emission = vec3(0.0f);
  bool found = false;
  vec3 direction = walk.direction;
  weight = 1.0f;
  CameraLayer layer;
  while (NextLayer(walk, layer)) {
    if (separates && walk.layers == 1) {
      weight = batch.part == 0u ? layer.weight : 1.0f - layer.weight;
      u *= weight;
      found = batch.part == 0u;
      hit = layer.hit;
    } else if (!found) {
      hit = layer.hit;
      found = u < layer.weight;
      u -= layer.weight;
    }
#ifdef STILLRAY_REFERENCE
    emission += EmissionTowardsViewer(layer.hit, direction) * layer.weight;
#endif
  }
  // Weights sum to 1 only up to rounding: the fallback is the background or else the last layer.
  if (!found && walk.background > 0.0f) {
    hit.instance = kNoInstance;
  }
#ifdef STILLRAY_REFERENCE
  guides[number].emission = emission;
  guides[number].background = EnvironmentRadiance(direction) * walk.background;
#endif
  traced = uint(walk.passes);
  return hit;
}

// Returns whether a path starts.
bool Start(uint number, uvec2 pixel, out uint traced) {
  traced = 0u;
  uint seed = SeedOf(pixel);
#ifdef STILLRAY_REFERENCE
  bool separates = false;
#else
  bool separates = frame.signal_count > kSurfaceSignals && SeparatesTransmission(guides[number]);
#endif
  if (batch.part == 0u) {
    for (uint k = 0u; k < frame.signal_count; ++k) {
      sample_lights[FirstSignal(number) + k] = GpuSignal(vec3(0.0f), 0.0f);
    }
  } else if (!separates) {
    return false;
  }
  float weight = 1.0f;
  GpuView view = Through(frame.view, LensPointOf(seed));
#ifdef STILLRAY_REFERENCE
  vec4 u = NumbersOf(seed, kPrimaryDimensions);
  vec2 point = frame.spread_points != 0 ? u.xy : vec2(0.5f);
  vec3 direction = DirectionOf(view, vec2(pixel) + point);
  GpuHit hit = PickLayer(number, StartWalk(view.position, direction), u.w, false, weight, traced);
#else
  vec3 direction = DirectionOf(view, vec2(pixel) + frame.point);
  GpuHit hit = first_hits[number];
  bool layered = hit.instance == kSeveralLayers;
  if (layered || hit.instance == kLayerBeforeSky) {
    hit = PickLayer(number, StartPixel(pixel, view.position, direction),
                    NumbersOf(seed, kPrimaryDimensions).w, separates, weight, traced);
  }
#endif
  if (hit.instance == kNoInstance) {
    return false;
  }
  PathState path = StartPath(seed);
#ifndef STILLRAY_REFERENCE
  if (separates) {
    StartPart(path, int(batch.part), layered, weight);
  }
#endif
  StorePath(number, path, false);
  rays[number] = GpuRay(view.position, kInfinity, direction, 0u);
  hits[number] = hit;
  return true;
}

void main() {
  uint number = gl_GlobalInvocationID.x;
  uint traced = 0u;
  bool starts = false;
  if (number < batch.count && !IsStopped()) {
    uvec2 pixel = PixelOf(number);
    if (IsInPicture(pixel)) {
      starts = Start(number, pixel, traced);
    }
  }
  uint place = TakePlace(kQueueActive, starts);
  if (starts) {
    lists[ListStart(0u) + place] = number;
  }
  CountPrimaryRays(traced);
}
