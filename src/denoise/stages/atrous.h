// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// atrous: one level of the edge-avoiding wavelet, for all signals at once. Source: Dammertz et al.
/// 2010; SVGF section 4.3, eqs. 2 to 5; PSVGF section 4.4. The kernel is the outer product of (1/4
/// 1/2 1/4) or (1/16 1/4 3/8 1/4 1/16); taps are `step` pixels apart. Variance: sum(h^2 w^2 Var) /
/// (sum(h w))^2. Pixels without light are skipped as taps and filled as centres; they are taps of
/// later levels. Pixels without a surface pass through. Border: step * radius. Departs: uses the
/// normalised form of the variance, where PSVGF prints w^2 Var. Signals share the weights of the
/// guides; kAtrousGeometry has no others. Reads 24 bytes of guides, or 16 with packed normals, and
/// 16 to 24 per signal and pixel (every tap again, from cache), writes 16 per signal.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/atrous_shared.h"
#include "denoise/stages/edge_stopping_shared.h"

namespace stillray {

/// The properties of a level.
struct AtrousLevel {
  int weights;       ///< kAtrousNaive, ...
  int radius;        ///< 1: 3x3, 2: 5x5
  int step;          ///< pixels between taps
  bool box = false;  ///< kernel of equal weights; kAtrousGeometry only
};

/// The levels within limit_history and keep_mirrors: 3x3, with geometry-only weights. These have
/// two values and a variance: of the colour only luminance and red are filtered, and pixels without
/// light are neither read nor written.
inline constexpr int kGeometryRadius = 1;
inline AtrousLevel GeometryLevel(int level) {
  return {kAtrousGeometry, kGeometryRadius, 1 << level};
}

/// The levels that compute the pilot estimates of the first levels of the wavelet: equal weights,
/// since the kernel's would have the noise of 7 pixels, not of 9.
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
  const Image1* luminance_factor;  ///< see prefilter_variance; read with kAtrousSvgf only
  const Image1* valid;             ///< positive where there is light on a surface, else 0
  bool all_valid = false;          ///< every surface has light, so `valid` is redundant
  /// kAtrousGeometry only: every plane is 0 where `valid` is, the border included. So is the
  /// result.
  bool zero_where_absent = false;
  /// kAtrousGeometry only: of the colour, nothing but the luminance is filtered.
  bool luminance_only = false;
  /// With luminance_only and all_valid: the length of the histories, by which mix_pilot mixes the
  /// result with the signal itself. nullptr: it is not mixed. Not in the reference.
  const Image1* mixed_length = nullptr;
  float mixed_full = 0;   ///< length up to which the result is the mean alone
  float eaw_sigma_l = 1;  ///< in units of light, of this level
  /// Nothing but specular light: its normal weight, of kAtrousSvgf, is narrower where a surface is
  /// strongly curved (kLeastReflectedSigmaN).
  bool reflected = false;
  /// Luminance that the weights of kAtrousSvgf compare; nullptr: that of `colour`. Where `valid` is
  /// 0 it may have any value.
  const Image1* pilot = nullptr;
  /// Set to 1 where there is light after this level, else 0 (`valid` of the next one); nullptr:
  /// not requested. Below one sample per pixel single samples would show as dots if a level skipped
  /// the pixels that the previous one has filled.
  Image1* valid_out = nullptr;
};

/// The sum of the weights of a level at each pixel, as the scalar version computes them: 1 where
/// every tap counts with its kernel's weight, the centre's own where no neighbour is similar, 0
/// without a surface.
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
