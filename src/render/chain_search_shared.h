// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Previous-frame pixel of the virtual image at the end of a specular chain: Newton's method finds
// the pixel whose ray, specularly reflected and refracted by the chain's surfaces at their previous
// positions, reaches the chain's end.
//
// In C++ the chain is an argument, CHAIN_IN. In GLSL, which copies array arguments, the including
// shader first declares
//   struct GpuView                       with vec3 DirectionOf(GpuView, vec2)
//                                        and vec2 Project(GpuView, vec3)
//   int ChainCount()                     the number of vertices
//   ChainVertex ChainVertexAt(int i)     the i-th vertex in the previous frame
#ifndef STILLRAY_RENDER_CHAIN_SEARCH_SHARED_H
#define STILLRAY_RENDER_CHAIN_SEARCH_SHARED_H

#ifdef __cplusplus
#include "render/camera.h"
#include "render/virtual_image_shared.h"
#endif

STILLRAY_RENDER_BEGIN

#ifdef __cplusplus
struct ChainArrays {
  const ChainVertex* vertices = nullptr;
  int count = 0;
};
inline int ChainCount(const ChainArrays& chain) {
  return chain.count;
}
inline const ChainVertex& ChainVertexAt(const ChainArrays& chain, int i) {
  return chain.vertices[i];
}
inline vec3 DirectionOf(const CameraView& view, vec2 pixel) {
  return view.Direction(pixel);
}
inline vec2 Project(const CameraView& view, vec3 offset) {
  return view.Project(offset);
}
#define CHAIN_IN const ChainArrays &chain,
#define CHAIN chain,
#define CHAIN_ALONE chain
#define CHAIN_VIEW CameraView
#else
#define CHAIN_IN
#define CHAIN
#define CHAIN_ALONE
#define CHAIN_VIEW GpuView
#endif

// The end of a chain in the previous frame: a point, or a direction if the chain leaves the scene.
struct ChainEnd {
  vec3 point;  // or direction
  int is_sky;
};

// The primary ray of a pixel, traced along the chain to behind its last vertex.
SHARED_FN ChainRay ShootAlongChain(CHAIN_IN SHARED_IN(CHAIN_VIEW) view, vec2 pixel) {
  ChainRay ray;
  ray.origin = view.position;
  ray.direction = DirectionOf(view, pixel);
  for (int i = 0; i < ChainCount(CHAIN_ALONE); ++i) {
    ray = PassVertex(ChainVertexAt(CHAIN i), ray);
  }
  return ray;
}

// Offset of the chain's end from the ray, in the plane of two axes.
SHARED_FN vec2 MissOfRay(SHARED_IN(ChainRay) ray, SHARED_IN(ChainEnd) end,
                         SHARED_IN(LocalFrame) axes) {
  vec3 wanted = end.is_sky != 0 ? end.point : end.point - ray.origin;
  vec3 miss = wanted - ray.direction * dot(wanted, ray.direction);
  return vec2(dot(miss, axes.x), dot(miss, axes.y));
}

// Derivative of the offset (MissOfRay) with respect to the pixel.
struct MissSlope {
  vec2 by_x;
  vec2 by_y;
};

// Newton step: the root of the linearised offset.
SHARED_FN vec2 StepOfMiss(SHARED_IN(MissSlope) slope, vec2 miss) {
  float determinant = slope.by_x.x * slope.by_y.y - slope.by_x.y * slope.by_y.x;
  return vec2(slope.by_y.x * miss.y - slope.by_y.y * miss.x,
              slope.by_x.y * miss.x - slope.by_x.x * miss.y) /
         determinant;
}

// Exact for planar mirrors. Returns whether the iteration converged.
// \param view   camera of the previous frame
// \param place  [out] the pixel position
SHARED_FN bool FindPreviousPlace(CHAIN_IN SHARED_IN(CHAIN_VIEW) view, SHARED_IN(ChainEnd) end,
                                 SHARED_INOUT(vec2) place) {
  const int kIterations = 10;
  const float kConverged = 0.002f;  // pixels
  const float kAccepted = 0.1f;
  const float kSlow = 0.25f;   // steps that shrink less need a new derivative
  const float kOffset = 0.5f;  // finite difference in pixels
  int count = ChainCount(CHAIN_ALONE);
  vec3 first = end.is_sky != 0 ? end.point : end.point - view.position;
  if (count > 0) {
    first = ChainVertexAt(CHAIN 0).position - view.position;
  }
  if (dot(first, view.forward) <= 0.0f) {
    return false;
  }
  place = Project(view, first);
  LocalFrame axes = MakeLocalFrame(view.forward);
  vec2 miss = vec2(0.0f);
  MissSlope slope;
  slope.by_x = slope.by_y = vec2(0.0f);
  float change = count > 0 ? kInfinity : 0.0f;
  int shots = 3;  // rays per iteration: the pixel and its two finite differences
  for (int i = 0; i < kIterations && change > kConverged; ++i) {
    for (int k = 0; k < shots; ++k) {
      vec2 beside = vec2(k == 1 ? kOffset : 0.0f, k == 2 ? kOffset : 0.0f);
      ChainRay ray = ShootAlongChain(CHAIN view, place + beside);
      if (i == 0 && k == 0) {
        axes = MakeLocalFrame(ray.direction);
      }
      vec2 missed = MissOfRay(ray, end, axes);
      miss = k == 0 ? missed : miss;
      slope.by_x = k == 1 ? (missed - miss) / kOffset : slope.by_x;
      slope.by_y = k == 2 ? (missed - miss) / kOffset : slope.by_y;
    }
    vec2 next = StepOfMiss(slope, miss);
    float before = change;
    change = length(next);
    if (!(change < view.width + view.height)) {
      return false;
    }
    place += next;
    shots = change > kSlow * before ? 3 : 1;
  }
  return change <= kAccepted;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_CHAIN_SEARCH_SHARED_H
