// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// One exponent of 2 per tap: kernel, normal, depth and luminance add up before a single
// exponential; the guides' part of it is worked out once for all signals. Taps come in pairs at
// opposite offsets, which share the slope's tolerance. All planes have one stride, so that a tap is
// one distance in memory for all of them; normals in the border are zero, which makes every weight
// there zero without a test.
#include "denoise/stages/atrous.h"

#include <algorithm>
#include <array>
#include <span>

#include <tbb/task_arena.h>

#include "core/cache_size.h"
#include "core/check.h"
#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/level_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/atrous.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/edge_stopping-inl.h"
#include "denoise/simd/guide_exponents-inl.h"
#include "denoise/simd/level_rows-inl.h"
#include "denoise/simd/luminance_stop-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_ATROUS_ONCE
#define STILLRAY_ATROUS_ONCE
namespace stillray {

/// The i-th row in an order in which the rows of one residue modulo `step` follow each other, so
/// that a level's taps are found in the cache.
inline int RowInOrder(int i, int step, int height) {
  const int rows = height / step;  // of each residue, and one more of the first `longer`
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

/// The weight where there is light, else 0.
HWY_INLINE VF WherePresent(const SignalRow& s, ptrdiff_t q, VF weight) {
  const DF d;
  return hn::IfThenElseZero(hn::Gt(hn::LoadU(d, s.present + q), hn::Zero(d)), weight);
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

/// What the taps of all signals have in common.
struct LightTaps {
  const TapPairs taps;
  const TapDistances distances;
  const TapSlots exponents;  ///< a row of each tap
  float centre_kernel;
  float least_stop;  ///< of the pixel's own, that a noisier neighbour may lower it to
};

/// Adds up the taps of one signal at the pixels x, x + 1, ... with the weights of SVGF. kShared:
/// stops are shared with noisier neighbours.
template <int kPairs, bool kShared, bool kComplete>
HWY_INLINE Sums SumTaps(const LightTaps& light, const SignalRow& row, VF stop, int x) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF centre = hn::LoadU(d, row.luminance + x);
  const VF least = hn::Mul(stop, hn::Set(d, light.least_stop));
  const VF kernel = hn::Set(d, light.centre_kernel);
  Sums sums = {zero, zero, zero, zero, zero};
  AddTap(row, x, kComplete ? kernel : WherePresent(row, x, kernel), centre, &sums);
  // Two taps at a time, step by step: one alone is a longer chain than cores look ahead for others.
  ForEachPair<kPairs>(
      light.taps, [&](int i) HWY_ATTR __attribute__((always_inline)) {
        const ptrdiff_t q[2] = {x + light.distances.to[2 * i], x + light.distances.to[2 * i + 1]};
        const VF l[2] = {InRegister(hn::LoadU(d, row.luminance + q[0])),
                         InRegister(hn::LoadU(d, row.luminance + q[1]))};
        const float* exponents = light.exponents.first + 2 * i * light.exponents.stride + x;
        VF exponent[2] = {hn::Load(d, exponents), hn::Load(d, exponents + light.exponents.stride)};
        VF factor[2] = {stop, stop};
        if constexpr (kShared) {
          for (int k = 0; k < 2; ++k) {
            factor[k] = hn::Min(stop, hn::Max(hn::LoadU(d, row.stop + q[k]), least));
          }
        }
        const VF deviation[2] = {hn::Abs(hn::Sub(centre, l[0])), hn::Abs(hn::Sub(centre, l[1]))};
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

/// Works out what the guides say about the taps of a row.
template <int kPairs, bool kParabola, Depths kDepths, bool kTestId>
void ExponentsOfRow(const AtrousLevel& level, int y, TapSlots to) {
  const DF d;
  // Copies, which nothing that is stored in the loop could change.
  const EdgeStopping edges = level.parameters->edges;
  const TapPairs taps = WithBias(level.taps, edges);
  const GuideRow guide = GuideRowOf<kDepths>(*level.guides, edges, y);
  const bool test_id = kTestId && level.parameters->test_id;
  const int width = level.guides->id.width();
  const NextGuides next = NextGuidesOf(level, false, y);
  for (int x = 0; x < width; x += LaneCount(), to.first += LaneCount()) {
    next.Fetch(x);
    if (!hn::AllFalse(d, hn::Gt(hn::LoadU(d, guide.depth + x), hn::Zero(d)))) {
      const GuideCentre c = LoadGuideCentre<kDepths>(guide, edges, x);
      GuideExponents<kParabola, kDepths, kPairs>(taps, edges, test_id, guide, c, x, to);
    }
  }
}

/// What the stops of a row are made from.
VarianceRows VarianceRowsOf(const AtrousLevel& level, const LevelRows& rows, int y) {
  const AtrousSignal& s = *rows.signal;
  const PlaneRows<const float>& variance = rows.in[3];
  return {rows.in[0].Row(y),
          s.length->Row(y),
          {{variance.Row(y - 1), variance.Row(y), variance.Row(y + 1)}},
          ThreeRowsOf(*s.present, y),
          s.complete ? ThreeRowsOf(level.guides->full, y) : ThreeRows<uint32_t>()};
}

/// Filters a row of one signal with the weights of SVGF. Not inlined, and with arguments of its
/// own, since compilers read again after every store what that could have changed.
///
/// \param stop_of  takes a column: the stops of the pixels from there on
template <int kPairs, bool kShared, bool kComplete, typename StopOf>
HWY_NOINLINE void FilterSignalRow(const AtrousLevel& level, const LevelRows& signal, int y,
                                  TapSlots exponents, const StopOf stop_of) {
  const DF d;
  const VF zero = hn::Zero(d);
  const LightTaps light = {level.taps, DistancesOf(level, signal.in[0], y), exponents,
                           level.centre_kernel, 1 / level.parameters->noise_ratio};
  const GuidePlanes& g = *level.guides;
  const float* depth = (level.parameters->edges.plane ? g.inverse_depth : g.depth).Row(y);
  const SignalRow row = RowOf(signal, y);
  const OutputRow out = OutputOf(level, signal, y);
  const NextSignal next = NextSignalOf(level, signal, false, y);
  const int width = g.id.width();
  VF stop = stop_of(0);
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    // A root and a division on their way while the taps of this vector are added up.
    const VF next_stop = stop_of(std::min(x + LaneCount(), width - 1));
    const MF surface = hn::Gt(hn::LoadU(d, depth + x), zero);
    const Sums sums = hn::AllFalse(d, surface)
                          ? Sums{zero, zero, zero, zero, zero}
                          : SumTaps<kPairs, kShared, kComplete>(light, row, stop, x);
    Finish(row, out, sums, surface, x, width);
    stop = next_stop;
  }
}

/// Filters a row of one signal; makes the stops where it has none.
template <int kPairs, bool kComplete>
void FilterSignalRow(const AtrousLevel& level, const LevelRows& rows, int y, TapSlots exponents,
                     const StopScratch& scratch) {
  const float* const stops = RowOf(rows, y).stop;
  if (stops != nullptr) {
    FilterSignalRow<kPairs, true, kComplete>(
        level, rows, y, exponents, [stops](int x) HWY_ATTR { return hn::LoadU(DF(), stops + x); });
    return;
  }
  const StopSource source(VarianceRowsOf(level, rows, y), level.parameters->prefilter,
                          level.guides->id.width(), scratch);
  FilterSignalRow<kPairs, false, kComplete>(level, rows, y, exponents,
                                            [source](int x) HWY_ATTR { return source.Stop(x); });
}

/// Whether any signal has light at the pixels x, x + 1, ... of a row, which may lie in the border.
HWY_INLINE bool AnyPresent(const AtrousLevel& level, int y, int x) {
  const DF d;
  VF present = hn::Zero(d);
  for (const LevelRows& rows : level.signals) {
    present = hn::Max(present, hn::LoadU(d, rows.signal->present->Row(y) + x));
  }
  return !hn::AllFalse(d,
                       hn::And(hn::Gt(present, hn::Zero(d)), InRow(x, level.guides->id.width())));
}

struct GeometrySums {
  VF luminance, red, variance, weight;
};

/// What is not present may be anything, even no number.
HWY_INLINE void AddGeometryTap(const SignalRow& s, ptrdiff_t q, VF weight, GeometrySums* sums) {
  const DF d;
  const MF there = hn::Gt(hn::LoadU(d, s.present + q), hn::Zero(d));
  const auto value = [&](const float* row)
                         HWY_ATTR { return hn::IfThenElseZero(there, hn::LoadU(d, row + q)); };
  sums->luminance = hn::MulAdd(weight, value(s.luminance), sums->luminance);
  sums->red = hn::MulAdd(weight, value(s.red), sums->red);
  sums->variance = hn::MulAdd(hn::Mul(weight, weight), value(s.variance), sums->variance);
  sums->weight = hn::Add(sums->weight, hn::IfThenElseZero(there, weight));
}

HWY_INLINE GeometrySums SumGeometryTaps(const TapPairs& taps, float centre_kernel,
                                        const SignalRow& row, const TapVectors& weights, int x) {
  const DF d;
  const VF zero = hn::Zero(d);
  GeometrySums sums = {zero, zero, zero, zero};
  AddGeometryTap(row, x, hn::Set(d, centre_kernel), &sums);
  for (int i = 0; i < taps.count; ++i) {
    const ptrdiff_t distance = taps.pair[i].distance;
    AddGeometryTap(row, x + distance, hn::Load(d, weights[2 * i]), &sums);
    AddGeometryTap(row, x - distance, hn::Load(d, weights[2 * i + 1]), &sums);
  }
  return sums;
}

/// Filters one row of all signals with the weights of geometry, which they share, where there is
/// light (and beside it, in the same vector).
template <bool kParabola, Depths kDepths>
void FilterRowByGeometry(const AtrousLevel& level, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const EdgeStopping edges = level.parameters->edges;
  const TapPairs taps = WithBias(level.taps, edges);
  const GuideRow guide = GuideRowOf<kDepths>(*level.guides, edges, y);
  const int width = level.guides->id.width();
  SignalRow rows[kMostSignals];
  OutputRow outputs[kMostSignals];
  for (size_t i = 0; i < level.signals.size(); ++i) {
    rows[i] = RowOf(level.signals[i], y);
    outputs[i] = OutputOf(level, level.signals[i], y);
  }
  // Where samples are rare, nothing else has touched what they need.
  const bool sparse = IsSparseRow(rows[0].present, width);
  const NextGuides next_guides = NextGuidesOf(level, sparse, y);
  NextSignal next[kMostSignals];
  for (size_t i = 0; i < level.signals.size(); ++i) {
    next[i] = NextSignalOf(level, level.signals[i], sparse, y);
  }
  HWY_ALIGN TapVectors weights;
  for (int x = 0; x < width; x += LaneCount()) {
    if (!sparse || AnyPresent(level, y + level.parameters->step, x)) {
      next_guides.Fetch(x);
      for (size_t i = 0; i < level.signals.size(); ++i) {
        next[i].Fetch(x);
      }
    }
    if (!AnyPresent(level, y, x)) {
      continue;
    }
    const GuideCentre c = LoadGuideCentre<kDepths>(guide, edges, x);
    GuideExponents<kParabola, kDepths>(taps, edges, false, guide, c, x, SlotsOf(weights));
    WeightsOfExponents(taps, weights);
    for (size_t i = 0; i < level.signals.size(); ++i) {
      const GeometrySums sums = SumGeometryTaps(taps, level.centre_kernel, rows[i], weights, x);
      const VF scale = hn::Div(one, hn::IfThenElse(hn::Gt(sums.weight, zero), sums.weight, one));
      StreamInRow(d, hn::Mul(sums.luminance, scale), outputs[i].value[0], x, width);
      StreamInRow(d, hn::Mul(sums.red, scale), outputs[i].value[1], x, width);
      StreamInRow(d, hn::Mul(sums.variance, hn::Mul(scale, scale)), outputs[i].value[3], x, width);
    }
  }
}

/// The weights that are there for comparison: the kernel alone, and the Gaussians of EAW.
template <bool kEaw>
void FilterRowForComparison(const AtrousLevel& level, const LevelRows& signal, int y) {
  const DF d;
  const DU du;
  const AtrousParameters& p = *level.parameters;
  const GuidePlanes& g = *level.guides;
  const GuideRow guide = GuideRowOf(g, p.edges, y);
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
    const VF zero = hn::Zero(d);
    Sums sums = {zero, zero, zero, zero, zero};
    AddTap(row, x, WherePresent(row, x, hn::Set(d, level.centre_kernel)), luminance, &sums);
    const auto add_tap = [&](ptrdiff_t distance, float dx, float dy, float log2_kernel) HWY_ATTR
        __attribute__((always_inline)) {
      const ptrdiff_t q = x + distance;
      const VF l = hn::LoadU(d, row.luminance + q);
      VF exponent = hn::Set(d, log2_kernel);
      if constexpr (kEaw) {
        const VF ex = hn::Sub(c.nx, hn::LoadU(d, guide.nx + q));
        const VF ey = hn::Sub(c.ny, hn::LoadU(d, guide.ny + q));
        const VF ez = hn::Sub(c.nz, hn::LoadU(d, guide.nz + q));
        const VF n2 = hn::MulAdd(ex, ex, hn::MulAdd(ey, ey, hn::Mul(ez, ez)));
        const VF deviation = PlaneDeviation(c, hn::LoadU(d, inverse_depth + q), dx, dy);
        const VF dl = hn::Sub(luminance, l);
        exponent = hn::NegMulAdd(hn::Mul(dl, dl), eaw_l, exponent);
        exponent = hn::NegMulAdd(n2, eaw_n, exponent);
        exponent = hn::NegMulAdd(hn::Mul(deviation, deviation), eaw_z, exponent);
        if (p.test_id) {
          const MF same = hn::RebindMask(d, hn::Eq(id, hn::LoadU(du, guide.id + q)));
          exponent = hn::IfThenElse(same, exponent, hn::Set(d, -1000.0f));
        }
      }
      AddTap(row, q, WherePresent(row, q, WeightExp2(exponent)), l, &sums);
    };
    for (int i = 0; i < level.taps.count; ++i) {
      const TapPair& pair = level.taps.pair[i];
      add_tap(pair.distance, pair.dx, pair.dy, pair.log2_kernel);
      add_tap(-pair.distance, -pair.dx, -pair.dy, pair.log2_kernel);
    }
    Finish(row, OutputOf(level, signal, y), sums, hn::Gt(c.i, zero), x, width);
  }
}

/// Template arguments rather than branches in the innermost loop.
template <int kPairs>
void ExponentsOfRow(const AtrousLevel& level, int y, TapSlots to) {
  const AtrousParameters& p = *level.parameters;
  if (!UsesParabola(p.edges)) {
    ExponentsOfRow<kPairs, false, Depths::kEither, true>(level, y, to);
  } else if (p.test_id) {
    ExponentsOfRow<kPairs, true, Depths::kEither, true>(level, y, to);
  } else if (p.edges.plane) {
    ExponentsOfRow<kPairs, true, Depths::kPlane, false>(level, y, to);
  } else {
    ExponentsOfRow<kPairs, true, Depths::kGradient, false>(level, y, to);
  }
}

/// Filters one row of all signals with the weights of SVGF: the guides' part first, then signal by
/// signal, so that few planes are walked through at a time.
template <int kPairs>
void FilterRow(const AtrousLevel& level, int y) {
  const RowScratch scratch(level.guides->id.width(), 2 * kPairs + 2);
  const TapSlots exponents = {scratch.Row(0), scratch.Row(1) - scratch.Row(0)};
  ExponentsOfRow<kPairs>(level, y, exponents);
  const StopScratch of_stops = {scratch.Row(2 * kPairs), scratch.Row<uint32_t>(2 * kPairs + 1)};
  for (const LevelRows& rows : level.signals) {
    rows.signal->complete ? FilterSignalRow<kPairs, true>(level, rows, y, exponents, of_stops)
                          : FilterSignalRow<kPairs, false>(level, rows, y, exponents, of_stops);
  }
}

void AtrousRow(const AtrousLevel& level, int y) {
  const AtrousParameters& p = *level.parameters;
  switch (p.weights) {
    case AtrousWeights::kNaive:
      for (const LevelRows& signal : level.signals) {
        FilterRowForComparison<false>(level, signal, y);
      }
      break;
    case AtrousWeights::kEaw:
      for (const LevelRows& signal : level.signals) {
        FilterRowForComparison<true>(level, signal, y);
      }
      break;
    case AtrousWeights::kGeometry:
      !UsesParabola(p.edges) ? FilterRowByGeometry<false, Depths::kEither>(level, y)
      : p.edges.plane        ? FilterRowByGeometry<true, Depths::kPlane>(level, y)
                             : FilterRowByGeometry<true, Depths::kGradient>(level, y);
      break;
    case AtrousWeights::kSvgf:
      p.radius == 1 ? FilterRow<TapPairs::CountOf(1)>(level, y)
                    : FilterRow<TapPairs::CountOf(2)>(level, y);
      break;
  }
}

/// The rows begin..end in their order.
void AtrousRows(const AtrousLevel& level, int begin, int end) {
  const TinyIsZero tiny_is_zero;
  const int height = level.guides->id.height();
  for (int i = begin; i < end; ++i) {
    AtrousRow(level, RowInOrder(i, level.parameters->step, height));
  }
  FinishStreams();
}

/// The rows begin..end of a level that reads what another makes just before.
void AtrousRowsOfPair(const AtrousLevel& first, const AtrousLevel& second, int begin, int end) {
  const TinyIsZero tiny_is_zero;
  const int reach = ReachOf(*second.parameters);
  for (int y = begin - reach; y < end + reach; ++y) {
    if (y >= 0 && y < first.guides->id.height()) {
      AtrousRow(first, y);
    }
    if (y - reach >= begin) {
      AtrousRow(second, y - reach);
    }
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
HWY_EXPORT(AtrousRowsOfPair);

namespace {

/// A level without its signals.
AtrousLevel LevelOf(const GuidePlanes& guides, const AtrousParameters& p) {
  constexpr float kLog2Kernel3[2] = {-1.0f, -2.0f};
  constexpr float kLog2Kernel5[3] = {-1.41503750f, -2.0f, -4.0f};
  const ptrdiff_t stride = guides.inverse_depth.stride();
  const bool small = p.radius == 1;
  AtrousLevel level;
  level.guides = &guides;
  level.parameters = &p;
  level.taps = small ? MakeTapPairs(kLog2Kernel3, p.step, stride)
                     : MakeTapPairs(kLog2Kernel5, p.step, stride);
  level.centre_kernel = small ? 0.25f : 9.0f / 64.0f;
  level.advance = p.step;
  level.leads = true;
  return level;
}

void ReadPlanes(const AtrousSignal& signal, LevelRows* rows) {
  for (int c = 0; c < 3; ++c) {
    rows->in[c] = PlaneRows<const float>((*signal.colour)[c]);
  }
  rows->in[3] = PlaneRows<const float>(*signal.variance);
}

void WritePlanes(const AtrousSignal& signal, LevelRows* rows) {
  for (int c = 0; c < 3; ++c) {
    rows->out[c] = PlaneRows<float>(signal.out->colour[c]);
  }
  rows->out[3] = PlaneRows<float>(signal.out->variance);
}

void CheckSignals(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
                  const AtrousParameters& p) {
  const ptrdiff_t stride = guides.inverse_depth.stride();
  STILLRAY_CHECK_LE(signals.size(), kMostSignals);
  for (const AtrousSignal& signal : signals) {
    STILLRAY_CHECK_LE(ReachOf(p), signal.present->border());
    STILLRAY_CHECK_EQ(signal.variance->stride(), stride);
    STILLRAY_CHECK_EQ(signal.present->stride(), stride);
    if (signal.stop != nullptr) {
      STILLRAY_CHECK_EQ(signal.stop->stride(), stride);
    } else if (p.weights == AtrousWeights::kSvgf) {
      STILLRAY_CHECK_LE(p.noise_ratio, 1.0f);
      STILLRAY_CHECK(signal.length != nullptr);
    }
  }
}

/// Rows that a level reads at once of what the one before it makes.
int RingRows(const AtrousParameters& p) {
  return 2 * ReachOf(p) + 1;
}

/// The rows on both sides of a band, which its neighbours work out too, are at most so large a part
/// of it: 2 / kLeastBand.
constexpr int kLeastBand = 16;

/// Rows that one thread filters by both levels of a pair.
int BandOfPair(int height, const AtrousParameters& second) {
  const int pieces = 2 * tbb::this_task_arena::max_concurrency();
  return std::max((height + pieces - 1) / pieces, kLeastBand * ReachOf(second));
}

}  // namespace

void Atrous(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
            const AtrousParameters& p) {
  CheckSignals(signals, guides, p);
  std::array<LevelRows, kMostSignals> rows;
  for (size_t i = 0; i < signals.size(); ++i) {
    rows[i].signal = &signals[i];
    ReadPlanes(signals[i], &rows[i]);
    WritePlanes(signals[i], &rows[i]);
  }
  AtrousLevel level = LevelOf(guides, p);
  level.signals = {rows.data(), signals.size()};
  ParallelRows(guides.id.height(), 8, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(AtrousRows)(level, begin, end);
  });
}

void AtrousPair(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
                const AtrousParameters& first, const AtrousParameters& second) {
  CheckSignals(signals, guides, first);
  CheckSignals(signals, guides, second);
  const int height = guides.id.height();
  const int border = signals[0].present->border();
  ParallelRows(height, BandOfPair(height, second), [&](int begin, int end) {
    RowRings rings(guides.id.width(), border,
                   4 * RingRows(second) * static_cast<int>(signals.size()));
    std::array<LevelRows, kMostSignals> rows[2];
    for (size_t i = 0; i < signals.size(); ++i) {
      LevelRows& before = rows[0][i];
      LevelRows& after = rows[1][i];
      before.signal = after.signal = &signals[i];
      ReadPlanes(signals[i], &before);
      for (int c = 0; c < 4; ++c) {
        before.out[c] = rings.Add(RingRows(second));
        after.in[c] = before.out[c];
      }
      for (int c = 0; c < 3 && signals[i].kept != nullptr; ++c) {
        before.kept[c] = PlaneRows<float>((*signals[i].kept)[c]);
      }
      WritePlanes(signals[i], &after);
    }
    AtrousLevel levels[2] = {LevelOf(guides, first), LevelOf(guides, second)};
    for (int k = 0; k < 2; ++k) {
      levels[k].signals = {rows[k].data(), signals.size()};
      levels[k].advance = 1;
    }
    levels[0].kept_begin = begin;
    levels[0].kept_end = end;
    levels[1].leads = false;
    HWY_DYNAMIC_DISPATCH(AtrousRowsOfPair)(levels[0], levels[1], begin, end);
  });
}

bool PairPays(std::span<const AtrousSignal> signals, const GuidePlanes& guides,
              const AtrousParameters& first, const AtrousParameters& second) {
  const int threads = tbb::this_task_arena::max_concurrency();
  // Larger kernels wait for arithmetic, not for memory.
  if (second.radius > 1 || guides.id.height() < threads * kLeastBand * ReachOf(second)) {
    return false;
  }
  constexpr int kGuides = 6;  // normal, depth, gradient
  const int guide_rows = 2 * (ReachOf(first) + ReachOf(second)) + 1;
  const int values = kGuides * guide_rows + 4 * RingRows(second) * static_cast<int>(signals.size());
  return static_cast<size_t>(values) * sizeof(float) * static_cast<size_t>(guides.id.stride()) <=
         SecondCacheBytes();
}

}  // namespace stillray::cpu
#endif
