// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// A row of a wavelet level: its planes, and the geometry weights of all its taps.
#if defined(STILLRAY_DENOISE_SIMD_ATROUS_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_ATROUS_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_ATROUS_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_ATROUS_ROWS_INL_H_
#endif

#include <cstddef>
#include <span>

#include "denoise/simd/guide_exponents-inl.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/normal_window.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/tap_pairs.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/atrous.h"

#ifndef STILLRAY_DENOISE_SIMD_ATROUS_PASS_ONCE
#define STILLRAY_DENOISE_SIMD_ATROUS_PASS_ONCE
namespace stillray {

inline constexpr size_t kMostSignals = 8;

/// The arguments common to all rows of a level.
struct AtrousPass {
  std::span<const AtrousSignal> signals;
  const GuidePlanes* guides;
  const AtrousLevel* level;
  const AtrousParameters* parameters;
  TapPairs taps;
  float centre_kernel;
  NormalRows normals = {};  ///< of the row in progress
};
}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// One signal at the pixels x, x + 1, ... of a row.
struct SignalRow {
  const float* luminance;
  const float* red;
  const float* blue;
  const float* variance;
  const float* pilot;  ///< the luminance that weights compare: the pilot if given, else `luminance`
  const float* luminance_factor;
  const float* valid;
  float eaw_l;  ///< log2(e) / sigma^2
};

inline SignalRow RowOf(const AtrousSignal& s, int y) {
  const LumaImage3& colour = *s.colour;
  return {colour[0].Row(y),
          colour[1].Row(y),
          colour[2].Row(y),
          s.variance->Row(y),
          (s.pilot != nullptr ? *s.pilot : colour[0]).Row(y),
          s.luminance_factor != nullptr ? s.luminance_factor->Row(y) : nullptr,
          s.valid->Row(y),
          kLog2E / (s.eaw_sigma_l * s.eaw_sigma_l)};
}

/// Destination of the filtered pixels of one signal.
struct OutputRow {
  float* value[4];   ///< luminance, red, blue, variance
  float* valid_out;  ///< nullptr: not requested
};

inline OutputRow OutputOf(const AtrousSignal& s, int y) {
  LumaImage3& colour = s.out->colour;
  return {{colour[0].Row(y), colour[1].Row(y), colour[2].Row(y), s.out->variance.Row(y)},
          s.valid_out != nullptr ? s.valid_out->Row(y) : nullptr};
}

using NextGuides = NextRow<2 + 5 * 4>;
using NextSignal = NextRow<6 + 5 * 6>;

/// The guides that the next row reads for the first time; with `all_taps`, all that it reads.
inline NextGuides NextGuidesOf(const AtrousPass& pass, bool all_taps, int y) {
  const AtrousLevel& level = *pass.level;
  const GuidePlanes& g = *pass.guides;
  NextGuides next;
  next.Add(g.gradient, y + level.step);
  for (int tap = all_taps ? -level.radius : level.radius; tap <= level.radius; ++tap) {
    const int row = y + level.step + level.step * tap;
    next.Add(g.normal, row);
    next.Add(pass.parameters->edges.depth_weight_plane != 0 ? g.inverse_depth : g.depth, row);
  }
  return next;
}

/// The planes of one signal in the next row.
inline NextSignal NextSignalOf(const AtrousPass& pass, const AtrousSignal& signal, bool all_taps,
                               int y) {
  const AtrousLevel& level = *pass.level;
  const float noise_ratio = pass.parameters->noise_ratio;
  const int own = y + level.step;  // the pixels themselves
  const bool geometry = level.weights == kAtrousGeometry;
  const int channels = !geometry ? 3 : signal.luminance_only ? 1 : 2;
  NextSignal next;
  for (int c = 0; c < channels; ++c) {
    AddStreamed(signal.out->colour[c], own, &next);
  }
  AddStreamed(signal.out->variance, own, &next);
  if (signal.valid_out != nullptr) {
    AddStreamed(*signal.valid_out, own, &next);
  }
  if (signal.mixed_length != nullptr) {
    next.Add(*signal.mixed_length, own);
  }
  if (!geometry && signal.pilot != nullptr) {
    next.Add(*signal.pilot, own + level.step * level.radius);
  }
  if (!geometry && noise_ratio <= 1) {
    next.Add(*signal.luminance_factor, own);
  }
  for (int tap = all_taps ? -level.radius : level.radius; tap <= level.radius; ++tap) {
    const int row = own + level.step * tap;
    for (int c = 0; c < channels; ++c) {
      next.Add((*signal.colour)[c], row);
    }
    next.Add(*signal.variance, row);
    if (!geometry && noise_ratio > 1) {
      next.Add(*signal.luminance_factor, row);
    }
    if (!signal.all_valid) {
      next.Add(*signal.valid, row);
    }
  }
  return next;
}

/// The weight where there are samples, else 0.
HWY_INLINE VF WherePresent(const SignalRow& s, ptrdiff_t q, VF weight) {
  const DF d;
  return hn::IfThenElseZero(hn::Gt(hn::LoadU(d, s.valid + q), hn::Zero(d)), weight);
}

/// Whether the normal exponents of specular light differ from those of other signals at some of the
/// pixels x, x + 1, ... of a row.
HWY_INLINE bool IsRaised(const EdgeStopping& edges, const GuideRow& guide, int x) {
  const DF d;
  // From this squared turn on, CurvedSigmaN without its bound is below kLeastReflectedSigmaN.
  const float turn2 =
      (edges.sigma_n / kLeastReflectedSigmaN - 1) / (edges.curvature * edges.sigma_n);
  return !hn::AllFalse(d, hn::Gt(hn::LoadU(d, guide.turn2 + x), hn::Set(d, turn2)));
}

