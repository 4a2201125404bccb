// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Chains of smooth surfaces, whose images mirrors and glass show: how a chain leaves a surface, and
// how a ray passes surfaces that are known around one point each, for the place of an image in the
// previous frame. Around its point a surface is its triangle's plane, with normals that change
// linearly, and the height that belongs to them: a quadric, as the vertices approximate it.
#ifndef STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H
#define STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H

#ifdef __cplusplus
#include <glm/matrix.hpp>

#include "core/colour.h"
#include "render/make_bsdf_shared.h"
#include "render/shading_point_shared.h"
#endif

STILLRAY_RENDER_BEGIN

#ifdef __cplusplus
using glm::inverse;
using glm::transpose;
#endif

// Perceptual roughness up to which a surface counts as smooth.
const float kSmoothRoughness = 0.1f;
// The same of visible surfaces that reflect an image. It is blurred, but its position determines
// how the reflected light moves.
const float kMostReflectingRoughness = 0.5f;
// Longer chains show no image: two faces of three glass bodies, and two mirrors.
const int kMostVertices = 8;
// Rays of a chain, those that pass thin sheets and cut-outs too.
const int kMostChainRays = 16;
// Light of an emitter or the sky is divided by itself, so that the filter does not see it: smaller
// values are.
const float kLeastRadiance = 0.01f;
// Least cosine of a clear coat's normal with the surface's, about which chains are reflected.
const float kSameNormal = 0.9999f;
// Glass shows the image of a light that it reflects if that is brighter than this part of the mean
// sky.
const float kVisibleLight = 0.5f;
// Chains pass surfaces of less opacity.
const float kChainOpacity = 0.5f;

// How a chain leaves a surface.
const int kChainEnds = 0;
const int kChainReflects = 1;
const int kChainRefracts = 2;
const int kChainGoesOn = 3;  // undeflected

struct Leaving {
  int way;    // kChain...
  float eta;  // of kChainRefracts
};

SHARED_FN Leaving LeavingBy(int way) {
  Leaving leaving;
  leaving.way = way;
  leaving.eta = 0.0f;
  return leaving;
}

SHARED_FN float ChainLuminance(vec3 c) {
  return Luminance709(c.x, c.y, c.z);
}

SHARED_FN bool IsSmooth(float alpha) {
  return alpha <= AlphaOfRoughness(kSmoothRoughness);
}

// Of the specular lobe.
SHARED_FN float WidestAlpha(SHARED_IN(Bsdf) bsdf) {
  return IsAnisotropic(bsdf) ? bsdf.tangent_alpha : bsdf.specular_alpha;
}

// Transmission by smooth glass. Solids that scatter inside do not show what is behind them.
SHARED_FN Leaving LeavingThrough(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  Leaving leaving = LeavingBy(bsdf.thin != 0 ? kChainGoesOn : kChainRefracts);
  leaving.eta = bsdf.eta;
  leaving.way = Scatters(at) ? kChainEnds : leaving.way;
  return leaving;
}

// Whether the transmission of the visible surface has an image of its own, and is traced by a path
// of its own.
SHARED_FN bool IsSmoothGlass(SHARED_IN(Bsdf) bsdf) {
  return bsdf.pick_glass > 0.0f && IsSmooth(bsdf.glass_alpha);
}

// Whether the reflecting lobes other than glass have at most this perceptual roughness.
SHARED_FN bool ReflectsWithin(SHARED_IN(Bsdf) bsdf, float roughness) {
  float most = AlphaOfRoughness(roughness);
  return IsMainlyCoat(bsdf) ? bsdf.coat_alpha <= most && bsdf.coat_normal.z > kSameNormal
                            : bsdf.pick_specular > 0.0f && WidestAlpha(bsdf) <= most;
}

SHARED_FN bool ReflectsSmoothly(SHARED_IN(Bsdf) bsdf) {
  return ReflectsWithin(bsdf, kSmoothRoughness);
}

// How the chain of reflected light leaves the visible surface, which may be diffuse too: its
// specular light alone is guided.
SHARED_FN Leaving FirstReflection(SHARED_IN(Bsdf) bsdf) {
  bool reflects = IsSmoothGlass(bsdf) || ReflectsWithin(bsdf, kMostReflectingRoughness);
  return LeavingBy(reflects ? kChainReflects : kChainEnds);
}

SHARED_FN float ReflectanceOf(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  return bsdf.thin != 0 ? bsdf.sheet_reflectance
                        : FresnelOfGlass(bsdf, min(at.local_wo.z, 1.0f)).share;
}

// Of the visible face of solid glass; 0 for sheets.
SHARED_FN float SolidReflectance(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  return bsdf.thin == 0 ? ReflectanceOf(bsdf, at) : 0.0f;
}

// Whether solid glass reflects a light of this luminance so brightly that the image of transmitted
// light is that of the light too: other faces of the glass, whose light is part of what is
// transmitted, reflect it at about the same place.
// \param reflectance  SolidReflectance
SHARED_FN bool ReflectsVisibly(float reflectance, float light, float mean_sky) {
  return reflectance * light > kVisibleLight * mean_sky && reflectance * light > 0.0f;
}

