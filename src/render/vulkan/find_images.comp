// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 460
#ifdef STILLRAY_HARDWARE
#extension GL_EXT_ray_tracing : require
#endif

// Virtual guides of each pixel of the batch: guides of the reflected and the transmitted virtual
// image, as on the CPU (FindVirtualImages). Needs the results of find_guides.comp. Threads of
// pixels without virtual images return immediately.
#include "render/vulkan/tracer.glsl"
#include "render/vulkan/surface.glsl"
#include "render/vulkan/previous_surface.glsl"
#include "render/vulkan/rays.glsl"
#include "render/vulkan/camera.glsl"
#include "render/vulkan/queue.glsl"
#include "render/vulkan/base_colour.glsl"

// With mean base colours: the rays beside the chain, in the current frame.
PixelRays chain_beside;
// Vertices of the pixel's chain in the previous frame.
ChainVertex chain_vertices[kMostVertices];
int chain_count = 0;

int ChainCount() {
  return chain_count;
}
ChainVertex ChainVertexAt(int i) {
  return chain_vertices[i];
}
#include "render/chain_search_shared.h"

// First event of a chain.
const int kReflected = 0;    // reflection by the visible surface
const int kTransmitted = 1;  // transmission by the visible surface
const int kBehind = 2;       // starts and ends at a surface behind an alpha-blended surface

struct Chain {
  vec3 origin;  // origin of the next ray
  vec3 direction;
  float distance;   // length of the chain so far
  vec3 throughput;  // colour of the surfaces behind the first one
  int ray_count;    // number of rays; 0: before the visible surface
  int begin;        // kReflected, ...
  // Inputs of ReflectsVisibly, set by reflections:
  float reflectance;  // SolidReflectance of the visible surface
  float light;        // luminance of an emitter or the sky seen by a single reflection
};

Chain StartChain(uvec2 pixel, vec3 direction, int begin) {
  chain_count = 0;
  if (frame.filters_textures != 0) {
    chain_beside = RaysBeside(frame.view, vec2(pixel) + frame.point);
  }
  return Chain(frame.view.position, direction, 0.0f, vec3(1.0f), 0, begin, 0.0f, 0.0f);
}

// Results of Meet.
const int kNoImage = 0;
const int kImage = 1;
const int kOnward = 2;

mat3 MatrixOf(vec4 x, vec4 y, vec4 z) {
  return transpose(mat3(x.xyz, y.xyz, z.xyz));
}

// The triangle of a hit in the frame whose vertices have these offsets. Without `before`.
ChainTriangle TriangleIn(GpuInstance instance, GpuHit hit, uint positions, uint normals) {
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec3 p0 = Vec3At(positions + 3u * corner.x);
  ChainTriangle triangle;
  triangle.edge_u = Vec3At(positions + 3u * corner.y) - p0;
  triangle.edge_v = Vec3At(positions + 3u * corner.z) - p0;
  triangle.normal_0 = Vec3At(normals + 3u * corner.x);
  triangle.normal_1 = Vec3At(normals + 3u * corner.y);
  triangle.normal_2 = Vec3At(normals + 3u * corner.z);
  triangle.world = MatrixOf(instance.world_x, instance.world_y, instance.world_z);
  return triangle;
}

// The chain vertex of a hit in the previous frame.
ChainVertex VertexAt(GpuInstance instance, GpuHit hit, ShadingPoint at, float eta) {
  ChainTriangle triangle =
      TriangleIn(instance, hit, instance.previous_positions, instance.previous_normals);
  triangle.before = MatrixOf(instance.previous_x, instance.previous_y, instance.previous_z);
  triangle.moving = Stands(instance) ? 0 : 1;
  vec3 n = at.frame.z;
  vec3 n_before =
      HasChangedShape(instance) ? PreviousNormalAt(instance, hit, n) : MovedNormal(triangle, n);
  return MakeChainVertex(triangle, PreviousPoint(instance, hit, at.position), n, n_before, eta);
}

// The chain vertex of a hit in the current frame.
ChainVertex CurrentVertex(GpuInstance instance, GpuHit hit, ShadingPoint at, float eta) {
  ChainTriangle triangle = TriangleIn(instance, hit, instance.positions, instance.normals);
  triangle.before = triangle.world;
  triangle.moving = 0;
  return MakeChainVertex(triangle, at.position, at.frame.z, at.frame.z, eta);
}

