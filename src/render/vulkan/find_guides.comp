// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Layers of each pixel of the batch along the primary ray, and their guides, as on the CPU
// (FindPrimarySurfaces, MakeGuides). The hit of a single layer is kept for the paths.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/camera.glsl"
#include "render/vulkan/queue.glsl"
#include "render/vulkan/previous_surface.glsl"
#include "render/vulkan/base_colour.glsl"

// The cameras of the primary ray in the current and the previous frame. They are recomputed where
// needed: ray generation shaders spill all live variables while a ray is traced.
struct PixelViews {
  GpuView now;
  GpuView before;
};

PixelViews ViewsOf(uvec2 pixel) {
  PixelViews views = PixelViews(frame.view, frame.previous);
  if (frame.view.lens_radius > 0.0f) {
    vec2 point = LensPointOf(SeedOf(pixel));
    views = PixelViews(Through(frame.view, point), Through(frame.previous, point));
  }
  return views;
}

// Motion vector; leads outside the image if the point was behind the previous camera.
vec2 MotionBetween(PixelViews views, vec3 offset, vec3 previous_offset) {
  if (dot(previous_offset, views.before.forward) <= 0.0f) {
    return 2.0f * vec2(views.before.width, views.before.height);
  }
  return Project(views.before, previous_offset) - Project(views.now, offset);
}

vec2 SurfaceMotion(PixelViews views, GpuInstance instance, GpuHit hit, vec3 position) {
  vec3 before = PreviousPoint(instance, hit, position);
  return MotionBetween(views, position - views.now.position, before - views.before.position);
}

void SetMotion(vec2 motion, inout GpuGuides sum) {
  sum.motion_x = motion.x;
  sum.motion_y = motion.y;
}

// Adds the albedos of a layer. \param first whether it is the first layer
void AddAlbedos(Bsdf bsdf, SpecularAlbedo specular, float weight, bool first, inout GpuGuides sum) {
  bool separates = frame.signal_count > kSurfaceSignals;
  if (separates && !first) {
    sum.transmission_albedo += vec3(weight);
    return;
  }
  bool glass = separates && weight >= 1.0f && IsSmoothGlass(bsdf);
  sum.albedo += DiffuseAlbedo(bsdf) * weight;
  sum.specular_albedo += (glass ? specular.reflected : SumOf(specular)) * weight;
  sum.transmission_albedo += glass ? specular.transmitted * weight : vec3(0.0f);
}

// Replaces the base colour of the pixel's only layer, which is opaque, by the mean over the pixel.
void AverageColour(uvec2 pixel, inout CameraLayer layer, inout GpuGuides sum) {
  GpuInstance instance = instances[layer.hit.instance];
  GpuMaterial material = materials[instance.material];
  if (HasMeanColour(material)) {
    vec2 point = vec2(pixel) + frame.point;
    PixelRays rays = RaysBeside(ViewsOf(pixel).now, point);
    layer.base_colour =
        MeanBaseColour(material, instance, layer.hit, rays, point, layer.base_colour);
    SetColour(sum, layer.base_colour);
  }
}

// Adds a layer to the pixel's guides.
// \param first  whether it is the first layer; \param shown whether it provides the remaining
//     guides so far
void AddLayer(uvec2 pixel, CameraLayer layer, vec3 direction, bool first, bool shown,
              inout GpuGuides sum) {
  GpuInstance instance = instances[layer.hit.instance];
  GpuMaterial material = materials[instance.material];
  Surface surface = MakeSurface(material, instance, layer.hit, layer.base_colour, direction);
  SpecularAlbedo specular;
  Bsdf bsdf = MakeSurfaceBsdf(material, surface, 0.0f, specular);
  AddAlbedos(bsdf, specular, layer.weight, first, sum);
  if (surface.at.front != 0 || material.double_sided != 0u) {
    sum.emission += EmissionOf(material, instance, layer.hit) * layer.weight;
  }
  if (shown) {
    sum.depth = dot(surface.at.position - frame.view.position, frame.view.forward);
    sum.normal = surface.at.frame.z;
    SetMotion(SurfaceMotion(ViewsOf(pixel), instance, layer.hit, surface.at.position), sum);
    sum.previous_normal = HasChangedShape(instance)
                              ? PreviousNormalAt(instance, layer.hit, surface.at.frame.z)
                              : vec3(0.0f);
    sum.id = layer.hit.instance + 1u;
    sum.roughness = GuideRoughness(bsdf, surface.roughness);
  }
}

// Returns the number of traced rays.
uint FindGuides(uint number, uvec2 pixel) {
  PixelViews views = ViewsOf(pixel);
  vec3 direction = DirectionOf(views.now, vec2(pixel) + frame.point);
  GpuGuides sum = GpuGuides(vec3(0.0f), kInfinity, vec3(0.0f), 0.0f, vec3(0.0f), 0u, vec3(0.0f),
                            0.0f, vec3(0.0f), 0.0f, vec3(0.0f), 0u, vec3(0.0f), 0u);
  SetMotion(MotionBetween(views, direction, direction), sum);
  GpuHit first = GpuHit(kInfinity, 0.0f, 0.0f, kNoInstance, 0u);
  CameraWalk walk = StartPixel(pixel, views.now.position, direction);
  CameraLayer layer;
  float largest = 0.0f;
  while (NextLayer(walk, layer)) {
    bool is_first = walk.layers == 1;
    bool shown = is_first || (frame.signal_count <= kSurfaceSignals && layer.weight > largest);
    largest = shown ? layer.weight : largest;
    if (is_first && layer.weight >= 1.0f) {
      AverageColour(pixel, layer, sum);
    }
    AddLayer(pixel, layer, direction, is_first, shown, sum);
    first = layer.hit;
  }
  if (walk.layers > 1) {
    first.instance = kSeveralLayers;
  } else if (walk.layers == 1 && walk.background > 0.0f) {
    first.instance = kLayerBeforeSky;
  }
  sum.background = EnvironmentRadiance(direction) * walk.background;
  guides[number] = sum;
  first_hits[number] = first;
  return uint(walk.passes);
}

void main() {
  uint number = ThreadNumber();
  uint traced = 0u;
  if (number < batch.count && !IsStopped()) {
    uvec2 pixel = PixelOf(number);
    if (IsInPicture(pixel)) {
      traced = FindGuides(number, pixel);
    }
  }
  CountPrimaryRays(traced);
}
