// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/merge_future.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/merge_future.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void MergeFutureRows(const SignalHistory& history, const SignalHistory& future, int y0, int y1,
                     SignalHistory* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = history.length.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF length = hn::LoadU(d, history.length.Row(y) + x);
      const VF weights2 = hn::LoadU(d, history.weights2.Row(y) + x);
      const VF future_length = hn::LoadU(d, future.length.Row(y) + x);
      const VF future_weights2 = hn::LoadU(d, future.weights2.Row(y) + x);
      const VF sum = hn::Max(hn::Add(weights2, future_weights2), hn::Set(d, 1e-12f));
      VF share = hn::IfThenElse(hn::Gt(length, zero), hn::Div(weights2, sum), one);
      share = hn::IfThenElseZero(hn::Gt(future_length, zero), share);
      const VF keep = hn::Sub(one, share);
      for (int c = 0; c < 3; ++c) {
        const VF past = hn::LoadU(d, history.colour[c].Row(y) + x);
        const VF later = hn::LoadU(d, future.colour[c].Row(y) + x);
        StoreInRow(d, hn::MulAdd(share, hn::Sub(later, past), past), out->colour[c].Row(y), x,
                   width);
      }
      const VF mean = hn::LoadU(d, history.mean.Row(y) + x);
      const VF difference = hn::Sub(hn::LoadU(d, future.mean.Row(y) + x), mean);
      const VF variance = hn::LoadU(d, history.variance.Row(y) + x);
      const VF mixed = hn::Mul(keep, hn::MulAdd(hn::Mul(share, difference), difference, variance));
      const VF all = hn::MulAdd(share, hn::LoadU(d, future.variance.Row(y) + x), mixed);
      StoreInRow(d, all, out->variance.Row(y), x, width);
      StoreInRow(d, hn::MulAdd(share, difference, mean), out->mean.Row(y), x, width);
      StoreInRow(d, hn::Add(length, future_length), out->length.Row(y), x, width);
      StoreInRow(d,
                 hn::MulAdd(hn::Mul(keep, keep), weights2,
                            hn::Mul(hn::Mul(share, share), future_weights2)),
                 out->weights2.Row(y), x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(MergeFutureRows);

void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out) {
  ParallelRows(history.length.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MergeFutureRows)(history, future, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
