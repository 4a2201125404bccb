// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/energy_tables.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "render/ggx_shared.h"

namespace stillray::render {
namespace {

// Midpoints over half of the azimuth (the lobe is symmetric) and over the polar variable.
constexpr int kAzimuthSteps = 12;
constexpr int kPolarSteps = 64;
// The smallest roughness of the tables; below it the lobe is ideally smooth for our purposes.
constexpr float kMinRoughness = 0.03f;
// Grazing rows are taken just above the horizon, where everything is defined.
constexpr float kMinCosine = 1e-3f;

vec3 DirectionWithCosine(float cosine) {
  return {std::sqrt(1.0f - cosine * cosine), 0.0f, cosine};
}

// Calls add(h, cos(wo, h)) for the microfacet normals of a fine grid over the sampled square.
template <typename Add>
void ForEachMicrofacet(vec3 wo, float alpha, const Add& add) {
  for (int a = 0; a < kAzimuthSteps; ++a) {
    for (int p = 0; p < kPolarSteps; ++p) {
      const vec3 h =
          SampleGgxVisible(wo, alpha, 0.5f * (a + 0.5f) / kAzimuthSteps, (p + 0.5f) / kPolarSteps);
      add(h, dot(wo, h));
    }
  }
}

// G2 / G1: what a sample of the visible normals is worth.
float ShadowingRatio(float lambda_o, vec3 wi, float alpha) {
  return (1.0f + lambda_o) / (1.0f + lambda_o + GgxLambda(wi, alpha));
}

template <typename Fill>
void FillTables(const Fill& fill) {
  tbb::parallel_for(0, EnergyTable::kSize, [&](int j) {
    for (int i = 0; i < EnergyTable::kSize; ++i) {
      fill(i, j, DirectionWithCosine(EnergyTable::CosineAt(i)), EnergyTable::AlphaAt(j));
    }
  });
}

SpecularEnergy MakeSpecularEnergy() {
  SpecularEnergy energy;
  FillTables([&](int i, int j, vec3 wo, float alpha) {
    const float lambda_o = GgxLambda(wo, alpha);
    double scale = 0;
    double offset = 0;
    ForEachMicrofacet(wo, alpha, [&](vec3 h, float cosine) {
      const vec3 wi = 2.0f * cosine * h - wo;
      if (wi.z > 0) {
        const float weight = ShadowingRatio(lambda_o, wi, alpha);
        const float s = SchlickWeight(cosine);
        scale += weight * (1.0f - s);
        offset += weight * s;
      }
    });
    constexpr double kCount = kAzimuthSteps * kPolarSteps;
    energy.scale.At(i, j) = static_cast<float>(scale / kCount);
    energy.offset.At(i, j) = static_cast<float>(offset / kCount);
  });
  return energy;
}

struct BoundaryEnergy {
  float reflected;
  float total;
};

BoundaryEnergy IntegrateBoundary(vec3 wo, float alpha, float eta) {
  const float lambda_o = GgxLambda(wo, alpha);
  double reflected = 0;
  double transmitted = 0;
  ForEachMicrofacet(wo, alpha, [&](vec3 h, float cosine) {
    const float fresnel = FresnelDielectric(cosine, eta);
    const vec3 up = 2.0f * cosine * h - wo;
    if (up.z > 0) {
      reflected += fresnel * ShadowingRatio(lambda_o, up, alpha);
    }
    const vec3 down = RefractAbout(wo, h, eta);
    if (fresnel < 1.0f && down.z < 0) {
      transmitted += (1.0f - fresnel) * ShadowingRatio(lambda_o, down, alpha);
    }
  });
  constexpr double kCount = kAzimuthSteps * kPolarSteps;
  return {static_cast<float>(reflected / kCount),
          static_cast<float>((reflected + transmitted) / kCount)};
}

float IntegrateSheetReflection(vec3 wo, float alpha, float ior) {
  const float lambda_o = GgxLambda(wo, alpha);
  double reflected = 0;
  ForEachMicrofacet(wo, alpha, [&](vec3 h, float cosine) {
    const vec3 up = 2.0f * cosine * h - wo;
    if (up.z > 0) {
      reflected += FresnelThinSheet(cosine, ior) * ShadowingRatio(lambda_o, up, alpha);
    }
  });
  return static_cast<float>(reflected / (kAzimuthSteps * kPolarSteps));
}

}  // namespace

float EnergyTable::CosineAt(int i) {
  // Denser towards grazing angles, where everything happens.
  const float x = static_cast<float>(i) / (kSize - 1);
  return std::max(x * x, kMinCosine);
}

float EnergyTable::AlphaAt(int j) {
  const float roughness =
      kMinRoughness + (1.0f - kMinRoughness) * static_cast<float>(j) / (kSize - 1);
  return roughness * roughness;
}

float EnergyTable::Lookup(float cosine, float roughness) const {
  const float x = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kSize - 1);
  const float y =
      std::clamp((roughness - kMinRoughness) / (1.0f - kMinRoughness), 0.0f, 1.0f) * (kSize - 1);
  const int i = std::min(static_cast<int>(x), kSize - 2);
  const int j = std::min(static_cast<int>(y), kSize - 2);
  const float fx = x - static_cast<float>(i);
  const float fy = y - static_cast<float>(j);
  const float* row = values_.data() + j * kSize + i;
  const float low = row[0] + (row[1] - row[0]) * fx;
  const float high = row[kSize] + (row[kSize + 1] - row[kSize]) * fx;
  return low + (high - low) * fy;
}

const SpecularEnergy& SpecularEnergyTables() {
  // Isolated: while it waits, this thread must not pick up a task that comes back here.
  static const SpecularEnergy kTables =
      tbb::this_task_arena::isolate([] { return MakeSpecularEnergy(); });
  return kTables;
}

GlassEnergy MakeGlassEnergy(float ior) {
  GlassEnergy energy;
  energy.ior = ior;
  FillTables([&](int i, int j, vec3 wo, float alpha) {
    const BoundaryEnergy enter = IntegrateBoundary(wo, alpha, ior);
    const BoundaryEnergy leave = IntegrateBoundary(wo, alpha, 1.0f / ior);
    energy.enter_reflected.At(i, j) = enter.reflected;
    energy.enter_total.At(i, j) = enter.total;
    energy.leave_reflected.At(i, j) = leave.reflected;
    energy.leave_total.At(i, j) = leave.total;
    energy.sheet_reflected.At(i, j) = IntegrateSheetReflection(wo, alpha, ior);
  });
  return energy;
}

}  // namespace stillray::render
