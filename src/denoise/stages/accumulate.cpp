// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/accumulate.h"

#include "core/parallel.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/accumulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE VF NewFrameWeight(VF length, VF n, float alpha_min, bool constant_weight) {
  const DF d;
  const VF share = hn::Div(n, hn::Max(hn::Add(length, n), hn::Set(d, 1e-6f)));
  const VF least = hn::Set(d, alpha_min);
  const VF alpha = hn::Min(constant_weight ? least : hn::Max(least, share), hn::Set(d, 1.0f));
  const VF with_history = hn::IfThenElse(hn::Gt(length, hn::Zero(d)), alpha, hn::Set(d, 1.0f));
  return hn::IfThenElseZero(hn::Gt(n, hn::Zero(d)), with_history);
}

void AccumulateRows(const NewLight& light, const SignalHistory& before,
                    const ReprojectionTaps* taps, const Image1* limit,
                    const AccumulateParameters& p, int y0, int y1, SignalHistory* out) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const int width = light.samples.width();
  for (int y = y0; y < y1; ++y) {
    NextRow<48> next;
    const bool sparse = IsSparseRow(light.samples.Row(y), width);
    if (!sparse) {
      next.Add(light.colour, y + 1);
    }
    next.Add(light.samples, y + 1);
    const auto add_history = [&](const SignalHistory& history, int row) {
      next.Add(history.colour, row);
      next.Add(history.behind, row);
      for (const Image1* plane : {&history.mean, &history.variance, &history.length,
                                  &history.weights2, &history.compressed}) {
        next.Add(*plane, row);
      }
    };
    add_history(before, taps != nullptr ? taps->y(width / 2, y) + 2 : y + 1);
    add_history(*out, y + 1);
    if (taps != nullptr) {
      next.Add(taps->x, y + 1);
      next.Add(taps->y, y + 1);
      next.Add(taps->weight, y + 1);
      next.Add(taps->search, y + 1);
    }
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const FetchTaps found = taps != nullptr ? LoadTaps(before, *taps, x, y) : FetchTaps();
      const auto old_of = [&](const Image1& plane) HWY_ATTR {
        return taps != nullptr ? FetchPlane(plane, before, found) : hn::LoadU(d, plane.Row(y) + x);
      };
      const VF n = hn::LoadU(d, light.samples.Row(y) + x);
      const VF old_length = old_of(before.length);
      VF length = old_length;
      if (limit != nullptr) {
        length = hn::Min(length, hn::LoadU(d, limit->Row(y) + x));
      }
      if (p.max_history > 0) {
        length = hn::Min(length, hn::Max(hn::Sub(hn::Set(d, static_cast<float>(p.max_history)), n),
                                         hn::Zero(d)));
      }
      const VF alpha = NewFrameWeight(length, n, p.alpha_min, p.constant_weight);
      const VF alpha_moments = NewFrameWeight(length, n, p.alpha_moments, p.constant_weight);
      const bool nothing_new = sparse && NoSamples(light.samples, x, y);
      VF colour[3];
      for (int c = 0; c < 3; ++c) {
        colour[c] = nothing_new ? hn::Zero(d) : hn::LoadU(d, light.colour[c].Row(y) + x);
        const VF old = old_of(before.colour[c]);
        StoreInRow(d, hn::MulAdd(alpha, hn::Sub(colour[c], old), old), out->colour[c].Row(y), x,
                   width);
        if (!before.behind.empty()) {
          const VF behind = old_of(before.behind[c]);
          StoreInRow(d, hn::MulAdd(alpha, hn::Sub(colour[c], behind), behind),
                     out->behind[c].Row(y), x, width);
        }
      }
      const VF mean = old_of(before.mean);
      const VF variance = old_of(before.variance);
      const VF weights2 = old_of(before.weights2);
      const VF l = colour[0];
      if (p.compressed_scale > 0) {
        const VF old = old_of(before.compressed);
        const VF light_l = hn::Max(l, hn::Zero(d));
        const VF c = hn::Div(light_l, hn::Add(light_l, hn::Set(d, p.compressed_scale)));
        StoreInRow(d, hn::MulAdd(alpha, hn::Sub(c, old), old), out->compressed.Row(y), x, width);
      }
      const VF difference = hn::Sub(l, mean);
      const VF keep = hn::Sub(one, alpha_moments);
      VF mixed =
          hn::Mul(keep, hn::MulAdd(hn::Mul(alpha_moments, difference), difference, variance));
      if (!light.within.empty()) {
        mixed = hn::MulAdd(alpha_moments, hn::LoadU(d, light.within.Row(y) + x), mixed);
      }
      const VF keep_light = hn::Sub(one, alpha);
      const MF arrived = hn::Gt(n, hn::Zero(d));
      const VF added = hn::Div(hn::Mul(alpha, alpha), hn::IfThenElse(arrived, n, one));
      const VF new_weights2 = hn::MulAdd(hn::Mul(keep_light, keep_light), weights2, added);
      StoreInRow(d, mixed, out->variance.Row(y), x, width);
      StoreInRow(d, hn::MulAdd(alpha_moments, difference, mean), out->mean.Row(y), x, width);
      StoreInRow(d, hn::IfThenElse(arrived, new_weights2, weights2), out->weights2.Row(y), x,
                 width);
      StoreInRow(d, hn::IfThenElse(arrived, hn::Add(length, n), old_length), out->length.Row(y), x,
                 width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(AccumulateRows);

void Accumulate(const NewLight& light, const SignalHistory& before, const ReprojectionTaps* taps,
                const Image1* limit, const AccumulateParameters& p, SignalHistory* out) {
  ParallelRows(light.samples.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AccumulateRows)(light, before, taps, limit, p, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
