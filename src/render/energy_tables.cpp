// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/energy_tables.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "render/energy_shared.h"
#include "render/ggx_shared.h"
#include "render/sampler_shared.h"
#include "render/sheen_shared.h"

namespace stillray::render {
namespace {

/// Size of the Hammersley set over half of the azimuth (the lobe is symmetric) and the polar
/// variable. The integrand has a kink at the critical angle, where a regular grid of equal size has
/// an error of two percent.
constexpr int kPointCount = 1024;
/// Cosine at which grazing rows are evaluated: just above the horizon, where all terms are defined.
constexpr float kMinCosine = 1e-3f;

/// The second coordinate of point i, shifted to the middle of its interval.
float PolarPoint(uint32_t i) {
  return FractionToFloat(ReverseBits(i)) + 0.5f / kPointCount;
}

vec3 DirectionWithCosine(float cosine) {
  return {std::sqrt(1.0f - cosine * cosine), 0.0f, cosine};
}

/// Calls add(h, cos(wo, h)) for visible microfacet normals of evenly distributed random numbers.
template <typename Add>
void ForEachMicrofacet(vec3 wo, float alpha, const Add& add) {
  for (uint32_t i = 0; i < kPointCount; ++i) {
    const float azimuth = 0.5f * (static_cast<float>(i) + 0.5f) / kPointCount;
    const vec3 h = SampleGgxVisible(wo, alpha, azimuth, PolarPoint(i));
    add(h, dot(wo, h));
  }
}

/// G2 / G1: the weight of a sample of the visible normals.
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
    energy.scale.At(i, j) = static_cast<float>(scale / kPointCount);
    energy.offset.At(i, j) = static_cast<float>(offset / kPointCount);
  });
  return energy;
}

/// The viewer's direction and the alphas of an entry: the inverse of FindAnisotropicEnergy.
struct AnisotropicCase {
  vec3 wo;
  vec2 alpha;
};

AnisotropicCase CaseOfEntry(int entry) {
  const auto take = [&](int size) {
    const int i = entry % size;
    entry /= size;
    return static_cast<float>(i) / static_cast<float>(size - 1);
  };
  const float x = take(kAnisotropicCosines);
  const float turn = take(kAnisotropicTurns);
  const float roughness =
      kEnergyLeastRoughness + (1.0f - kEnergyLeastRoughness) * take(kAnisotropicRoughnesses);
  const float across = roughness * roughness;
  const float strength = take(kAnisotropicStrengths);
  const float along = glm::mix(across, 1.0f, strength * strength);
  const float cosine = std::max(x * x, kMinCosine);
  const float sine = std::sqrt(1.0f - cosine * cosine);
  // c is the fraction of the squared sine along the tangent: met^2 = along^2 c + across^2 (1 - c).
  const float met = across + turn * (along - across);
  const float c =
      along > across
          ? clamp((met * met - across * across) / (along * along - across * across), 0.0f, 1.0f)
          : turn;
  return {{sine * std::sqrt(c), sine * std::sqrt(1.0f - c), cosine}, {along, across}};
}

/// Integrates scale and offset of an anisotropic lobe over the whole azimuth, since it is not
/// symmetric.
SchlickShare IntegrateAnisotropic(const AnisotropicCase& at) {
  constexpr int kPoints = 512;
  const float lambda_o = GgxLambdaOf2(at.wo, at.alpha);
  double scale = 0;
  double offset = 0;
  for (uint32_t i = 0; i < kPoints; ++i) {
    const float azimuth = (static_cast<float>(i) + 0.5f) / kPoints;
    const float polar = FractionToFloat(ReverseBits(i)) + 0.5f / kPoints;
    const vec3 h = SampleGgxVisibleOf2(at.wo, at.alpha, azimuth, polar);
    const float cosine = dot(at.wo, h);
    const vec3 wi = 2.0f * cosine * h - at.wo;
    if (wi.z > 0) {
      const float weight = (1.0f + lambda_o) / (1.0f + lambda_o + GgxLambdaOf2(wi, at.alpha));
      const float s = SchlickWeight(cosine);
      scale += weight * (1.0f - s);
      offset += weight * s;
    }
  }
  return {static_cast<float>(scale / kPoints), static_cast<float>(offset / kPoints)};
}

/// The directional albedo of white sheen: a grid over half of the azimuth and the square root of
/// the cosine, as the integrand rises steeply at the horizon.
float SheenAlbedo(vec3 wo, float roughness) {
  constexpr int kCosines = 32;
  constexpr int kAzimuths = 16;
  const float alpha = SheenAlpha(roughness);
  double sum = 0;
  for (int i = 0; i < kCosines; ++i) {
    const float t = (static_cast<float>(i) + 0.5f) / kCosines;
    const float sine = std::sqrt(1.0f - t * t * t * t);
    for (int j = 0; j < kAzimuths; ++j) {
      const vec2 turn = CosSinOfTurn(0.5f * (static_cast<float>(j) + 0.5f) / kAzimuths);
      sum += 2.0f * t * EvaluateSheen(wo, {sine * turn.x, sine * turn.y, t * t}, alpha);
    }
  }
  return static_cast<float>(sum * (2.0 * kPi / (kCosines * kAzimuths)));
}

