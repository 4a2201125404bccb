// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The lights of a scene at one moment, in the form used by lights_shared.h and
// environment_shared.h.
#ifndef STILLRAY_RENDER_LIGHT_SHAPES_SHARED_H
#define STILLRAY_RENDER_LIGHT_SHAPES_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct EnvironmentShape {
  vec3 radiance;  // constant radiance, or factor of the map
  float mean_luminance;
  int width;  // width of the map in texels; 0: no map
  int height;
  uint unused_0, unused_1;
};

const int kMaxClusters = 16;
// Choices are the clusters, then all directional lights, then the environment.
const int kMaxLightChoices = kMaxClusters + 2;

// An emissive triangle.
struct AreaLight {
  vec3 p0;
  float area;
  vec3 edge1;
  float choice;  // selection probability within its cluster
  vec3 edge2;
  uint cluster;
  vec3 normal;  // unit normal of the emitting side
  int two_sided;
  uint instance;
  uint primitive;
  float mean_luminance;  // mean luminance of the emission over the triangle
  uint unused_0;
};

struct LightCluster {
  vec3 centre;
  float radius;
  vec3 axis;
  float cone_cosine;  // emission normals lie within this cone around the axis; -1: any direction
  vec3 low;           // bounding box
  float cone_sine;
  vec3 high;
  float intensity;
  uint first;  // index of the cluster's first table entry
  uint count;
  int two_sided;
  uint unused_0;
};

struct LightShape {
  float distant_irradiance;  // luminance of the irradiance of all directional lights
  float environment_irradiance;
  int cluster_count;
  int choice_count;  // 0: no light
  // Index of the first table entry of directional lights.
  uint first_distant;
  uint distant_count;
  int all_in_clusters;  // 1: every emitting triangle is in a cluster
  int is_one_point;     // 1: there is one light, without extent
  LightCluster clusters[kMaxClusters];
};

// AliasEntry::item is the index of an area light, or with this bit that of a punctual light.
const uint kPunctualItem = 0x80000000u;

STILLRAY_RENDER_END

#ifdef __cplusplus
namespace stillray::render {
static_assert(sizeof(EnvironmentShape) == 32);
static_assert(sizeof(AreaLight) == 80);
static_assert(sizeof(LightCluster) == 80);
static_assert(sizeof(LightShape) == 32 + kMaxClusters * sizeof(LightCluster));
}  // namespace stillray::render
#endif

#endif  // STILLRAY_RENDER_LIGHT_SHAPES_SHARED_H
