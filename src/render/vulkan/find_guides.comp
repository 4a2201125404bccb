// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// What each pixel sees: the camera's rays through all that lets through, and the guides of what
// they meet, as on the CPU (FindPrimarySurfaces, MakeGuides).
#include "render/vulkan/scene.glsl"
#include "render/vulkan/material_lookup.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/traversal.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, set = 1, binding = 0) readonly buffer Frame {
  GpuFrame frame;
};
layout(std430, set = 1, binding = 1) writeonly buffer Guides {
  GpuGuides guides[];  // row by row
};

// A ray that passes more surfaces than these, all cut out by their masks, sees the background.
const int kMaxPasses = 256;
// Surfaces of a pixel that count; the last one takes all light that is left.
const int kMaxLayers = 8;

vec3 DirectionOf(GpuView view, vec2 pixel) {
  float x = (2.0f * pixel.x / view.width - 1.0f) * view.half_width;
  float y = (1.0f - 2.0f * pixel.y / view.height) * view.half_height;
  return normalize(view.forward + view.right * x + view.up * y);
}

// Where the camera sees what lies at `offset` from its position.
vec2 Project(GpuView view, vec3 offset) {
  float depth = dot(offset, view.forward);
  float safe = max(abs(depth), 1e-20f) * (depth < 0.0f ? -1.0f : 1.0f);
  float x = dot(offset, view.right) / (safe * view.half_width);
  float y = dot(offset, view.up) / (safe * view.half_height);
  return vec2((x + 1.0f) * 0.5f * view.width, (1.0f - y) * 0.5f * view.height);
}

// Out of the picture where the previous camera had the point behind it.
vec2 MotionBetween(vec3 offset, vec3 previous_offset) {
  if (dot(previous_offset, frame.previous.forward) <= 0.0f) {
    return 2.0f * vec2(frame.previous.width, frame.previous.height);
  }
  return Project(frame.previous, previous_offset) - Project(frame.view, offset);
}

vec2 SurfaceMotion(GpuInstance instance, GpuHit hit, vec3 position) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  vec3 local = Vec3At(instance.positions + 3u * corner.x) * weight.x +
               Vec3At(instance.positions + 3u * corner.y) * weight.y +
               Vec3At(instance.positions + 3u * corner.z) * weight.z;
  bool stands = instance.world_x == instance.previous_x &&
                instance.world_y == instance.previous_y && instance.world_z == instance.previous_z;
  vec3 before =
      stands ? position
             : TransformPoint(instance.previous_x, instance.previous_y, instance.previous_z, local);
  return MotionBetween(position - frame.view.position, before - frame.previous.position);
}

// Adds a surface with its share of the pixel; `heaviest`: it is the largest so far.
void AddLayer(GpuMaterial material, GpuInstance instance, GpuHit hit, vec3 base_colour,
              vec3 direction, float weight, bool heaviest, inout GpuGuides sum) {
  Surface surface = MakeSurface(material, instance, hit, base_colour, direction);
  vec3 specular_albedo;
  Bsdf bsdf = MakeSurfaceBsdf(material, surface, 0.0f, specular_albedo);
  sum.albedo += bsdf.diffuse * weight;
  sum.specular_albedo += specular_albedo * weight;
  if (surface.at.front != 0 || material.double_sided != 0u) {
    sum.emission += material.emission *
                    TextureValue(material.emissive_texture, instance, hit, true).rgb * weight;
  }
  if (heaviest) {
    sum.depth = dot(surface.at.position - frame.view.position, frame.view.forward);
    sum.normal = surface.at.frame.z;
    sum.motion = SurfaceMotion(instance, hit, surface.at.position);
    sum.id = hit.instance + 1u;
    sum.roughness = surface.roughness;
  }
}

// Where a ray goes on that passes the surface.
vec3 OriginBehind(GpuInstance instance, GpuHit hit, vec3 direction) {
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  vec3 point = t.p0 * weight.x + t.p1 * weight.y + t.p2 * weight.z;
  return OriginBehindTriangle(t.p0, t.p1, t.p2, point, direction);
}

GpuGuides FindGuides(vec2 pixel) {
  float infinity = uintBitsToFloat(0x7f800000u);
  vec3 direction = DirectionOf(frame.view, pixel);
  GpuGuides sum = GpuGuides(vec3(0.0f), infinity, vec3(0.0f), 0.0f, vec3(0.0f), 0u, vec3(0.0f),
                            1.0f, MotionBetween(direction, direction), 0u, 0u);
  vec3 origin = frame.view.position;
  float largest = 0.0f;
  int layers = 0;
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    GpuHit hit = FindFirstHit(GpuRay(origin, infinity, direction, 0u));
    if (hit.instance == kNoInstance) {
      break;
    }
    GpuInstance instance = instances[hit.instance];
    GpuMaterial material = materials[instance.material];
    vec4 colour = BaseColour(material, instance, hit);
    float opacity = OpacityOf(material, colour.a);
    if (opacity > 0.0f) {
      bool last = opacity >= 1.0f || layers == kMaxLayers - 1;
      float weight = last ? sum.background : sum.background * opacity;
      bool heaviest = layers == 0 || weight > largest;
      largest = heaviest ? weight : largest;
      AddLayer(material, instance, hit, colour.rgb, direction, weight, heaviest, sum);
      sum.background = last ? 0.0f : sum.background - weight;
      ++layers;
      if (last) {
        break;
      }
    }
    origin = OriginBehind(instance, hit, direction);
  }
  return sum;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x < frame.width && pixel.y < frame.height) {
    guides[pixel.y * frame.width + pixel.x] = FindGuides(vec2(pixel) + frame.point);
  }
}
