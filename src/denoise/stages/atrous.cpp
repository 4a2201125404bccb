// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// One exponent of 2 per tap: kernel, normal, depth and luminance are summed before a single
// exponential; the geometry part is computed once for all signals. Taps are processed in pairs at
// opposite offsets, which share the slope's tolerance. All planes have one stride, so that a tap
// has one offset for all of them; normals in the border are zero, so that weights there are zero
// without a test. Packed normals are unpacked row by row beforehand.
#include "denoise/stages/atrous.h"

#include <span>

#include "core/check.h"
#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/normal_window.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/atrous.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/atrous_geometry-inl.h"
#include "denoise/simd/atrous_rows-inl.h"
#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/packed_normal-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_ATROUS_ONCE
#define STILLRAY_ATROUS_ONCE
namespace stillray {

/// The i-th row in an order in which rows with equal residues modulo `step` are consecutive, so
/// that a level's taps stay in the cache.
inline int RowInOrder(int i, int step, int height) {
  const int rows = height / step;  // per residue; the first `longer` residues have one more
  const int longer = height % step;
  const int of_longer = longer * (rows + 1);
  if (i < of_longer) {
    return i / (rows + 1) + i % (rows + 1) * step;
  }
  return longer + (i - of_longer) / rows + (i - of_longer) % rows * step;
}

}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

struct Sums {
  VF luminance, red, blue, variance, weight;
};

/// Writes the filtered pixels of one signal.
HWY_INLINE void Finish(const SignalRow& row, const OutputRow& out, const Sums& sums, MF surface,
                       int x, int width) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const MF filled = hn::And(hn::Gt(sums.weight, hn::Set(d, kMinAtrousWeight)), surface);
  const VF scale = hn::Div(one, hn::IfThenElse(filled, sums.weight, one));
  const VF scale2 = hn::Mul(scale, scale);
  if (hn::AllTrue(d, filled) && out.valid_out == nullptr) {  // nearly everywhere
    StreamInRow(d, hn::Mul(sums.luminance, scale), out.value[0], x, width);
    StreamInRow(d, hn::Mul(sums.red, scale), out.value[1], x, width);
    StreamInRow(d, hn::Mul(sums.blue, scale), out.value[2], x, width);
    StreamInRow(d, hn::Mul(sums.variance, scale2), out.value[3], x, width);
    return;
  }
  const auto put = [&](int channel, VF sum, VF factor, const float* before) HWY_ATTR {
    StreamInRow(d, hn::IfThenElse(filled, hn::Mul(sum, factor), hn::LoadU(d, before + x)),
                out.value[channel], x, width);
  };
  put(0, sums.luminance, scale, row.luminance);
  put(1, sums.red, scale, row.red);
  put(2, sums.blue, scale, row.blue);
  put(3, sums.variance, scale2, row.variance);
  if (out.valid_out != nullptr) {
    StreamInRow(d, hn::IfThenElse(filled, one, hn::LoadU(d, row.valid + x)), out.valid_out, x,
                width);
  }
}

HWY_INLINE void AddTap(const SignalRow& s, ptrdiff_t q, VF weight, VF luminance, Sums* sums) {
  const DF d;
  sums->luminance = hn::MulAdd(weight, luminance, sums->luminance);
  sums->red = hn::MulAdd(weight, hn::LoadU(d, s.red + q), sums->red);
  sums->blue = hn::MulAdd(weight, hn::LoadU(d, s.blue + q), sums->blue);
  sums->variance =
      hn::MulAdd(hn::Mul(weight, weight), hn::LoadU(d, s.variance + q), sums->variance);
  sums->weight = hn::Add(sums->weight, weight);
}

/// The arguments common to the taps of all signals.
struct LightTaps {
  const TapPairs taps;
  const TapSlots exponents;  ///< a row of each tap
  float centre_kernel;
  float least_factor;  ///< lower bound of the shared factor, relative to the pixel's own
};

