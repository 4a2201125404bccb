// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The values that the test computes at one position with the tracer's headers: the same lines on
// the CPU and on the device.
#ifndef STILLRAY_RENDER_GPU_FORMULAS_SHARED_H
#define STILLRAY_RENDER_GPU_FORMULAS_SHARED_H

#ifdef __cplusplus
#include "render/path_shared.h"
#include "render/sampler_shared.h"
#endif

STILLRAY_RENDER_BEGIN

struct FormulaPlace {
  vec3 point;
  uint seed;
  vec3 normal;
  uint number;
};

struct FormulaValues {
  vec4 sobol;
  vec4 halton;
  vec3 offset;
  uint pixel_seed;
  vec3 frame_x;
  float frame_cosine;
  vec3 direction;  // to a light
  float density;
  vec3 radiance;
  float distance;
  vec3 environment;
  float environment_density;
  float total;
  float area_density;
  float may_be_met;
  float survival;
  vec3 flight_weight;
  float flight_distance;
  vec3 scattered;
  float albedo;
};

SHARED_FN FormulaValues ComputeFormulas(LIGHTS_IN SHARED_IN(FormulaPlace) place) {
  FormulaValues values;
  values.pixel_seed = PixelSeed(place.seed, place.number, place.seed, place.number & 1u, 7u);
  values.sobol = PathNumbers(kSamplerSobol, place.number, place.seed, LightDimensions(2));
  values.halton = PathNumbers(kSamplerHalton16, place.number, place.seed, ScatterDimensions(1));
  values.offset = OffsetPoint(place.point, place.normal);
  LocalFrame frame = MakeLocalFrame(place.normal);
  values.frame_x = frame.x;
  values.frame_cosine = ToLocal(frame, ToWorld(frame, place.normal)).z;
  LightChoices choices = WeighLights(LIGHTS place.point);
  values.total = TotalOf(choices);
  LightSample light = SampleLights(LIGHTS place.point, place.normal, choices, values.sobol);
  values.direction = light.direction;
  values.density = light.density;
  values.radiance = light.radiance;
  values.distance = min(light.distance, 1e6f);
  values.environment = EnvironmentRadiance(LIGHTS_ENVIRONMENT place.normal);
  values.environment_density =
      DensityOfEnvironment(LIGHTS place.normal, values.total, place.normal);
  values.area_density = 0.0f;
  if (light.area >= 0) {
    values.area_density = DensityOfArea(LIGHTS AreaLightAt(LIGHTS uint(light.area)), place.point,
                                        values.total, light.direction, light.distance);
  }
  values.may_be_met = LightMayBeMet(LIGHTS place.point, place.normal) ? 1.0f : 0.0f;
  PathState path = StartPath(place.seed);
  path.bounces = kRouletteBounces;
  path.diffuse = vec3(values.sobol.x, values.sobol.y, values.sobol.z);
  values.survival = SurvivesRoulette(path, values.halton.x) ? path.throughput.x : 0.0f;
  Flight flight = FlyThrough(vec3(0.5f, 1.0f, 3.0f), vec3(0.9f, 0.5f, 0.2f),
                             vec3(values.sobol.x, values.sobol.y, values.sobol.z), 1.0f,
                             values.halton.y, values.halton.z);
  values.flight_weight = flight.weight;
  values.flight_distance = min(flight.distance, 1e6f);
  values.scattered = SampleScattering(place.normal, 1.8f * values.sobol.w - 0.9f, values.halton.x,
                                      values.halton.w);
  values.albedo = SingleScatterAlbedo(values.sobol.x);
  return values;
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_GPU_FORMULAS_SHARED_H