/// The output of ExponentsOfRow.
enum class OfGuides {
  kExponents,
  kReflected,  ///< exponents of specular light, stored only where they differ from kExponents
  kWeights,    ///< weights of a level with geometry-only weights, which ignores ids
};

/// Computes the exponents of the guides for all taps of a row.
/// \tparam kNormals  ignored with Depths::kPosition, which selects it at run time
template <int kPairs, Normals kNormals, Depths kDepths, bool kTestId, OfGuides kWhat>
void ExponentsOfRow(const AtrousPass& pass, int y, TapSlots to) {
  constexpr bool kWeights = kWhat == OfGuides::kWeights;
  constexpr bool kByPosition = kDepths == Depths::kPosition;
  const DF d;
  // Local copies, so that compilers need not reload them after stores.
  const EdgeStopping edges = pass.parameters->edges;
  const TapPairs taps = WithBias(pass.taps, edges, kByPosition ? NormalsOf(edges) : kNormals);
  const GuideRow guide = GuideRowOf<kDepths>(*pass.guides, pass.normals, edges, y);
  const bool test_id = kTestId && pass.parameters->wavelet_id != 0 && !kWeights;
  const int width = pass.guides->id.width();
  const float least = kWhat == OfGuides::kReflected ? kLeastReflectedSigmaN : kLeastCurvedSigmaN;
  const NextGuides next = NextGuidesOf(pass, false, y);
  for (int x = 0; x < width; x += LaneCount(), to.first += LaneCount()) {
    if constexpr (kWhat == OfGuides::kReflected) {
      if (!IsRaised(edges, guide, x)) {
        continue;
      }
    } else {
      next.Fetch(x);
    }
    if (hn::AllFalse(d, hn::Gt(hn::LoadU(d, guide.depth + x), hn::Zero(d)))) {
      continue;
    }
    const GuideCentre c = LoadGuideCentre<kDepths>(guide, edges, x, least);
    if constexpr (kByPosition) {
      PositionExponents(taps, edges, test_id, guide, c, x, y, to);
      if constexpr (kWeights) {
        WeightsOfExponents<kPairs>(taps, to);
      }
    } else {
      GuideExponents<kNormals, kDepths, kPairs, kWeights>(taps, edges, test_id, guide, c, x, to);
    }
  }
}

/// Selects the template arguments, which replace branches in the innermost loop.
template <int kPairs, OfGuides kWhat>
void ExponentsOfRow(const AtrousPass& pass, int y, TapSlots to) {
  const AtrousParameters& p = *pass.parameters;
  const Normals normals =
      kWhat == OfGuides::kWeights ? DenseNormalsOf(p.edges) : NormalsOf(p.edges);
  const bool plane = p.edges.depth_weight_plane != 0;
  const bool ids = p.wavelet_id != 0 && kWhat != OfGuides::kWeights;
  if (p.edges.depth_weight_position != 0) {
    ExponentsOfRow<kPairs, Normals::kLogarithm, Depths::kPosition, true, kWhat>(pass, y, to);
  } else if (normals == Normals::kLogarithm) {
    ExponentsOfRow<kPairs, Normals::kLogarithm, Depths::kEither, true, kWhat>(pass, y, to);
  } else if (normals == Normals::kCubic && plane) {
    ExponentsOfRow<kPairs, Normals::kCubic, Depths::kPlane, false, kWhat>(pass, y, to);
  } else if (normals == Normals::kCubic) {
    ExponentsOfRow<kPairs, Normals::kCubic, Depths::kGradient, false, kWhat>(pass, y, to);
  } else if (normals == Normals::kCurved && plane && !ids) {
    ExponentsOfRow<kPairs, Normals::kCurved, Depths::kPlane, false, kWhat>(pass, y, to);
  } else if (normals == Normals::kCurved) {
    ExponentsOfRow<kPairs, Normals::kCurved, Depths::kEither, true, kWhat>(pass, y, to);
  } else if (ids) {
    ExponentsOfRow<kPairs, Normals::kParabola, Depths::kEither, true, kWhat>(pass, y, to);
  } else if (plane) {
    ExponentsOfRow<kPairs, Normals::kParabola, Depths::kPlane, false, kWhat>(pass, y, to);
  } else {
    ExponentsOfRow<kPairs, Normals::kParabola, Depths::kGradient, false, kWhat>(pass, y, to);
  }
}

/// The exponents of specular light where they differ, i.e. on curved surfaces.
template <int kPairs>
void ReflectedExponentsOfRow(const AtrousPass& pass, int y, TapSlots to) {
  constexpr OfGuides kWhat = OfGuides::kReflected;
  const AtrousParameters& p = *pass.parameters;
  if (p.edges.depth_weight_position != 0) {
    ExponentsOfRow<kPairs, Normals::kLogarithm, Depths::kPosition, true, kWhat>(pass, y, to);
  } else if (p.edges.depth_weight_plane != 0 && p.wavelet_id == 0) {
    ExponentsOfRow<kPairs, Normals::kCurved, Depths::kPlane, false, kWhat>(pass, y, to);
  } else {
    ExponentsOfRow<kPairs, Normals::kCurved, Depths::kEither, true, kWhat>(pass, y, to);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
