// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Visible surfaces of each pixel of the batch, through transparent ones, and their guides, as on
// the CPU (FindPrimarySurfaces, MakeGuides). If there is only one surface, its hit is kept for the
// paths.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/camera.glsl"
#include "render/vulkan/queue.glsl"
#include "render/previous_normal_shared.h"

// The cameras of the pixel's ray, now and one frame ago.
struct PixelViews {
  GpuView now;
  GpuView before;
};

// Out of the picture if the point was behind the previous camera.
vec2 MotionBetween(PixelViews views, vec3 offset, vec3 previous_offset) {
  if (dot(previous_offset, views.before.forward) <= 0.0f) {
    return 2.0f * vec2(views.before.width, views.before.height);
  }
  return Project(views.before, previous_offset) - Project(views.now, offset);
}

bool HasChangedShape(GpuInstance instance) {
  return instance.previous_positions != instance.positions;
}

// Interpolates a mesh's array of vec3.
vec3 Blend3(uint array, uvec3 corner, vec3 weight) {
  return Vec3At(array + 3u * corner.x) * weight.x + Vec3At(array + 3u * corner.y) * weight.y +
         Vec3At(array + 3u * corner.z) * weight.z;
}

// FrameOf on the CPU; x, y and z are the rows of the transform to the world.
SurfaceFrame FrameOf(GpuInstance instance, GpuHit hit, uint positions, uint normals, vec3 x, vec3 y,
                     vec3 z) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec3 p0 = Vec3At(positions + 3u * corner.x);
  vec3 edge_1 = Vec3At(positions + 3u * corner.y) - p0;
  vec3 edge_2 = Vec3At(positions + 3u * corner.z) - p0;
  SurfaceFrame f;
  f.edge = vec3(dot(x, edge_1), dot(y, edge_1), dot(z, edge_1));
  vec3 other = vec3(dot(x, edge_2), dot(y, edge_2), dot(z, edge_2));
  vec3 n = Blend3(normals, corner, Weights(hit));
  float side = dot(x, cross(y, z)) < 0.0f ? -1.0f : 1.0f;
  vec3 placed = side * vec3(dot(cross(y, z), n), dot(cross(z, x), n), dot(cross(x, y), n));
  f.normal = SafeNormalize(placed, SafeNormalize(cross(f.edge, other), vec3(0.0f)));
  return f;
}

vec3 PreviousNormalAt(GpuInstance i, GpuHit hit, vec3 n) {
  return DeformedNormal(
      FrameOf(i, hit, i.positions, i.normals, i.world_x.xyz, i.world_y.xyz, i.world_z.xyz),
      FrameOf(i, hit, i.previous_positions, i.previous_normals, i.previous_x.xyz, i.previous_y.xyz,
              i.previous_z.xyz),
      n);
}

vec2 SurfaceMotion(PixelViews views, GpuInstance instance, GpuHit hit, vec3 position) {
  vec3 local =
      Blend3(instance.previous_positions, CornersOf(instance, hit.primitive), Weights(hit));
  bool stands = !HasChangedShape(instance) && instance.world_x == instance.previous_x &&
                instance.world_y == instance.previous_y && instance.world_z == instance.previous_z;
  vec3 before =
      stands ? position
             : TransformPoint(instance.previous_x, instance.previous_y, instance.previous_z, local);
  return MotionBetween(views, position - views.now.position, before - views.before.position);
}

void SetMotion(vec2 motion, inout GpuGuides sum) {
  sum.motion_x = motion.x;
  sum.motion_y = motion.y;
}

// Adds a surface with its fraction of the pixel; `heaviest`: it is the largest so far.
void AddLayer(PixelViews views, CameraLayer layer, vec3 direction, bool heaviest,
              inout GpuGuides sum) {
  GpuInstance instance = instances[layer.hit.instance];
  GpuMaterial material = materials[instance.material];
  Surface surface = MakeSurface(material, instance, layer.hit, layer.base_colour, direction);
  vec3 specular_albedo;
  Bsdf bsdf = MakeSurfaceBsdf(material, surface, 0.0f, specular_albedo);
  sum.albedo += DiffuseAlbedo(bsdf) * layer.weight;
  sum.specular_albedo += specular_albedo * layer.weight;
  if (surface.at.front != 0 || material.double_sided != 0u) {
    sum.emission += EmissionOf(material, instance, layer.hit) * layer.weight;
  }
  if (heaviest) {
    sum.depth = dot(surface.at.position - frame.view.position, frame.view.forward);
    sum.normal = surface.at.frame.z;
    SetMotion(SurfaceMotion(views, instance, layer.hit, surface.at.position), sum);
    sum.previous_normal = HasChangedShape(instance)
                              ? PreviousNormalAt(instance, layer.hit, surface.at.frame.z)
                              : vec3(0.0f);
    sum.id = layer.hit.instance + 1u;
    sum.roughness = GuideRoughness(bsdf, surface.roughness);
  }
}

// Returns the number of rays traced.
uint FindGuides(uint number, uvec2 pixel) {
  PixelViews views = PixelViews(frame.view, frame.previous);
  if (frame.view.lens_radius > 0.0f) {
    vec2 point = LensPointOf(SeedOf(pixel));
    views = PixelViews(Through(frame.view, point), Through(frame.previous, point));
  }
  vec3 direction = DirectionOf(views.now, vec2(pixel) + frame.point);
  GpuGuides sum = GpuGuides(vec3(0.0f), kInfinity, vec3(0.0f), 0.0f, vec3(0.0f), 0u, vec3(0.0f),
                            0.0f, vec3(0.0f), 0.0f, vec3(0.0f), 0.0f);
  SetMotion(MotionBetween(views, direction, direction), sum);
  GpuHit first = GpuHit(kInfinity, 0.0f, 0.0f, kNoInstance, 0u);
  CameraWalk walk = StartPixel(pixel, views.now.position, direction);
  CameraLayer layer;
  float largest = 0.0f;
  while (NextLayer(walk, layer)) {
    bool heaviest = walk.layers == 1 || layer.weight > largest;
    largest = heaviest ? layer.weight : largest;
    AddLayer(views, layer, direction, heaviest, sum);
    first = layer.hit;
  }
  if (walk.layers > 1 || (walk.layers == 1 && walk.background > 0.0f)) {
    first.instance = kSeveralLayers;
  }
  sum.background = EnvironmentRadiance(direction) * walk.background;
  guides[number] = sum;
  first_hits[number] = first;
  return uint(walk.passes);
}

void main() {
  uint number = ThreadNumber();
  uint traced = 0u;
  if (number < batch.count) {
    uvec2 pixel = PixelOf(number);
    if (IsInPicture(pixel)) {
      traced = FindGuides(number, pixel);
    }
  }
  CountPrimaryRays(traced);
}
