// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Directional albedo of the rough lobes for reflection and transmission, by direction and
/// roughness: integrated numerically at start-up, deterministically.
#pragma once

#include <array>

#include "render/energy_shared.h"
#include "stillray/vec.h"

namespace stillray::render {

/// A function of the cosine with the normal and of perceptual roughness, by bilinear interpolation.
class EnergyTable {
 public:
  static constexpr int kSize = 32;

  /// An interpolation position, valid for all tables.
  struct Place {
    int first;  // index of the first of the four entries
    float x, y;
  };
  /// \param cosine, roughness  0..1, clamped
  static Place Find(float cosine, float roughness);

  float Lookup(const Place& at) const {
    const float* row = values_.data() + at.first;
    const float low = row[0] + (row[1] - row[0]) * at.x;
    const float high = row[kSize] + (row[kSize + 1] - row[kSize]) * at.x;
    return low + (high - low) * at.y;
  }

  /// The cosine and the GGX alpha of entry (i, j).
  static float CosineAt(int i);
  static float AlphaAt(int j);
  float& At(int i, int j) { return values_[static_cast<size_t>(j * kSize + i)]; }

 private:
  std::array<float, static_cast<size_t>(kSize* kSize)> values_{};
};

/// Directional albedo of single-scattering GGX reflection: f0 * scale + f90 * offset with the
/// Fresnel term F = f0 (1 - s) + f90 s, s Schlick's weight; scale + offset with F = 1.
struct SpecularEnergy {
  EnergyTable scale;
  EnergyTable offset;
};

/// Directional albedo of rough boundaries between dielectrics, before energy compensation.
struct GlassEnergy {
  EnergyTable enter_reflected;  ///< from outside
  EnergyTable enter_total;
  EnergyTable leave_reflected;  ///< from inside
  EnergyTable leave_total;
  EnergyTable sheet_reflected;  ///< thin sheet; total: scale + offset of SpecularEnergy
};

/// SpecularEnergy of anisotropic lobes, by FindAnisotropicEnergy. Absolute error below 0.02 where
/// the viewer's cosine is above 0.03, 0.001 on average.
class AnisotropicEnergy {
 public:
  static constexpr size_t kEntries = kAnisotropicEntries;

  AnisotropicEnergy();
  /// \param w      direction to the viewer; x along the tangent
  /// \param alpha  x along the tangent, y across; x >= y
  SchlickShare Lookup(vec3 w, vec2 alpha) const;

  const std::array<float, kEntries>& scale() const { return scale_; }
  const std::array<float, kEntries>& offset() const { return offset_; }

 private:
  std::array<float, kEntries> scale_;
  std::array<float, kEntries> offset_;
};

/// Directional albedo of white sheen, by the cosine and sheen roughness.
struct SheenEnergy {
  EnergyTable albedo;
};

/// Computed at the first call (some milliseconds), thread-safe.
const SpecularEnergy& SpecularEnergyTables();
/// Computed at the first call (some 30 milliseconds), thread-safe.
const SheenEnergy& SheenEnergyTable();
/// Computed at the first call (some 300 milliseconds of CPU time over all threads), thread-safe.
const AnisotropicEnergy& AnisotropicEnergyTables();
/// \param ior  >= 1
GlassEnergy MakeGlassEnergy(float ior);

}  // namespace stillray::render
