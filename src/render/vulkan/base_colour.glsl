// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Base colours averaged over the pixel, with the steps of the CPU version (base_colour.h,
// MeanBaseColour, BaseColourOfVertex). Guides and virtual images store them for the paths of their
// pixels. Needs tracer.glsl.
#include "render/virtual_image_shared.h"

bool HasMeanColour(GpuMaterial material) {
  return frame.filters_textures != 0 && material.base_colour_texture.texture >= 0;
}

// Texture samples of MeanBaseColour along both axes of the pixel.
ivec2 TapCounts(GpuTextureRef ref, GpuInstance instance, GpuHit hit, Footprint footprint) {
  uint array = ref.uv_set == 0 ? instance.uv_0 : instance.uv_1;
  if (array == kNoArray) {
    return ivec2(1);
  }
  uvec3 corner = CornersOf(instance, hit.primitive);
  vec2 first = Vec2At(array + 2u * corner.x);
  vec2 edge_u = Vec2At(array + 2u * corner.y) - first;
  vec2 edge_v = Vec2At(array + 2u * corner.z) - first;
  vec2 right = edge_u * footprint.right.x + edge_v * footprint.right.y;
  vec2 down = edge_u * footprint.down.x + edge_v * footprint.down.y;
  GpuTexture source = textures[ref.texture];
  vec2 size = vec2(float(source.width), float(source.height));
  return ivec2(TapsAlong(vec2(dot(ref.u_row.xy, right), dot(ref.v_row.xy, right)) * size),
               TapsAlong(vec2(dot(ref.u_row.xy, down), dot(ref.v_row.xy, down)) * size));
}

// Base colour whose texture is averaged over the pixel's part of the triangle. Only where
// HasMeanColour.
// \param point   image position of the pixel's ray
// \param colour  base colour of the hit point
vec3 MeanBaseColour(GpuMaterial material, GpuInstance instance, GpuHit hit, PixelRays rays,
                    vec2 point, vec3 colour) {
  WorldTriangle t = TriangleOf(instance, hit.primitive);
  vec3 weights = Weights(hit);
  vec3 place = t.p0 * weights.x + t.p1 * weights.y + t.p2 * weights.z;
  Footprint footprint = MakeFootprint(t.p1 - t.p0, t.p2 - t.p0, place, rays.right, rays.down);
  ivec2 counts = TapCounts(material.base_colour_texture, instance, hit, footprint);
  vec2 within = fract(point);
  vec3 sum = vec3(0.0f);
  float weight = 0.0f;
  int count = counts == ivec2(1) ? 0 : counts.x * counts.y;
  for (int i = 0; i < count; ++i) {
    vec2 at = TapOf(footprint, vec2(hit.u, hit.v), within, i % counts.x, i / counts.x, counts);
    if (IsInTriangle(at)) {
      GpuHit tap = GpuHit(hit.t, at.x, at.y, hit.instance, hit.primitive);
      vec4 value = BaseColour(material, instance, tap);
      float opacity = OpacityOf(material, value.a);
      sum += value.rgb * opacity;
      weight += opacity;
    }
  }
  return weight > 0.0f ? sum / weight : colour;
}

// The mean base colour of the pixel's only layer, if it is opaque and textured. Returns false
// otherwise.
bool ColourOfFirst(uint number, out vec3 colour) {
  uint high = guides[number].colour_high;
  colour = UnpackColour(guides[number].colour_low, high);
  return high != 0u;
}

// The mean base colour of the pixel's virtual image at this hit, if there is one. Returns false
// otherwise.
bool ColourOfImage(uint number, GpuHit hit, out vec3 colour) {
  colour = vec3(0.0f);
  for (uint kind = 0u; kind < frame.filtered_images; ++kind) {
    uint i = kind == 0u ? number : FirstRefraction() + number;
    if (images[i].id == hit.instance + 1u && images[i].primitive == hit.primitive &&
        abs(images[i].u - hit.u) + abs(images[i].v - hit.v) < kSameBarycentrics) {
      colour = images[i].base_colour;
      return true;
    }
  }
  return false;
}

// Base colour and alpha at a vertex of a path. Alpha may be 1 at the first surface, where it is not
// used.
vec4 BaseColourOfVertex(uint number, bool first, GpuMaterial material, GpuInstance instance,
                        GpuHit hit) {
  vec3 mean = vec3(0.0f);
  bool has_mean = HasMeanColour(material) &&
                  (first ? ColourOfFirst(number, mean) : ColourOfImage(number, hit, mean));
  if (has_mean && (first || material.alpha_mode == kAlphaOpaque)) {
    return vec4(mean, 1.0f);
  }
  vec4 colour = BaseColour(material, instance, hit);
  return has_mean ? vec4(mean, colour.a) : colour;
}