/// Sums the taps of one signal at the pixels x, x + 1, ... with the weights of SVGF. kShared:
/// SharedLuminanceFactor of both pixels. kPilot: compares the pilot's luminances.
template <int kPairs, bool kShared, bool kComplete, bool kPilot>
HWY_INLINE Sums SumTaps(const LightTaps& light, const SignalRow& row, VF own_factor, int x) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF centre = hn::LoadU(d, row.luminance + x);
  VF compared = centre;
  if constexpr (kPilot) {
    compared = hn::LoadU(d, row.pilot + x);
    compared = kComplete ? compared : WherePresent(row, x, compared);
  }
  const VF least = hn::Mul(own_factor, hn::Set(d, light.least_factor));
  const VF kernel = hn::Set(d, light.centre_kernel);
  Sums sums = {zero, zero, zero, zero, zero};
  AddTap(row, x, kComplete ? kernel : WherePresent(row, x, kernel), centre, &sums);
  // Two interleaved taps at a time: the dependency chain of one is longer than the out-of-order
  // window.
  ForEachPair<kPairs>(
      light.taps, [&](int i) HWY_ATTR __attribute__((always_inline)) {
        const ptrdiff_t distance = light.taps.pair[i].distance;
        const ptrdiff_t q[2] = {x + distance, x - distance};
        const VF l[2] = {InRegister(hn::LoadU(d, row.luminance + q[0])),
                         InRegister(hn::LoadU(d, row.luminance + q[1]))};
        const float* exponents = light.exponents.first + 2 * i * light.exponents.stride + x;
        VF exponent[2] = {hn::Load(d, exponents), hn::Load(d, exponents + light.exponents.stride)};
        VF factor[2] = {own_factor, own_factor};
        if constexpr (kShared) {
          for (int k = 0; k < 2; ++k) {
            factor[k] =
                hn::Min(own_factor, hn::Max(hn::LoadU(d, row.luminance_factor + q[k]), least));
          }
        }
        VF tap[2] = {l[0], l[1]};
        if constexpr (kPilot) {
          tap[0] = hn::LoadU(d, row.pilot + q[0]);
          tap[1] = hn::LoadU(d, row.pilot + q[1]);
        }
        const VF deviation[2] = {hn::Abs(hn::Sub(compared, tap[0])),
                                 hn::Abs(hn::Sub(compared, tap[1]))};
        exponent[0] = hn::NegMulAdd(deviation[0], factor[0], exponent[0]);
        exponent[1] = hn::NegMulAdd(deviation[1], factor[1], exponent[1]);
        VF weight[2];
        WeightsExp2<true>(exponent, weight);
        if constexpr (!kComplete) {
          weight[0] = WherePresent(row, q[0], weight[0]);
          weight[1] = WherePresent(row, q[1], weight[1]);
        }
        AddTap(row, q[0], weight[0], l[0], &sums);
        AddTap(row, q[1], weight[1], l[1], &sums);
      });
  return sums;
}

/// Filters a row of one signal with the weights of SVGF. Not inlined, and with arguments by value,
/// since compilers reload after every store all data that it may alias.
template <int kPairs, bool kShared, bool kComplete, bool kPilot>
HWY_NOINLINE void FilterSignalRow(const AtrousPass& pass, const AtrousSignal& signal, int y,
                                  TapSlots exponents) {
  const DF d;
  const VF zero = hn::Zero(d);
  const LightTaps light = {pass.taps, exponents, pass.centre_kernel,
                           1 / pass.parameters->noise_ratio};
  const GuidePlanes& g = *pass.guides;
  const float* depth =
      (pass.parameters->edges.depth_weight_plane != 0 ? g.inverse_depth : g.depth).Row(y);
  const SignalRow row = RowOf(signal, y);
  const OutputRow out = OutputOf(signal, y);
  const NextSignal next = NextSignalOf(pass, signal, false, y);
  const int width = g.id.width();
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    const MF surface = hn::Gt(hn::LoadU(d, depth + x), zero);
    const Sums sums = hn::AllFalse(d, surface)
                          ? Sums{zero, zero, zero, zero, zero}
                          : SumTaps<kPairs, kShared, kComplete, kPilot>(
                                light, row, hn::LoadU(d, row.luminance_factor + x), x);
    Finish(row, out, sums, surface, x, width);
  }
}

/// Selects the template arguments, which replace branches in the innermost loop.
template <int kPairs>
void FilterSignalRow(const AtrousPass& pass, const AtrousSignal& signal, int y,
                     TapSlots exponents) {
  const bool shared = pass.parameters->noise_ratio > 1;
  if (signal.pilot != nullptr) {  // kShared with a ratio of 1 gives equal results
    signal.all_valid ? FilterSignalRow<kPairs, true, true, true>(pass, signal, y, exponents)
                     : FilterSignalRow<kPairs, true, false, true>(pass, signal, y, exponents);
  } else if (signal.all_valid) {
    shared ? FilterSignalRow<kPairs, true, true, false>(pass, signal, y, exponents)
           : FilterSignalRow<kPairs, false, true, false>(pass, signal, y, exponents);
  } else {
    shared ? FilterSignalRow<kPairs, true, false, false>(pass, signal, y, exponents)
           : FilterSignalRow<kPairs, false, false, false>(pass, signal, y, exponents);
  }
}

