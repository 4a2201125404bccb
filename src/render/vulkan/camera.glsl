// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The camera, and the layers along primary rays, as on the CPU (CameraView, FindPrimarySurfaces).
// Needs trace.glsl, material_lookup.glsl and traversal.glsl.
#include "render/primary_shared.h"

float LensSum(int i) {
  return uintBitsToFloat(words[frame.lens_mask + uint(i)]);
}
#define lens frame.lens_shape
#include "render/lens_shared.h"
#undef lens

// The pinhole camera at a point of the lens.
GpuView Through(GpuView view, vec2 point) {
  vec2 offset = point * view.lens_radius;
  view.position += view.right * offset.x + view.up * offset.y;
  view.shift = offset * view.inverse_focus;
  return view;
}

// The point of the lens for the current sample of the pixel.
vec2 LensPointOf(uint seed) {
  return frame.view.lens_radius > 0.0f ? LensPoint(NumbersOf(seed, kLensDimensions).xy)
                                       : vec2(0.0f);
}

vec3 DirectionOf(GpuView view, vec2 pixel) {
  float x = (2.0f * pixel.x / view.width - 1.0f) * view.half_width - view.shift.x;
  float y = (1.0f - 2.0f * pixel.y / view.height) * view.half_height - view.shift.y;
  return normalize(view.forward + view.right * x + view.up * y);
}

// Projects the point at `offset` from the camera's position to pixel coordinates.
vec2 Project(GpuView view, vec3 offset) {
  float depth = dot(offset, view.forward);
  float safe = max(abs(depth), 1e-20f) * (depth < 0.0f ? -1.0f : 1.0f);
  float x = dot(offset, view.right) / (safe * view.half_width) + view.shift.x / view.half_width;
  float y = dot(offset, view.up) / (safe * view.half_height) + view.shift.y / view.half_height;
  return vec2((x + 1.0f) * 0.5f * view.width, (1.0f - y) * 0.5f * view.height);
}

// \param point  image position of the pixel's ray
PixelRays RaysBeside(GpuView view, vec2 point) {
  return PixelRays(ChainRay(view.position, DirectionOf(view, point + vec2(kFootprintStep, 0.0f))),
                   ChainRay(view.position, DirectionOf(view, point + vec2(0.0f, kFootprintStep))));
}

// The offset origin of a ray that continues behind the surface.
vec3 OriginBehind(GpuInstance instance, GpuHit hit, vec3 direction) {
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  vec3 weight = Weights(hit);
  vec3 point = t.p0 * weight.x + t.p1 * weight.y + t.p2 * weight.z;
  return OriginBehindTriangle(t.p0, t.p1, t.p2, point, direction);
}

// The rasterised triangle of the pixel, as the hit of its primary ray; false if the ray misses the
// triangle by rounding and must be traced.
bool RasterisedHit(uvec2 pixel, vec3 direction, out GpuHit hit) {
  uvec2 seen = visible[pixel.y * frame.width + pixel.x];
  hit = GpuHit(kInfinity, 0.0f, 0.0f, seen.x, seen.y);
  if (seen.x == kNoInstance) {
    hit.primitive = 0u;
    return true;
  }
  WorldTriangle t = TriangleOf(instances[seen.x], seen.y);
  vec3 tuv;
  bool met =
      MeetTriangle(MakeWalk(frame.view.position, direction), t.p0, t.p1, t.p2, kInfinity, tuv);
  hit.t = tuv.x;
  hit.u = tuv.y;
  hit.v = tuv.z;
  return met;
}

// A primary ray through alpha-blended and transparent layers.
struct CameraWalk {
  GpuHit first;  // first hit, if known
  bool first_known;
  vec3 origin;
  vec3 direction;
  float background;  // the remaining weight
  int layers;
  int passes;
  bool done;
};

CameraWalk StartWalk(vec3 origin, vec3 direction) {
  GpuHit none = GpuHit(kInfinity, 0.0f, 0.0f, kNoInstance, 0u);
  return CameraWalk(none, false, origin, direction, 1.0f, 0, 0, false);
}

// The primary ray of a pixel through GpuFrame::point.
CameraWalk StartPixel(uvec2 pixel, vec3 origin, vec3 direction) {
  CameraWalk walk = StartWalk(origin, direction);
  if (frame.rasterised != 0) {
    walk.first_known = RasterisedHit(pixel, direction, walk.first);
  }
  return walk;
}

// A layer of a pixel.
struct CameraLayer {
  GpuHit hit;
  vec3 base_colour;
  float weight;  // coverage as a fraction of the pixel
};

// Finds the next layer that contributes to the pixel; false if there is none.
bool NextLayer(inout CameraWalk walk, out CameraLayer layer) {
  while (!walk.done && walk.passes < kMaxPasses) {
    ++walk.passes;
    if (walk.first_known) {
      layer.hit = walk.first;
      walk.first_known = false;
    } else {
      layer.hit = FindFirstHit(GpuRay(walk.origin, kInfinity, walk.direction, 0u));
    }
    if (layer.hit.instance == kNoInstance) {
      break;
    }
    GpuInstance instance = instances[layer.hit.instance];
    GpuMaterial material = materials[instance.material];
    vec4 colour = BaseColour(material, instance, layer.hit);
    float opacity = OpacityOf(material, colour.a);
    walk.origin = OriginBehind(instance, layer.hit, walk.direction);
    if (opacity > 0.0f) {
      bool last = opacity >= 1.0f || walk.layers == kMaxLayers - 1;
      layer.base_colour = colour.rgb;
      layer.weight = last ? walk.background : walk.background * opacity;
      walk.background = last ? 0.0f : walk.background - layer.weight;
      ++walk.layers;
      walk.done = last;
      return true;
    }
  }
  walk.done = true;
  return false;
}