SheenEnergy MakeSheenEnergy() {
  SheenEnergy energy;
  FillTables([&](int i, int j, vec3 wo, float alpha) {
    energy.albedo.At(i, j) = SheenAlbedo(wo, SheenOfRow(std::sqrt(alpha)));
  });
  return energy;
}

/// Adds one microfacet's contribution to a boundary's reflectance and transmittance.
void AddBoundary(vec3 wo, vec3 h, float cosine, float alpha, float lambda_o, float reflected_weight,
                 float eta, double* reflected, double* total) {
  const float fresnel = FresnelDielectric(cosine, eta);
  *reflected += fresnel * reflected_weight;
  *total += fresnel * reflected_weight;
  if (fresnel < 1.0f) {
    const vec3 down = RefractAbout(wo, h, eta);
    if (down.z < 0) {
      *total += (1.0f - fresnel) * ShadowingRatio(lambda_o, down, alpha);
    }
  }
}

}  // namespace

float EnergyTable::CosineAt(int i) {
  // Denser towards grazing angles, where the albedos vary most.
  const float x = static_cast<float>(i) / (kSize - 1);
  return std::max(x * x, kMinCosine);
}

float EnergyTable::AlphaAt(int j) {
  const float roughness =
      kEnergyLeastRoughness + (1.0f - kEnergyLeastRoughness) * static_cast<float>(j) / (kSize - 1);
  return roughness * roughness;
}

EnergyTable::Place EnergyTable::Find(float cosine, float roughness) {
  static_assert(kSize == kEnergyTableSize);
  const EnergyPlace place = FindEnergy(cosine, roughness);
  return {place.first, place.x, place.y};
}

const SpecularEnergy& SpecularEnergyTables() {
  // Isolated: a thread that waits here must not run a task that calls this function.
  static const SpecularEnergy kTables =
      tbb::this_task_arena::isolate([] { return MakeSpecularEnergy(); });
  return kTables;
}

const SheenEnergy& SheenEnergyTable() {
  static const SheenEnergy kTable = tbb::this_task_arena::isolate([] { return MakeSheenEnergy(); });
  return kTable;
}

AnisotropicEnergy::AnisotropicEnergy() {
  tbb::parallel_for(0, kAnisotropicEntries, [&](int i) {
    const SchlickShare share = IntegrateAnisotropic(CaseOfEntry(i));
    scale_[static_cast<size_t>(i)] = share.scale;
    offset_[static_cast<size_t>(i)] = share.offset;
  });
}

SchlickShare AnisotropicEnergy::Lookup(vec3 w, vec2 alpha) const {
  const AnisotropicPlace place = FindAnisotropicEnergy(w, alpha);
  SchlickShare share = {0.0f, 0.0f};
  for (int corner = 0; corner < 16; ++corner) {
    const auto entry = static_cast<size_t>(AnisotropicEntry(place, corner));
    const float weight = AnisotropicWeight(place, corner);
    share.scale += weight * scale_[entry];
    share.offset += weight * offset_[entry];
  }
  return share;
}

const AnisotropicEnergy& AnisotropicEnergyTables() {
  static const AnisotropicEnergy kTables =
      tbb::this_task_arena::isolate([] { return AnisotropicEnergy(); });
  return kTables;
}

GlassEnergy MakeGlassEnergy(float ior) {
  GlassEnergy energy;
  FillTables([&](int i, int j, vec3 wo, float alpha) {
    const float lambda_o = GgxLambda(wo, alpha);
    double enter[2] = {0, 0};  // reflected, total
    double leave[2] = {0, 0};
    double sheet = 0;
    ForEachMicrofacet(wo, alpha, [&](vec3 h, float cosine) {
      const vec3 up = 2.0f * cosine * h - wo;
      const float reflected = up.z > 0 ? ShadowingRatio(lambda_o, up, alpha) : 0.0f;
      AddBoundary(wo, h, cosine, alpha, lambda_o, reflected, ior, &enter[0], &enter[1]);
      AddBoundary(wo, h, cosine, alpha, lambda_o, reflected, 1.0f / ior, &leave[0], &leave[1]);
      sheet += FresnelThinSheet(cosine, ior) * reflected;
    });
    energy.enter_reflected.At(i, j) = static_cast<float>(enter[0] / kPointCount);
    energy.enter_total.At(i, j) = static_cast<float>(enter[1] / kPointCount);
    energy.leave_reflected.At(i, j) = static_cast<float>(leave[0] / kPointCount);
    energy.leave_total.At(i, j) = static_cast<float>(leave[1] / kPointCount);
    energy.sheet_reflected.At(i, j) = static_cast<float>(sheet / kPointCount);
  });
  return energy;
}

}  // namespace stillray::render
