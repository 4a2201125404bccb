// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides of a pixel whose samples use different points of the lens.
#ifndef STILLRAY_RENDER_LENS_GUIDES_SHARED_H
#define STILLRAY_RENDER_LENS_GUIDES_SHARED_H

#ifdef __cplusplus
#include "render/geometry_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Sums over the samples. Colours are summed over all samples. Depth, normal, motion and roughness
// are taken from a single surface, since their means over several surfaces describe none of them:
// the surface hit by the majority of samples, if any has more than half of them (Boyer and Moore
// 1991, "MJRTY: a fast majority vote algorithm").
struct LensGuides {
  vec3 albedo;
  float depth;
  vec3 specular_albedo;
  float roughness;
  vec3 emission;
  float motion_x;
  vec3 background;
  float motion_y;
  vec3 normal;
  uint id;
  int samples;  // number of samples in the sums of colours
  int members;  // number of samples in the sums of the surface
  int votes;    // majority vote: samples of the surface minus later samples of other surfaces
  int unused_0;
  vec3 previous_normal;  // only for deforming surfaces
  float unused_1;
};

// Adds the guides of one more sample; samples, members and votes of `one` are 1.
SHARED_FN void AddLensSample(SHARED_INOUT(LensGuides) sum, SHARED_IN(LensGuides) one) {
  if (sum.samples == 0) {
    sum = one;
    return;
  }
  sum.albedo += one.albedo;
  sum.specular_albedo += one.specular_albedo;
  sum.emission += one.emission;
  sum.background += one.background;
  sum.samples += 1;
  if (one.id == sum.id) {
    sum.depth += one.depth;
    sum.roughness += one.roughness;
    sum.motion_x += one.motion_x;
    sum.motion_y += one.motion_y;
    sum.normal += one.normal;
    sum.previous_normal += one.previous_normal;
    sum.members += 1;
    sum.votes += 1;
  } else if (sum.votes > 0) {
    sum.votes -= 1;
  } else {
    sum.depth = one.depth;
    sum.roughness = one.roughness;
    sum.motion_x = one.motion_x;
    sum.motion_y = one.motion_y;
    sum.normal = one.normal;
    sum.previous_normal = one.previous_normal;
    sum.id = one.id;
    sum.members = 1;
    sum.votes = 1;
  }
}

SHARED_FN LensGuides MeanOfLensSamples(SHARED_IN(LensGuides) sum) {
  LensGuides mean = sum;
  float samples = float(sum.samples);
  float members = float(sum.members);
  mean.albedo /= samples;
  mean.specular_albedo /= samples;
  mean.emission /= samples;
  mean.background /= samples;
  mean.depth /= members;
  mean.roughness /= members;
  mean.motion_x /= members;
  mean.motion_y /= members;
  if (sum.members > 1) {
    mean.normal = SafeNormalize(sum.normal, vec3(0.0f));
    mean.previous_normal = SafeNormalize(sum.previous_normal, vec3(0.0f));
  }
  return mean;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LENS_GUIDES_SHARED_H
