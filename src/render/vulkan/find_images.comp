// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Virtual guides of each pixel of the batch: what its smooth surface reflects, or shows by
// refraction, as on the CPU (FindVirtualImages). Needs the results of find_guides.comp. Threads of
// other pixels end at once.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/previous_surface.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/camera.glsl"
#include "render/vulkan/queue.glsl"
#include "render/virtual_image_shared.h"

// Of the pixel's chain, in the previous frame.
ChainVertex chain_vertices[kMostVertices];
int chain_count = 0;

int ChainCount() {
  return chain_count;
}
ChainVertex ChainVertexAt(int i) {
  return chain_vertices[i];
}
#include "render/chain_search_shared.h"

struct Chain {
  vec3 origin;  // of its next ray
  vec3 direction;
  float distance;   // so far
  vec3 throughput;  // colour of the surfaces behind the first one
  int ray_count;    // 0: before the visible surface
  bool seeks_light;
  float reflectance;  // of the glass, then
};

Chain StartChain(vec3 direction) {
  chain_count = 0;
  return Chain(frame.view.position, direction, 0.0f, vec3(1.0f), 0, false, 1.0f);
}

// Results of Meet.
const int kNoImage = 0;
const int kImage = 1;
const int kOnward = 2;
// Onward from visible glass, which may also reflect a light.
const int kThroughGlass = 3;

ChainVertex VertexAt(GpuInstance instance, GpuHit hit, ShadingPoint at, float eta) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  uint positions = instance.previous_positions;
  uint normals = instance.previous_normals;
  vec3 p0 = Vec3At(positions + 3u * corner.x);
  ChainTriangle triangle;
  triangle.edge_u = Vec3At(positions + 3u * corner.y) - p0;
  triangle.edge_v = Vec3At(positions + 3u * corner.z) - p0;
  triangle.normal_0 = Vec3At(normals + 3u * corner.x);
  triangle.normal_1 = Vec3At(normals + 3u * corner.y);
  triangle.normal_2 = Vec3At(normals + 3u * corner.z);
  triangle.world =
      transpose(mat3(instance.world_x.xyz, instance.world_y.xyz, instance.world_z.xyz));
  triangle.before =
      transpose(mat3(instance.previous_x.xyz, instance.previous_y.xyz, instance.previous_z.xyz));
  triangle.moving = Stands(instance) ? 0 : 1;
  vec3 n = at.frame.z;
  vec3 n_before =
      HasChangedShape(instance) ? PreviousNormalAt(instance, hit, n) : MovedNormal(triangle, n);
  return MakeChainVertex(triangle, PreviousPoint(instance, hit, at.position), n, n_before, eta);
}

// Continues a chain from a surface; false if it ends there.
bool Continue(GpuInstance instance, GpuHit hit, ShadingPoint at, Leaving leaving,
              inout Chain chain) {
  if (leaving.way == kChainEnds || chain.ray_count == kMostChainRays ||
      (leaving.way != kChainGoesOn && chain_count == kMostVertices)) {
    return false;
  }
  vec3 direction = chain.direction;
  if (!TurnChain(leaving, at, direction)) {
    return false;
  }
  if (leaving.way != kChainGoesOn) {
    chain_vertices[chain_count] = VertexAt(instance, hit, at, leaving.eta);
    ++chain_count;
  }
  ++chain.ray_count;
  chain.direction = direction;
  chain.origin = OriginOf(at, direction);
  return true;
}

// Whether glass visibly reflects light of this radiance.
bool IsVisible(Chain chain, vec3 radiance) {
  return chain.reflectance * ChainLuminance(radiance) > kVisibleLight * environment.mean_luminance;
}

// The chain leaves the scene.
int MeetSky(Chain chain, inout GpuImage image, inout ChainEnd end) {
  vec3 radiance = EnvironmentRadiance(chain.direction);
  if (chain.seeks_light && !IsVisible(chain, radiance)) {
    return kNoImage;
  }
  image.depth = kInfinity;
  image.normal = vec3(0.0f);
  image.albedo = chain.throughput * max(radiance, vec3(kLeastRadiance));
  image.id = 0u;
  end = ChainEnd(chain.direction, 1);
  return kImage;
}