/// The weights for comparison: the kernel alone, and the Gaussians of EAW.
/// \tparam kDepths  depth weight of EAW: kPosition, or kPlane for all others
template <bool kEaw, Depths kDepths>
void FilterRowForComparison(const AtrousPass& pass, const AtrousSignal& signal, int y) {
  const DF d;
  const DU du;
  const AtrousParameters& p = *pass.parameters;
  const GuidePlanes& g = *pass.guides;
  const GuideRow guide = GuideRowOf(g, pass.normals, p.edges, y);
  const float* inverse_depth = g.inverse_depth.Row(y);
  const SignalRow row = RowOf(signal, y);
  const int width = g.id.width();
  for (int x = 0; x < width; x += LaneCount()) {
    const GuideCentre c = LoadGuideCentre(guide, p.edges, x);
    const VU id = hn::LoadU(du, guide.id + x);
    const VF luminance = hn::LoadU(d, row.luminance + x);
    const VF eaw_l = WherePresent(row, x, hn::Set(d, row.eaw_l));
    const VF eaw_n = hn::Set(d, kLog2E / (p.eaw_sigma_n * p.eaw_sigma_n));
    const VF eaw_z =
        hn::Mul(hn::Mul(c.z, c.z), hn::Set(d, kLog2E / (p.eaw_sigma_z * p.eaw_sigma_z)));
    [[maybe_unused]] PositionCentre position;
    if constexpr (kDepths == Depths::kPosition) {
      position = LoadPositionCentre(c, p.edges, x, y);
    }
    const VF zero = hn::Zero(d);
    Sums sums = {zero, zero, zero, zero, zero};
    AddTap(row, x, WherePresent(row, x, hn::Set(d, pass.centre_kernel)), luminance, &sums);
    const auto add_tap = [&](ptrdiff_t distance, ptrdiff_t normal_distance, float dx, float dy,
                             float log2_kernel) HWY_ATTR __attribute__((always_inline)) {
      const ptrdiff_t q = x + distance;
      [[maybe_unused]] const ptrdiff_t normal_q = x + normal_distance;
      const VF l = hn::LoadU(d, row.luminance + q);
      VF exponent = hn::Set(d, log2_kernel);
      if constexpr (kEaw) {
        const VF ex = hn::Sub(c.nx, hn::LoadU(d, guide.nx + normal_q));
        const VF ey = hn::Sub(c.ny, hn::LoadU(d, guide.ny + normal_q));
        const VF ez = hn::Sub(c.nz, hn::LoadU(d, guide.nz + normal_q));
        const VF n2 = hn::MulAdd(ex, ex, hn::MulAdd(ey, ey, hn::Mul(ez, ez)));
        const VF dl = hn::Sub(luminance, l);
        exponent = hn::NegMulAdd(hn::Mul(dl, dl), eaw_l, exponent);
        exponent = hn::NegMulAdd(n2, eaw_n, exponent);
        if constexpr (kDepths == Depths::kPosition) {
          const VF zq = hn::LoadU(d, guide.depth + q);
          exponent = hn::Sub(exponent, PositionExponent(position, zq, dx, dy));
        } else {
          const VF deviation = PlaneDeviation(c, hn::LoadU(d, inverse_depth + q), dx, dy);
          exponent = hn::NegMulAdd(hn::Mul(deviation, deviation), eaw_z, exponent);
        }
        if (p.wavelet_id != 0) {
          const MF same = hn::RebindMask(d, hn::Eq(id, hn::LoadU(du, guide.id + q)));
          exponent = hn::IfThenElse(same, exponent, hn::Set(d, -1000.0f));
        }
      }
      AddTap(row, q, WherePresent(row, q, WeightExp2(exponent)), l, &sums);
    };
    for (int i = 0; i < pass.taps.count; ++i) {
      const TapPair& pair = pass.taps.pair[i];
      add_tap(pair.distance, pair.normal_distance, pair.dx, pair.dy, pair.log2_kernel);
      add_tap(-pair.distance, -pair.normal_distance, -pair.dx, -pair.dy, pair.log2_kernel);
    }
    Finish(row, OutputOf(signal, y), sums, hn::Gt(c.i, zero), x, width);
  }
}