// How a chain leaves a later surface: glass along the part with more light.
SHARED_FN Leaving LeavingOf(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at,
                            vec3 specular_albedo) {
  if (bsdf.glass_weight > 0.5f && IsSmooth(bsdf.glass_alpha)) {
    return ReflectanceOf(bsdf, at) > 0.5f ? LeavingBy(kChainReflects) : LeavingThrough(bsdf, at);
  }
  bool mostly = ChainLuminance(specular_albedo) > ChainLuminance(DiffuseAlbedo(bsdf));
  return LeavingBy(mostly && ReflectsSmoothly(bsdf) ? kChainReflects : kChainEnds);
}

// Turns the direction of a chain at a surface. Returns whether it may leave: a shading normal may
// lead it through the surface.
SHARED_FN bool TurnChain(SHARED_IN(Leaving) leaving, SHARED_IN(ShadingPoint) at,
                         SHARED_INOUT(vec3) direction) {
  if (leaving.way == kChainReflects) {
    direction -= 2.0f * dot(direction, at.frame.z) * at.frame.z;
  } else if (leaving.way == kChainRefracts) {
    direction = RefractAbout(at.wo, at.frame.z, leaving.eta);
  }
  bool above = dot(direction, at.geometric) > 0.0f;
  return above == (leaving.way == kChainReflects);
}

// A smooth surface around the point at which a chain of reflections and refractions meets it.
struct ChainVertex {
  vec3 position;
  vec3 edge_u;  // of the triangle
  vec3 edge_v;
  vec3 normal;    // shading normal, on the side of the arriving ray
  vec3 normal_u;  // its change along each edge
  vec3 normal_v;
  float eta;  // refractive index beyond over that before the surface; 0: the ray is reflected
};

struct ChainRay {
  vec3 origin;
  vec3 direction;  // unit length
};

// Coordinates of a vector in the triangle's plane along its edges; least squares.
SHARED_FN vec2 AlongEdges(SHARED_IN(ChainVertex) vertex, vec3 offset) {
  float uu = dot(vertex.edge_u, vertex.edge_u);
  float uv = dot(vertex.edge_u, vertex.edge_v);
  float vv = dot(vertex.edge_v, vertex.edge_v);
  float u = dot(vertex.edge_u, offset);
  float v = dot(vertex.edge_v, offset);
  float scale = 1.0f / max(uu * vv - uv * uv, 1e-30f);
  return vec2(u * vv - v * uv, v * uu - u * uv) * scale;
}

// The ray behind a vertex that the ray passes.
SHARED_FN ChainRay PassVertex(SHARED_IN(ChainVertex) vertex, ChainRay ray) {
  vec3 plane = normalize(cross(vertex.edge_u, vertex.edge_v));
  float slope = dot(ray.direction, plane);
  float along = abs(slope) > 1e-12f ? 1.0f / slope : 0.0f;
  vec3 point = ray.origin;
  vec3 change = vec3(0.0f);
  float height = 0.0f;
  // Each round inserts the height that belongs to the normals at the point of the last one.
  for (int i = 0; i < 3; ++i) {
    vec3 to_plane = vertex.position + plane * height - ray.origin;
    point = ray.origin + ray.direction * (dot(to_plane, plane) * along);
    vec3 offset = point - vertex.position;
    vec2 at = AlongEdges(vertex, offset);
    change = vertex.normal_u * at.x + vertex.normal_v * at.y;
    height = -0.5f * dot(change, offset) * (dot(vertex.normal, plane) < 0.0f ? -1.0f : 1.0f);
  }
  vec3 normal = normalize(vertex.normal + change);
  ChainRay next;
  next.origin = point;
  next.direction = vertex.eta > 0.0f ? RefractAbout(-ray.direction, normal, vertex.eta)
                                     : ray.direction - 2.0f * dot(ray.direction, normal) * normal;
  return next;
}

// A triangle of a mesh in the previous frame, in the mesh's space, and its instance's matrices to
// the world.
struct ChainTriangle {
  vec3 edge_u;
  vec3 edge_v;
  vec3 normal_0;  // of its corners
  vec3 normal_1;
  vec3 normal_2;
  mat3 world;   // of now
  mat3 before;  // of the previous frame
  int moving;   // 1: they differ
};

// The shading normal in the previous frame, if the mesh has kept its shape.
SHARED_FN vec3 MovedNormal(SHARED_IN(ChainTriangle) triangle, vec3 normal) {
  mat3 to_normal = transpose(inverse(triangle.before));
  mat3 from_normal = transpose(triangle.world);
  return triangle.moving != 0 ? SafeNormalize(to_normal * (from_normal * normal), normal) : normal;
}

// The surface around a point in the previous frame.
// \param position         of the point in the previous frame
// \param normal           its shading normal now, on the side of the arriving ray
// \param previous_normal  the same in the previous frame
// \param eta              as in ChainVertex
SHARED_FN ChainVertex MakeChainVertex(SHARED_IN(ChainTriangle) triangle, vec3 position, vec3 normal,
                                      vec3 previous_normal, float eta) {
  mat3 to_normal = transpose(inverse(triangle.before));
  ChainVertex vertex;
  vertex.position = position;
  vertex.edge_u = triangle.before * triangle.edge_u;
  vertex.edge_v = triangle.before * triangle.edge_v;
  vertex.normal = previous_normal;
  vec3 n0 = SafeNormalize(to_normal * triangle.normal_0, normal);
  float side = dot(n0, vertex.normal) < 0.0f ? -1.0f : 1.0f;
  vertex.normal_u = (SafeNormalize(to_normal * triangle.normal_1, normal) - n0) * side;
  vertex.normal_v = (SafeNormalize(to_normal * triangle.normal_2, normal) - n0) * side;
  vertex.eta = eta;
  return vertex;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H