// Adds a vertex to the chain.
void Bend(GpuInstance instance, GpuHit hit, ShadingPoint at, float eta) {
  ChainVertex vertex = VertexAt(instance, hit, at, eta);
  chain_vertices[chain_count] = vertex;
  ++chain_count;
  if (frame.filters_textures != 0) {
    if (!Stands(instance)) {
      vertex = CurrentVertex(instance, hit, at, eta);
    }
    chain_beside.right = PassVertex(vertex, chain_beside.right);
    chain_beside.down = PassVertex(vertex, chain_beside.down);
  }
}

// Continues a chain from a surface; returns false if it ends there.
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
    Bend(instance, hit, at, leaving.eta);
  }
  ++chain.ray_count;
  chain.direction = direction;
  chain.origin = OriginOf(at, direction);
  return true;
}

// Stores the luminance of a light at the end of the chain.
void MeetLight(vec3 radiance, inout Chain chain) {
  chain.light = chain_count == 1 ? ChainLuminance(radiance) : 0.0f;
}

// Ends a chain that leaves the scene.
void MeetSky(inout Chain chain, inout GpuImage image, inout ChainEnd end) {
  vec3 radiance = EnvironmentRadiance(chain.direction);
  image.depth = kInfinity;
  image.normal = vec3(0.0f);
  image.albedo = chain.throughput * max(radiance, vec3(kLeastRadiance));
  image.id = 0u;
  end = ChainEnd(chain.direction, 1);
  MeetLight(radiance, chain);
}

vec3 WholeAlbedo(Bsdf bsdf, SpecularAlbedo specular) {
  return min(DiffuseAlbedo(bsdf) + SumOf(specular), vec3(1.0f));
}

// The base colour at a hit of the chain, averaged over the pixel unless the chain is kBehind.
// \param colour  base colour of the hit point
vec3 ColourOfChain(uint number, Chain chain, GpuMaterial material, GpuInstance instance, GpuHit hit,
                   vec3 colour) {
  if (!HasMeanColour(material) || chain.begin == kBehind) {
    return colour;
  }
  if (chain.ray_count == 0) {
    vec3 mean;
    return ColourOfFirst(number, mean) ? mean : colour;
  }
  vec2 point = vec2(PixelOf(number)) + frame.point;
  return MeanBaseColour(material, instance, hit, chain_beside, point, colour);
}

// Starts the chain at the visible surface.
int MeetFirst(GpuInstance instance, GpuHit hit, Surface surface, Bsdf bsdf, inout Chain chain) {
  Leaving leaving = FirstReflection(bsdf);
  if (chain.begin == kTransmitted) {
    leaving = LeavingThrough(bsdf, surface.at);
  } else if (frame.signal_count > kSurfaceSignals) {
    chain.reflectance = SolidReflectance(bsdf, surface.at);
  }
  return Continue(instance, hit, surface.at, leaving, chain) ? kOnward : kNoImage;
}

