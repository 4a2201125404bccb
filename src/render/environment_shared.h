// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The environment light, at infinite distance, and its importance sampling.
//
// In C++ the environment is an argument, ENVIRONMENT_IN. In GLSL, which cannot pass it, the
// including shader first declares a variable `environment` of EnvironmentShape, and
//   float EnvironmentSum(int i)            the i-th of the cumulative sums
//   vec3 EnvironmentTexel(int x, int y)    a texel of the map
#ifndef STILLRAY_RENDER_ENVIRONMENT_SHARED_H
#define STILLRAY_RENDER_ENVIRONMENT_SHARED_H

#ifdef __cplusplus
#include "render/angles_shared.h"
#include "render/bsdf_shared.h"
#include "render/geometry_shared.h"
#include "render/light_shapes_shared.h"
#include "stillray/image.h"
#endif

STILLRAY_RENDER_BEGIN

#ifdef __cplusplus
struct EnvironmentArrays : EnvironmentShape {
  const float* sums = nullptr;
  const Image3* map = nullptr;
};
inline float EnvironmentSum(const EnvironmentArrays& environment, int i) {
  return environment.sums[i];
}
inline vec3 EnvironmentTexel(const EnvironmentArrays& environment, int x, int y) {
  const Image3& map = *environment.map;
  return {map[0](x, y), map[1](x, y), map[2](x, y)};
}
#define ENVIRONMENT_IN const EnvironmentArrays &environment,
#define ENVIRONMENT environment,
#else
#define ENVIRONMENT_IN
#define ENVIRONMENT
#endif

struct EnvironmentSample {
  vec3 direction;
  vec3 radiance;
  float density;  // PDF per solid angle; 0: invalid
};

// Texel coordinates of a direction in the environment map: x in 0..width, y in 0..height.
SHARED_FN vec2 EnvironmentPlace(ENVIRONMENT_IN vec3 direction) {
  float u = 0.5f + ArcTangent(direction.x, -direction.z) * (0.5f * kInvPi);
  float v = ArcCosine(clamp(direction.y, -1.0f, 1.0f)) * kInvPi;
  return vec2(u * float(environment.width), v * float(environment.height));
}

// \param x  -1..width
SHARED_FN vec3 FetchEnvironment(ENVIRONMENT_IN int x, int y) {
  int w = environment.width;
  int wrapped = x < 0 ? x + w : (x >= w ? x - w : x);
  return EnvironmentTexel(ENVIRONMENT wrapped, clamp(y, 0, environment.height - 1));
}

// Bilinearly filtered radiance at texel coordinates.
SHARED_FN vec3 RadianceOfPlace(ENVIRONMENT_IN vec2 at) {
  float left = floor(at.x - 0.5f);
  float top = floor(at.y - 0.5f);
  float fx = at.x - 0.5f - left;
  float fy = at.y - 0.5f - top;
  int x = clamp(int(left), -1, environment.width - 1);
  int y = clamp(int(top), -1, environment.height - 1);
  vec3 upper = FetchEnvironment(ENVIRONMENT x, y) * (1.0f - fx) +
               FetchEnvironment(ENVIRONMENT x + 1, y) * fx;
  vec3 lower = FetchEnvironment(ENVIRONMENT x, y + 1) * (1.0f - fx) +
               FetchEnvironment(ENVIRONMENT x + 1, y + 1) * fx;
  return environment.radiance * (upper * (1.0f - fy) + lower * fy);
}

SHARED_FN vec3 EnvironmentRadiance(ENVIRONMENT_IN vec3 direction) {
  return environment.width == 0
             ? environment.radiance
             : RadianceOfPlace(ENVIRONMENT EnvironmentPlace(ENVIRONMENT direction));
}

// Cumulative sums from 0 to 1: of the rows, then of the columns of each row.
SHARED_FN int FirstColumnSum(ENVIRONMENT_IN int row) {
  return environment.height + 1 + row * (environment.width + 1);
}

// Index of the interval that contains u, in the sums from `first` on (count + 1 values).
SHARED_FN int FindInterval(ENVIRONMENT_IN int first, int count, float u) {
  // Branch-free: branches would be mispredicted half of the time.
  int low = 0;
  while (count > 1) {
    int half_count = count / 2;
    low += EnvironmentSum(ENVIRONMENT first + low + half_count) <= u ? half_count : 0;
    count -= half_count;
  }
  return low;
}

// u remapped to [0, 1) within the interval.
SHARED_FN float PlaceInInterval(ENVIRONMENT_IN int first, int interval, float u) {
  float below = EnvironmentSum(ENVIRONMENT first + interval);
  float width = EnvironmentSum(ENVIRONMENT first + interval + 1) - below;
  return width > 0.0f ? clamp((u - below) / width, 0.0f, kBelowOne) : 0.5f;
}

// PDF of SampleEnvironment for a direction in texel (x, y).
// \param sine  sine of the angle between direction and vertical axis
SHARED_FN float DensityOfTexel(ENVIRONMENT_IN int x, int y, float sine) {
  int column = FirstColumnSum(ENVIRONMENT y) + x;
  float in_square = (EnvironmentSum(ENVIRONMENT column + 1) - EnvironmentSum(ENVIRONMENT column)) *
                    float(environment.width) *
                    (EnvironmentSum(ENVIRONMENT y + 1) - EnvironmentSum(ENVIRONMENT y)) *
                    float(environment.height);
  return sine > 0.0f ? in_square / (2.0f * kPi * kPi * sine) : 0.0f;
}

// PDF of SampleEnvironment.
SHARED_FN float EnvironmentDensity(ENVIRONMENT_IN vec3 normal, vec3 direction) {
  if (environment.width == 0) {
    return max(dot(normal, direction), 0.0f) * kInvPi;
  }
  vec2 at = EnvironmentPlace(ENVIRONMENT direction);
  int x = clamp(int(at.x), 0, environment.width - 1);
  int y = clamp(int(at.y), 0, environment.height - 1);
  return DensityOfTexel(ENVIRONMENT x, y, sqrt(max(1.0f - direction.y * direction.y, 0.0f)));
}

// Samples a direction: from a map in proportion to its luminance; from a constant environment in
// proportion to the cosine with `normal`. u in [0,1)^2.
SHARED_FN EnvironmentSample SampleEnvironment(ENVIRONMENT_IN vec3 normal, float u0, float u1) {
  EnvironmentSample found;
  if (environment.width == 0) {
    found.direction = ToWorld(MakeLocalFrame(normal), SampleCosine(u0, u1));
    found.radiance = environment.radiance;
    found.density = EnvironmentDensity(ENVIRONMENT normal, found.direction);
    return found;
  }
  int y = FindInterval(ENVIRONMENT 0, environment.height, u1);
  int columns = FirstColumnSum(ENVIRONMENT y);
  int x = FindInterval(ENVIRONMENT columns, environment.width, u0);
  vec2 at = vec2(float(x) + PlaceInInterval(ENVIRONMENT columns, x, u0),
                 float(y) + PlaceInInterval(ENVIRONMENT 0, y, u1));
  vec2 around = CosSin((at.x / float(environment.width) - 0.5f) * 2.0f * kPi);
  vec2 from_top = CosSin(at.y / float(environment.height) * kPi);
  found.direction = vec3(from_top.y * around.y, from_top.x, -from_top.y * around.x);
  found.radiance = RadianceOfPlace(ENVIRONMENT at);
  found.density = DensityOfTexel(ENVIRONMENT x, y, from_top.y);
  return found;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_ENVIRONMENT_SHARED_H