// The chain meets a surface, the visible one first.
// \param forward  cosine of the pixel's ray with the camera's axis
int Meet(GpuHit hit, float forward, inout Chain chain, inout GpuImage image, inout ChainEnd end) {
  GpuInstance instance = instances[hit.instance];
  GpuMaterial material = materials[instance.material];
  vec4 colour = BaseColour(material, instance, hit);
  Surface surface = MakeSurface(material, instance, hit, colour.rgb, chain.direction);
  chain.distance += length(surface.at.position - chain.origin);
  bool first = chain.ray_count == 0;
  if (!first && OpacityOf(material, colour.a) < kChainOpacity) {
    return Continue(instance, hit, surface.at, LeavingBy(kChainGoesOn), chain) ? kOnward : kNoImage;
  }
  bool emits = Emits(material);
  vec3 emission = EmissionOf(material, instance, hit);
  if (!first && chain.seeks_light && !(emits && IsVisible(chain, emission))) {
    return kNoImage;
  }
  vec3 specular_albedo;
  Bsdf bsdf = MakeSurfaceBsdf(material, surface, 0.0f, specular_albedo);
  Leaving leaving =
      LeavingOf(bsdf, surface.at, first ? vec3(1.0f) : specular_albedo, first ? 1 : 0);
  bool through = first && (leaving.way == kChainRefracts || leaving.way == kChainGoesOn);
  if (through) {
    chain.reflectance = leaving.reflectance;
  }
  if (first && chain.seeks_light) {
    leaving = LeavingBy(kChainReflects);
  }
  vec3 throughput = chain.throughput;
  if (!first) {
    chain.throughput *= leaving.way == kChainReflects ? specular_albedo : bsdf.tint;
  }
  bool onward = Continue(instance, hit, surface.at, leaving, chain);
  if (first || onward) {
    return through ? kThroughGlass : (onward ? kOnward : kNoImage);
  }
  image.depth = chain.distance * forward;
  image.normal = surface.at.frame.z;
  vec3 own = emits ? max(emission, vec3(kLeastRadiance))
                   : min(DiffuseAlbedo(bsdf) + specular_albedo, vec3(1.0f));
  image.albedo = own * throughput;
  image.id = hit.instance + 1u;
  end = ChainEnd(PreviousPoint(instance, hit, surface.at.position), 0);
  return kImage;
}

void SetMotion(ChainEnd end, vec3 direction, inout GpuImage image) {
  vec2 motion = 2.0f * vec2(frame.previous.width, frame.previous.height);
  vec2 before = vec2(0.0f);
  if (FindPreviousPlace(frame.previous, end, before)) {
    motion = before - Project(frame.view, direction);
  }
  image.motion_x = motion.x;
  image.motion_y = motion.y;
}

// \param first   the hit of the pixel's only surface
// \param traced  [out] number of rays
GpuImage FindImage(uvec2 pixel, GpuHit first, out uint traced) {
  GpuImage image = GpuImage(vec3(0.0f), 0.0f, vec3(0.0f), 0u, 0.0f, 0.0f, 0u, 0u);
  vec3 direction = DirectionOf(frame.view, vec2(pixel) + frame.point);
  float forward = dot(direction, frame.view.forward);
  traced = 0u;
  bool through_glass = false;
  // Then, from glass, a second chain looks for a light that it reflects.
  for (int i = 0; i < 2 && (i == 0 || through_glass); ++i) {
    Chain chain = StartChain(direction);
    chain.seeks_light = i == 1;
    ChainEnd end = ChainEnd(vec3(0.0f), 0);
    GpuHit hit = first;
    int met = kOnward;
    while (met == kOnward) {
      met = hit.instance == kNoInstance ? MeetSky(chain, image, end)
                                        : Meet(hit, forward, chain, image, end);
      if (met == kThroughGlass) {
        through_glass = true;
        met = chain.ray_count > 0 ? kOnward : kNoImage;
      }
      if (met == kOnward) {
        hit = FindFirstHit(GpuRay(chain.origin, kInfinity, chain.direction, 0u));
        ++traced;
      }
    }
    if (met == kImage) {
      SetMotion(end, direction, image);
    }
  }
  return image;
}

void main() {
  uint number = ThreadNumber();
  uint traced = 0u;
  if (number < batch.count) {
    uvec2 pixel = PixelOf(number);
    if (IsInPicture(pixel)) {
      GpuHit first = first_hits[number];
      if (first.instance == kLayerBeforeSky) {
        first.instance = guides[number].id - 1u;
      }
      images[number] = GpuImage(vec3(0.0f), 0.0f, vec3(0.0f), 0u, 0.0f, 0.0f, 0u, 0u);
      if (first.instance != kNoInstance && first.instance != kSeveralLayers) {
        images[number] = FindImage(pixel, first, traced);
      }
    }
  }
  CountImageRays(traced);
}