// Processes a hit of the chain; its first hit is the visible surface.
// \param forward  cosine between primary ray and view axis
int Meet(uint number, GpuHit hit, float forward, inout Chain chain, inout GpuImage image,
         inout ChainEnd end) {
  GpuInstance instance = instances[hit.instance];
  GpuMaterial material = materials[instance.material];
  vec4 colour = BaseColour(material, instance, hit);
  vec3 mean = ColourOfChain(number, chain, material, instance, hit, colour.rgb);
  Surface surface = MakeSurface(material, instance, hit, mean, chain.direction);
  chain.distance += length(surface.at.position - chain.origin);
  bool first = chain.ray_count == 0;
  bool ends = chain.begin == kBehind;
  if (!first && OpacityOf(material, colour.a) < kChainOpacity) {
    return Continue(instance, hit, surface.at, LeavingBy(kChainGoesOn), chain) ? kOnward : kNoImage;
  }
  SpecularAlbedo specular;
  Bsdf bsdf = MakeSurfaceBsdf(material, surface, 0.0f, specular);
  if (first && !ends) {
    return MeetFirst(instance, hit, surface, bsdf, chain);
  }
  Leaving leaving = LeavingOf(bsdf, surface.at, SumOf(specular));
  vec3 throughput = chain.throughput;
  chain.throughput *= leaving.way == kChainReflects ? SumOf(specular) : bsdf.tint;
  if (!ends && Continue(instance, hit, surface.at, leaving, chain)) {
    return kOnward;
  }
  // The emission of surfaces along the primary ray is not part of the signals.
  bool emits = Emits(material) && !ends;
  vec3 emission = emits ? EmissionOf(material, instance, hit) : vec3(0.0f);
  image.depth = chain.distance * forward;
  image.normal = surface.at.frame.z;
  vec3 own = emits ? max(emission, vec3(kLeastRadiance)) : WholeAlbedo(bsdf, specular);
  image.albedo = own * throughput;
  image.id = hit.instance + 1u;
  image.base_colour = mean;
  image.primitive = ends ? kNoPrimitive : hit.primitive;
  image.u = hit.u;
  image.v = hit.v;
  end = ChainEnd(PreviousPoint(instance, hit, surface.at.position), 0);
  MeetLight(emission, chain);
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

const GpuImage kNothing =
    GpuImage(vec3(0.0f), 0.0f, vec3(0.0f), 0.0f, vec3(0.0f), kNoPrimitive, 0.0f, 0.0f, 0u, 0.0f);

// Follows a chain from its start.
// \param hit     hit of the pixel's only layer
// \param traced  [in,out] number of traced rays
GpuImage FollowChain(uint number, GpuHit hit, inout Chain chain, inout uint traced) {
  GpuImage image = kNothing;
  vec3 direction = chain.direction;
  float forward = dot(direction, frame.view.forward);
  ChainEnd end = ChainEnd(vec3(0.0f), 0);
  int met = kOnward;
  while (met == kOnward) {
    if (hit.instance == kNoInstance) {
      MeetSky(chain, image, end);
      met = kImage;
    } else {
      met = Meet(number, hit, forward, chain, image, end);
    }
    if (met == kOnward) {
      hit = FindFirstHit(GpuRay(chain.origin, kInfinity, chain.direction, 0u));
      ++traced;
    }
  }
  if (met == kImage) {
    SetMotion(end, direction, image);
  }
  return image;
}

// The layer of the largest weight behind the first one. It retraces the primary ray, without
// counting these rays again.
GpuHit HitBehind(uvec2 pixel, vec3 direction) {
  CameraWalk walk = StartPixel(pixel, frame.view.position, direction);
  CameraLayer layer;
  GpuHit hit = GpuHit(kInfinity, 0.0f, 0.0f, kNoInstance, 0u);
  float heaviest = 0.0f;
  while (NextLayer(walk, layer)) {
    if (walk.layers > 1 && layer.weight > heaviest) {
      heaviest = layer.weight;
      hit = layer.hit;
    }
  }
  return hit;
}

// Returns the number of traced rays.
uint FindImages(uint number, uvec2 pixel) {
  vec3 direction = DirectionOf(frame.view, vec2(pixel) + frame.point);
  GpuHit first = first_hits[number];
  bool layered = first.instance == kSeveralLayers;
  if (first.instance == kLayerBeforeSky) {
    first.instance = guides[number].id - 1u;
  }
  bool single = !layered && first.instance != kNoInstance;
  bool separates = SeparatesTransmission(guides[number]);
  uint traced = 0u;
  GpuImage reflection = kNothing;
  bool reflects_light = false;
  int kinds = frame.signal_count > kSurfaceSignals ? 2 : 1;
  for (int kind = 0; kind < kinds; ++kind) {
    bool mirrored = kind == 0;
    GpuImage image = !mirrored && reflects_light ? reflection : kNothing;
    bool follows = mirrored ? single && frame.shows_reflection != 0
                            : layered || (single && separates && !reflects_light);
    if (follows) {
      Chain chain =
          StartChain(pixel, direction, mirrored ? kReflected : (layered ? kBehind : kTransmitted));
      GpuHit hit = first;
      if (!mirrored && layered) {
        hit = HitBehind(pixel, direction);
      }
      image = FollowChain(number, hit, chain, traced);
      reflects_light = separates && single &&
                       ReflectsVisibly(chain.reflectance, chain.light, environment.mean_luminance);
    }
    images[mirrored ? number : FirstRefraction() + number] = image;
    reflection = image;
  }
  return traced;
}

void main() {
  uint number = ThreadNumber();
  uint traced = 0u;
  if (number < batch.count && !IsStopped()) {
    uvec2 pixel = PixelOf(number);
    if (IsInPicture(pixel)) {
      traced = FindImages(number, pixel);
    }
  }
  CountImageRays(traced);
}
