// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_EXT_ray_tracing : require

// Stores the first hit of a ray.
#include "render/vulkan/scene.glsl"
#include "render/vulkan/triangle_test.glsl"
#include "render/vulkan/hardware_set.glsl"

layout(location = 0) rayPayloadInEXT HardwareHit first_hit;
hitAttributeEXT vec2 weights;

void main() {
  first_hit = HardwareHit(vec3(gl_HitTEXT, weights), gl_InstanceCustomIndexEXT, gl_GeometryIndexEXT,
                          gl_PrimitiveID);
}
