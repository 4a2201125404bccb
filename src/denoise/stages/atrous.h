// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// atrous: one level of the edge-avoiding wavelet.
/// Source: Dammertz et al. 2010; SVGF section 4.3, eqs. 2 to 5; PSVGF section 4.4. The kernel is
/// the outer product of (1/4 1/2 1/4) or (1/16 1/4 3/8 1/4 1/16); taps lie `step` pixels apart.
/// Variance: sum(h^2 w^2 Var) / (sum(h w))^2. Pixels without light are skipped as taps and filled
/// as centres; they are taps of the levels after that. Pixels without a surface pass through.
/// Border: step * radius. Departs: where PSVGF prints w^2 Var for the variance, the normalised form
/// stands. Reads 48, writes 16 bytes per pixel (every tap again, from cache).
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/edge_stopping.h"

namespace stillray {

/// Sums of weights up to this are taken for nothing: the pixel keeps its value.
inline constexpr float kMinAtrousWeight = 1e-6f;

enum class AtrousWeights : int {
  kNaive,     ///< the kernel alone: no edge stops
  kGeometry,  ///< normal and depth
  kSvgf,      ///< normal, depth and luminance against the local spread
  kEaw,       ///< Gaussians of luminance, normal and depth differences
};

struct AtrousParameters {
  int step = 1;
  int radius = 2;  ///< 1: 3x3, 2: 5x5
  AtrousWeights weights = AtrousWeights::kSvgf;
  EdgeStopping edges;
  bool test_id = false;  ///< also stop at another id
  float sigma_l = 4;
  float noise_ratio = 1;  ///< >= 1; see SharedSpread
  float luminance_epsilon = 1e-4f;
  bool rec601 = false;
  float eaw_sigma_l = 1;  ///< in units of light; the caller halves it per level
  float eaw_sigma_n = 0.3f;
  float eaw_sigma_z = 0.05f;
  /// Set to 1 where there is light after this level, else 0 (`present` of the next one); nullptr:
  /// not wanted. Below one sample per pixel a level that forgot what the one before has filled
  /// would show single samples as dots.
  Image1* grown = nullptr;
};

/// \param spread   see prefilter_variance; read by kSvgf only
/// \param present  1 where there is light on a surface, else 0; all planes with border >= step *
/// radius
namespace reference {
void Atrous(const FilterPlanes& in, const Image1& spread, const Image1& present,
            const GuidePlanes& guides, const AtrousParameters& parameters, FilterPlanes* out);
}
namespace cpu {
void Atrous(const FilterPlanes& in, const Image1& spread, const Image1& present,
            const GuidePlanes& guides, const AtrousParameters& parameters, FilterPlanes* out);
}

}  // namespace stillray