/// Filters one row of all signals with the weights of SVGF: the geometry exponents first, then
/// signal by signal, so that few planes are read at a time; specular signals last, since their
/// exponents overwrite the others.
template <int kPairs>
void FilterRow(const AtrousPass& pass, int y) {
  const RowScratch scratch(pass.guides->id.width(), 2 * kPairs);
  const TapSlots exponents = {scratch.Row(0), scratch.Row(1) - scratch.Row(0)};
  ExponentsOfRow<kPairs, OfGuides::kExponents>(pass, y, exponents);
  bool any_reflected = false;
  for (const AtrousSignal& signal : pass.signals) {
    any_reflected = any_reflected || signal.reflected;
    if (!signal.reflected) {
      FilterSignalRow<kPairs>(pass, signal, y, exponents);
    }
  }
  if (any_reflected && pass.parameters->edges.curvature > 0) {
    ReflectedExponentsOfRow<kPairs>(pass, y, exponents);
  }
  for (const AtrousSignal& signal : pass.signals) {
    if (signal.reflected) {
      FilterSignalRow<kPairs>(pass, signal, y, exponents);
    }
  }
}

void AtrousRow(const AtrousPass& pass, int y) {
  const bool by_position = pass.parameters->edges.depth_weight_position != 0;
  switch (pass.level->weights) {
    case kAtrousNaive:
      for (const AtrousSignal& signal : pass.signals) {
        FilterRowForComparison<false, Depths::kPlane>(pass, signal, y);
      }
      break;
    case kAtrousEaw:
      for (const AtrousSignal& signal : pass.signals) {
        by_position ? FilterRowForComparison<true, Depths::kPosition>(pass, signal, y)
                    : FilterRowForComparison<true, Depths::kPlane>(pass, signal, y);
      }
      break;
    case kAtrousGeometry:
      if (IsDense(pass)) {
        pass.level->radius == 1 ? FilterDenseRows<TapPairs::CountOf(1)>(pass, y)
                                : FilterDenseRows<TapPairs::CountOf(2)>(pass, y);
      } else {
        FilterRowByGeometry(pass, y);
      }
      break;
    case kAtrousSvgf:
      pass.level->radius == 1 ? FilterRow<TapPairs::CountOf(1)>(pass, y)
                              : FilterRow<TapPairs::CountOf(2)>(pass, y);
      break;
  }
}

/// Filters the rows begin..end in the order of RowInOrder.
void AtrousRows(const AtrousPass& pass, int begin, int end) {
  const TinyIsZero tiny_is_zero;
  const int height = pass.guides->id.height();
  NormalWindow window(*pass.guides, pass.level->step, pass.level->radius);
  AtrousPass of_row = pass;
  for (int i = begin; i < end; ++i) {
    const int y = RowInOrder(i, pass.level->step, height);
    of_row.normals = NormalsAround(*pass.guides, y, &window);
    AtrousRow(of_row, y);
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AtrousRows);

namespace {

AtrousPass MakePass(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
                    const AtrousLevel& level, const AtrousParameters& p) {
  constexpr float kLog2Kernel3[2] = {-1.0f, -2.0f};
  constexpr float kLog2Kernel5[3] = {-1.41503750f, -2.0f, -4.0f};
  const ptrdiff_t stride = guides.inverse_depth.stride();
  const ptrdiff_t normal_rows = NormalWindow::RowDistance(guides, level.step, level.radius);
  const bool small = level.radius == 1;
  AtrousPass pass;
  pass.signals = signals;
  pass.guides = &guides;
  pass.level = &level;
  pass.parameters = &p;
  pass.taps = small ? MakeTapPairs(kLog2Kernel3, level.step, stride, normal_rows)
                    : MakeTapPairs(kLog2Kernel5, level.step, stride, normal_rows);
  pass.centre_kernel = small ? 0.25f : 9.0f / 64.0f;
  if (level.box) {
    constexpr float kLog2OfOnes[3] = {};
    pass.taps = MakeTapPairs(std::span(kLog2OfOnes).first(static_cast<size_t>(level.radius) + 1),
                             level.step, stride, normal_rows);
    pass.centre_kernel = 1;
  }
  return pass;
}

void CheckSignals(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
                  const AtrousLevel& level) {
  const ptrdiff_t stride = guides.inverse_depth.stride();
  STILLRAY_CHECK_LE(signals.size(), kMostSignals);
  for (const AtrousSignal& signal : signals) {
    STILLRAY_CHECK_LE(ReachOf(level), signal.valid->border());
    STILLRAY_CHECK_EQ(signal.variance->stride(), stride);
    STILLRAY_CHECK_EQ(signal.valid->stride(), stride);
    if (level.weights == kAtrousSvgf) {
      STILLRAY_CHECK_EQ(signal.luminance_factor->stride(), stride);
    }
  }
}

}  // namespace

void Atrous(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
            const AtrousLevel& level, const AtrousParameters& p) {
  CheckSignals(signals, guides, level);
  const AtrousPass pass = MakePass(signals, guides, level, p);
  ParallelRows(guides.id.height(), 8, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(AtrousRows)(pass, begin, end);
  });
}

}  // namespace stillray::cpu
#endif
