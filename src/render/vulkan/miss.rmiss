// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_ray_tracing : require

// Runs for rays without a hit; with STILLRAY_SHADOW, for shadow rays without an opaque hit.
#include "render/vulkan/scene.glsl"
#include "render/vulkan/triangle_test.glsl"
#include "render/vulkan/hardware_set.glsl"

#ifdef STILLRAY_SHADOW
layout(location = 1) rayPayloadInEXT HardwareShadow shadow_ray;

void main() {
  shadow_ray.blocked = 0u;
}
#else
layout(location = 0) rayPayloadInEXT HardwareHit first_hit;

void main() {
  first_hit.placement = kNoInstance;
}
#endif
