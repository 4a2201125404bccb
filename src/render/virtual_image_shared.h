// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Specular chains, at whose end lie the virtual images of mirrors and glass: the continuation of a
// chain at a surface, and ray tracing along a chain whose surfaces are approximated around one
// point each, which yields the previous-frame position of a virtual image. The approximation is a
// quadric: the plane of the triangle, linearly varying normals, and the height that integrates
// them.
#ifndef STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H
#define STILLRAY_RENDER_VIRTUAL_IMAGE_SHARED_H

#ifdef __cplusplus
#include <glm/matrix.hpp>

#include "core/colour.h"
#include "render/footprint_shared.h"
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
// Perceptual roughness up to which visible surfaces have a reflected virtual image: although
// blurred, its position determines the motion of the reflection.
const float kMostReflectingRoughness = 0.5f;
// Maximum number of vertices of a chain: two faces of three glass bodies, and two mirrors.
const int kMostVertices = 8;
// Maximum number of rays of a chain, including rays through thin sheets and cut-outs.
const int kMostChainRays = 16;
// Emitters and sky are demodulated by their own radiance, which hides them from the filter; this is
// the minimum of the divisor.
const float kLeastRadiance = 0.01f;
// Minimum cosine between the normals of clear coat and surface for chains to be reflected by the
// coat: they are reflected about the surface normal.
const float kSameNormal = 0.9999f;
// Minimum luminance of a light's reflection in glass, relative to the mean luminance of the sky,
// for the glass to have its virtual image.
const float kVisibleLight = 0.5f;
// Chains ignore surfaces with an opacity below this value.
const float kChainOpacity = 0.5f;

// Sum of the differences in barycentric coordinates up to which a path meets a virtual image at the
// end of its chain: both reach it by the same surfaces, but with different rounding.
const float kSameBarycentrics = 1e-3f;

// Continuation of a chain at a surface.
const int kChainEnds = 0;
const int kChainReflects = 1;
const int kChainRefracts = 2;
const int kChainGoesOn = 3;  // undeflected

struct Leaving {
  int way;    // kChain...
  float eta;  // relative refractive index of kChainRefracts
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

// Largest alpha of the specular lobe.
SHARED_FN float WidestAlpha(SHARED_IN(Bsdf) bsdf) {
  return IsAnisotropic(bsdf) ? bsdf.tangent_alpha : bsdf.specular_alpha;
}

// Transmission by smooth glass. Chains end at solids with a scattering medium.
SHARED_FN Leaving LeavingThrough(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  Leaving leaving = LeavingBy(bsdf.thin != 0 ? kChainGoesOn : kChainRefracts);
  leaving.eta = bsdf.eta;
  leaving.way = Scatters(at) ? kChainEnds : leaving.way;
  return leaving;
}

// Whether the transmission of the visible surface has a separate virtual image and a separate path.
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

// Continuation of the reflection chain at the visible surface, which may also have a diffuse lobe:
// the virtual guides apply only to specular light.
SHARED_FN Leaving FirstReflection(SHARED_IN(Bsdf) bsdf) {
  bool reflects = IsSmoothGlass(bsdf) || ReflectsWithin(bsdf, kMostReflectingRoughness);
  return LeavingBy(reflects ? kChainReflects : kChainEnds);
}

SHARED_FN float ReflectanceOf(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  return bsdf.thin != 0 ? bsdf.sheet_reflectance
                        : FresnelOfGlass(bsdf, min(at.local_wo.z, 1.0f)).share;
}

// Reflectance of the visible face of solid glass; 0 for sheets.
SHARED_FN float SolidReflectance(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at) {
  return bsdf.thin == 0 ? ReflectanceOf(bsdf, at) : 0.0f;
}

// Whether solid glass reflects a light of this luminance so brightly that the reflected light also
// serves as the virtual image of transmission: the back faces, whose reflections belong to the
// transmitted light, reflect it at nearly the same position.
// \param reflectance  SolidReflectance
SHARED_FN bool ReflectsVisibly(float reflectance, float light, float mean_sky) {
  return reflectance * light > kVisibleLight * mean_sky && reflectance * light > 0.0f;
}

// Continuation of a chain at a later surface; glass follows the stronger of reflection and
// refraction.
SHARED_FN Leaving LeavingOf(SHARED_IN(Bsdf) bsdf, SHARED_IN(ShadingPoint) at,
                            vec3 specular_albedo) {
  if (bsdf.glass_weight > 0.5f && IsSmooth(bsdf.glass_alpha)) {
    return ReflectanceOf(bsdf, at) > 0.5f ? LeavingBy(kChainReflects) : LeavingThrough(bsdf, at);
  }
  bool mostly = ChainLuminance(specular_albedo) > ChainLuminance(DiffuseAlbedo(bsdf));
  return LeavingBy(mostly && ReflectsSmoothly(bsdf) ? kChainReflects : kChainEnds);
}

// Updates the direction of a chain at a surface. Returns false if the new direction is on the wrong
// side of the geometric normal, which shading normals may cause.
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

// A vertex of a specular chain: local approximation of the smooth surface.
struct ChainVertex {
  vec3 position;
  vec3 edge_u;  // edges of the triangle
  vec3 edge_v;
  vec3 normal;    // shading normal, on the side of the arriving ray
  vec3 normal_u;  // change of the normal along each edge
  vec3 normal_v;
  float eta;  // relative refractive index, transmitted over incident side; 0: reflection
};

// Reflects or refracts a ray at a vertex.
SHARED_FN ChainRay PassVertex(SHARED_IN(ChainVertex) vertex, ChainRay ray) {
  vec3 plane = normalize(cross(vertex.edge_u, vertex.edge_v));
  float slope = dot(ray.direction, plane);
  float along = abs(slope) > 1e-12f ? 1.0f / slope : 0.0f;
  vec3 point = ray.origin;
  vec3 change = vec3(0.0f);
  float height = 0.0f;
  // Fixed-point iteration: each round uses the surface height at the point of the previous round.
  for (int i = 0; i < 3; ++i) {
    vec3 to_plane = vertex.position + plane * height - ray.origin;
    point = ray.origin + ray.direction * (dot(to_plane, plane) * along);
    vec3 offset = point - vertex.position;
    vec2 at = AlongEdges(vertex.edge_u, vertex.edge_v, offset);
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

// A previous-frame triangle of a mesh in object space, and the object-to-world matrices of its
// instance.
struct ChainTriangle {
  vec3 edge_u;
  vec3 edge_v;
  vec3 normal_0;  // vertex normals
  vec3 normal_1;
  vec3 normal_2;
  mat3 world;   // matrix of the current frame
  mat3 before;  // matrix of the previous frame
  int moving;   // 1: they differ
};

// The previous-frame shading normal of a mesh that has not deformed.
SHARED_FN vec3 MovedNormal(SHARED_IN(ChainTriangle) triangle, vec3 normal) {
  mat3 to_normal = transpose(inverse(triangle.before));
  mat3 from_normal = transpose(triangle.world);
  return triangle.moving != 0 ? SafeNormalize(to_normal * (from_normal * normal), normal) : normal;
}

// The previous-frame approximation of the surface around a point.
// \param position         position of the point in the previous frame
// \param normal           current shading normal, on the side of the incident ray
// \param previous_normal  shading normal in the previous frame
// \param eta              see ChainVertex::eta
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
