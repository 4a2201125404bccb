// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// atrous: one level of the edge-avoiding wavelet, for all signals at once. Source: Dammertz et al.
/// 2010; SVGF section 4.3, eqs. 2 to 5; PSVGF section 4.4. The kernel is the outer product of (1/4
/// 1/2 1/4) or (1/16 1/4 3/8 1/4 1/16); taps are `step` pixels apart. Variance: sum(h^2 w^2 Var) /
/// (sum(h w))^2. Pixels without samples are skipped as taps and filled as centres; later levels use
/// them as taps. Pixels without a surface pass through. Border: step * radius. Departs: uses the
/// normalised form of the variance, where PSVGF prints w^2 Var. Signals share the geometry weights
/// (normal, depth); kAtrousGeometry has only those. Reads 24 bytes of guides, or 16 with packed
/// normals, and 16 to 24 per signal and pixel (again for every tap, from cache), writes 16 per
/// signal.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/atrous_shared.h"
#include "denoise/stages/edge_stopping_shared.h"

namespace stillray {

/// One level of the wavelet.
struct AtrousLevel {
  int weights;       ///< kAtrousNaive, ...
  int radius;        ///< 1: 3x3, 2: 5x5
  int step;          ///< pixels between taps
  bool box = false;  ///< kernel of equal weights; kAtrousGeometry only
};

/// The levels within limit_history and keep_mirrors: 3x3, with geometry-only weights. They filter
/// two values and a variance: of the colour only luminance and red. Pixels without samples are
/// neither read nor written.
inline constexpr int kGeometryRadius = 1;
inline AtrousLevel GeometryLevel(int level) {
  return {kAtrousGeometry, kGeometryRadius, 1 << level};
}

/// The levels that compute the pilot estimates of the first levels of the wavelet: equal weights
/// over 9 pixels, since those of the wavelet's kernel leave as much noise as a mean of 7.
inline constexpr int kPilotLevels = 2;
inline AtrousLevel PilotLevel(int level) {
  return {kAtrousGeometry, kGeometryRadius, 1 << level, true};
}

/// Radius in pixels of the region that a level reads.
inline int ReachOf(const AtrousLevel& level) {
  return level.step * level.radius;
}

/// One signal and its planes for a level. All planes have the same size, and the same border, which
/// is at least step * radius.
struct AtrousSignal {
  const LumaImage3* colour;
  const Image1* variance;
  FilterPlanes* out;
  const Image1* luminance_factor;  ///< output of prefilter_variance; read with kAtrousSvgf only
  const Image1* valid;             ///< positive for surfaces with samples, else 0
  bool all_valid = false;          ///< every surface has samples: `valid` is redundant
  /// kAtrousGeometry only: input and output planes are 0 where `valid` is 0, the border included.
  bool zero_where_absent = false;
  /// kAtrousGeometry only: of the colour only the luminance is filtered.
  bool luminance_only = false;
  /// With luminance_only and all_valid: the history length, from which mix_pilot computes the share
  /// of the result in its mix with the input. nullptr: no mix. Not in the reference.
  const Image1* mixed_length = nullptr;
  float mixed_full = 0;   ///< history length up to which the result is not mixed
  float eaw_sigma_l = 1;  ///< luminance sigma of this level, in units of radiance
  /// The signal has only specular light: with kAtrousSvgf its normal weight is narrower on strongly
  /// curved surfaces (kLeastReflectedSigmaN).
  bool reflected = false;
  /// Luminance that the weights of kAtrousSvgf compare; nullptr: the luminance of `colour`.
  /// Arbitrary where `valid` is 0.
  const Image1* pilot = nullptr;
  /// 1 where the output of this level has a value, else 0 (`valid` of the next level); nullptr: not
  /// requested. Below one sample per pixel, single samples would appear as dots if a level skipped
  /// the pixels that the previous level has filled.
  Image1* valid_out = nullptr;
};

/// The sum of the weights of a level at each pixel, from the scalar version: 1 where every tap has
/// its full kernel weight, the centre's weight where no neighbour is similar, 0 without a surface.
void SumAtrousWeights(const AtrousSignal& signal, const GuidePlanes& guides,
                      const AtrousLevel& level, const AtrousParameters& parameters, Image1* sums);

namespace reference {
void Atrous(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
            const AtrousLevel& level, const AtrousParameters& parameters);
}
namespace cpu {
void Atrous(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
            const AtrousLevel& level, const AtrousParameters& parameters);
}

}  // namespace stillray
