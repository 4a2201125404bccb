// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Ray queries by ray tracing pipelines. Needs scene.glsl and material_lookup.glsl.
#include "render/vulkan/triangle_test.glsl"
#include "render/vulkan/hardware_set.glsl"

layout(location = 0) rayPayloadEXT HardwareHit first_hit;
layout(location = 1) rayPayloadEXT HardwareShadow shadow_ray;

// Hits at distance 0 are ignored.
const float kLeastDistance = 1e-37f;
// Larger than any distance, but finite.
const float kMostDistance = 3e38f;
// Hits exactly at the end of a ray count, but traceRayEXT may miss them: tmax is slightly larger.
const float kEndScale = 1.0f + 4.0f * 1.1920929e-7f;

// Whether the ray is valid for traceRayEXT, whose behaviour is otherwise undefined.
bool IsTraceable(GpuRay ray) {
  vec3 sum = ray.origin + ray.direction;
  bool finite = !any(isnan(sum)) && !any(isinf(sum));
  return finite && ray.direction != vec3(0.0f) && ray.end > kLeastDistance;
}

GpuHit FindFirstHit(GpuRay ray) {
  GpuHit miss = GpuHit(ray.end, 0.0f, 0.0f, kNoInstance, 0u);
  if (!IsTraceable(ray)) {
    return miss;
  }
  // The callers of first hits handle transparency.
  traceRayEXT(top_level, gl_RayFlagsOpaqueEXT, 0xffu, 0u, 0u, 0u, ray.origin, kLeastDistance,
              ray.direction, min(ray.end * kEndScale, kMostDistance), 0);
  if (first_hit.placement == kNoInstance) {
    return miss;
  }
  GpuHit hit = RefineHit(ray, first_hit);
  return hit.t <= ray.end ? hit : miss;
}

// Transmittance between the ray's origin and end, per channel in 0..1.
vec3 FindTransmittance(GpuRay ray) {
  if (!IsTraceable(ray)) {
    return vec3(1.0f);
  }
  shadow_ray = HardwareShadow(vec3(1.0f), 1u);
  traceRayEXT(top_level, gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT,
              0xffu, 0u, 0u, 0u, ray.origin, kLeastDistance, ray.direction,
              min(ray.end, kMostDistance), 1);
  return shadow_ray.blocked != 0u ? vec3(0.0f) : shadow_ray.light;
}
