// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history.h"

#include <initializer_list>

#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/limit_history_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/limit_history.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// See CompressedVariance. \param c  the compressed mean
HWY_INLINE VF SampleVariance(VF c, VF mean, VF variance, VF scale) {
  const DF d;
  const VF s = hn::Add(hn::Max(mean, hn::Zero(d)), scale);
  const VF slope = hn::Div(hn::Div(scale, s), s);
  return hn::Min(hn::Mul(hn::Mul(slope, variance), slope),
                 hn::Mul(c, hn::Sub(hn::Set(d, 1.0f), c)));
}

/// The history and taps that the next row reads.
template <size_t kMost>
void AddHistory(std::initializer_list<const Image1*> planes, const ReprojectionTaps& taps, int y,
                NextRow<kMost>* next) {
  const int row = RowOfTaps(taps, taps.x.width() / 2, y) + 2;
  for (const Image1* plane : planes) {
    next->Add(*plane, row);
  }
  AddTaps(taps, y + 1, next);
}

void CompareWithHistoryRows(const NewLight& light, const SignalHistory& before,
                            const ReprojectionTaps& taps, const GuidePlanes& guides, int y0, int y1,
                            FilterPlanes* compared, Image1* valid) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF scale = hn::Set(d, before.compressed_scale);
  const VF one = hn::Set(d, 1.0f);
  const int width = light.samples.width();
  for (int y = y0; y < y1; ++y) {
    const bool sparse = IsSparseRow(light.samples.Row(y), width);
    NextRow<24> next;
    for (const Image1* plane : {&light.samples, &light.colour[0], &guides.inverse_depth}) {
      next.Add(*plane, y + 1);
    }
    for (const Image1* plane :
         {static_cast<const Image1*>(valid), static_cast<const Image1*>(&compared->variance),
          static_cast<const Image1*>(&compared->colour[0]),
          static_cast<const Image1*>(&compared->colour[1])}) {
      AddStreamed(*plane, y + 1, &next);
    }
    if (!sparse) {
      AddHistory(
          {&before.length, &before.mean, &before.variance, &before.compressed, &before.weights2},
          taps, y, &next);
    }
    for (int x = 0; x < width; x += LaneCount()) {
      if (!sparse || (y + 1 < y1 && !NoSamples(light.samples, x, y + 1))) {
        next.Fetch(x);
      }
      if (sparse && NoSamples(light.samples, x, y)) {
        StreamInRow(d, zero, valid->Row(y), x, width);
        continue;
      }
      VF length, mean, variance, then, weights2;
      WithHistory(
          before, taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
            length = old_of.Length();
            mean = old_of(before.mean);
            variance = old_of(before.variance);
            then = old_of(before.compressed);
            weights2 = old_of(before.weights2);
          });
      const VF n = hn::LoadU(d, light.samples.Row(y) + x);
      const MF both = hn::And(hn::Gt(hn::LoadU(d, guides.inverse_depth.Row(y) + x), zero),
                              hn::And(hn::Gt(n, zero), hn::Gt(length, zero)));
      const VF l = hn::Max(hn::LoadU(d, light.colour[0].Row(y) + x), zero);
      const VF now = hn::Div(l, hn::Add(l, scale));
      const VF single = SampleVariance(then, mean, variance, scale);
      const VF noise = hn::Mul(single, hn::Add(hn::Div(one, hn::Max(n, one)), weights2));
      StreamInRow(d, hn::IfThenElseZero(both, one), valid->Row(y), x, width);
      StreamInRow(d, hn::Sub(now, then), compared->colour[0].Row(y), x, width);
      StreamInRow(d, single, compared->colour[1].Row(y), x, width);
      StreamInRow(d, noise, compared->variance.Row(y), x, width);
    }
  }
  FinishStreams();
}

void LimitHistoryRows(const FilterPlanes& blurred, const Image1& valid, const SignalHistory& before,
                      const ReprojectionTaps& taps, const LimitHistoryParameters& p, int y0, int y1,
                      Image1* limit) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = limit->width();
  for (int y = y0; y < y1; ++y) {
    NextRow<20> next;
    for (const Image1* plane :
         {&blurred.colour[0], &blurred.colour[1], &blurred.variance, &valid}) {
      next.Add(*plane, y + 1);
    }
    AddStreamed(*limit, y + 1, &next);
    AddHistory({&before.length, &before.weights2}, taps, y, &next);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      VF length, weights2;
      WithHistory(
          before, taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
            length = old_of.Length();
            weights2 = old_of(before.weights2);
          });
      const VF difference = hn::LoadU(d, blurred.colour[0].Row(y) + x);
      const VF noise = hn::LoadU(d, blurred.variance.Row(y) + x);
      const VF square = hn::Mul(difference, difference);
      const VF bias2 = hn::Max(zero, hn::NegMulAdd(hn::Set(d, 1.0f + p.limit_dead), noise, square));
      const VF own = hn::Max(hn::LoadU(d, blurred.colour[1].Row(y) + x), hn::Set(d, 1e-8f));
      const VF distrust = hn::MulAdd(hn::Set(d, p.limit_gain), hn::Div(bias2, own), weights2);
      const VF limited = hn::Div(hn::Set(d, 1.0f), hn::Max(distrust, hn::Set(d, 1e-6f)));
      const MF biased = hn::And(hn::Gt(bias2, zero), hn::Gt(hn::LoadU(d, valid.Row(y) + x), zero));
      StreamInRow(d, hn::IfThenElse(biased, hn::Min(length, limited), length), limit->Row(y), x,
                  width);
    }
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {

void RescaleHistory(float scale, SignalHistory* history) {
  ParallelRows(history->compressed.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* c = history->compressed.Row(y);
      for (int x = 0; x < history->compressed.width(); ++x) {
        c[x] = RescaleCompressed(c[x], history->compressed_scale, scale);
      }
    }
  });
  history->compressed_scale = scale;
}

namespace cpu {

HWY_EXPORT(CompareWithHistoryRows);
HWY_EXPORT(LimitHistoryRows);

void CompareWithHistory(const NewLight& light, const SignalHistory& before,
                        const ReprojectionTaps& taps, const GuidePlanes& guides,
                        FilterPlanes* compared, Image1* valid) {
  ParallelRows(valid->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(CompareWithHistoryRows)
    (light, before, taps, guides, y0, y1, compared, valid);
  });
}

void LimitHistory(const FilterPlanes& blurred, const Image1& valid, const SignalHistory& before,
                  const ReprojectionTaps& taps, const LimitHistoryParameters& p, Image1* limit) {
  ParallelRows(limit->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(LimitHistoryRows)(blurred, valid, before, taps, p, y0, y1, limit);
  });
}

}  // namespace cpu
}  // namespace stillray
#endif
