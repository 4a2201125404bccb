// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The entry point of shaders that trace rays, with FindFirstHit and FindTransmittance: compute
// shaders that traverse stillray's BVH or, with STILLRAY_HARDWARE, ray generation shaders. A shader
// that includes this file starts with
//   #ifdef STILLRAY_HARDWARE
//   #extension GL_EXT_ray_tracing : require
//   #endif
// Needs scene.glsl and material_lookup.glsl.
#ifdef STILLRAY_HARDWARE
#include "render/vulkan/hardware_rays.glsl"

uint ThreadNumber() {
  return gl_LaunchIDEXT.x;
}
#else
#include "render/vulkan/traversal.glsl"

layout(local_size_x = 64) in;

uint ThreadNumber() {
  return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x +
         gl_GlobalInvocationID.x;
}
#endif
