// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// What is remembered of a vector of pixels, looked up along their taps (stages/reproject.h).
#if defined(STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#undef STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#endif

#include <algorithm>

#include "denoise/planes.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Mean of the taps that the search chose, for one pixel; with `light_only` of those with light.
inline float FetchSearched(const Image1& plane, const Image1& length, const ReprojectionTaps& taps,
                           bool light_only, int x, int y) {
  const uint32_t search = taps.search(x, y);
  float sum = 0;
  int count = 0;
  for (int i = 0; i < 9; ++i) {
    const int qx = taps.x(x, y) + i % 3;
    const int qy = taps.y(x, y) + i / 3;
    if ((search >> i & 1u) != 0 && (!light_only || length(qx, qy) > 0)) {
      sum += plane(qx, qy);
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<float>(count) : 0.0f;
}

/// The weights without the taps that have no light, brought to their sum again.
HWY_INLINE void KeepTapsWithLight(const VF length[4], const VF weight[4], VF kept[4]) {
  const DF d;
  const VF zero = hn::Zero(d);
  VF sum = zero;
  VF lost = zero;
  for (int i = 0; i < 4; ++i) {
    kept[i] = hn::IfThenElseZero(hn::Gt(length[i], zero), weight[i]);
    sum = hn::Add(sum, kept[i]);
    lost = hn::Add(lost, hn::Sub(weight[i], kept[i]));
  }
  const VF one = hn::Set(d, 1.0f);
  const MF rescale = hn::And(hn::Gt(lost, zero), hn::Gt(sum, zero));
  const VF scale = hn::IfThenElse(rescale, hn::Div(one, hn::IfThenElse(rescale, sum, one)), one);
  for (int i = 0; i < 4; ++i) {
    kept[i] = hn::Mul(kept[i], scale);
  }
}

/// The 2x2 taps of a vector of pixels, and what each counts.
struct FetchTaps {
  TapLoad load[4];
  VF weight[4];
  VF kept[4];     ///< weights without the taps that have no light
  bool single;    ///< only the first tap has any weight: nothing moved
  bool searched;  ///< some pixels take the mean of those that the search chose
  const ReprojectionTaps* taps;
  int x, y;
};

/// Whether the planes of the taps say nothing about a vector of pixels.
HWY_INLINE bool KnownPlace(HistoryPlace place) {
  return place == HistoryPlace::kUnchanged || place == HistoryPlace::kNowhere;
}

/// The row in which the taps of a pixel begin.
HWY_INLINE int RowOfTaps(const ReprojectionTaps& taps, int x, int y) {
  return KnownPlace(taps.Place(x / LaneCount(), y)) ? y : taps.y(x, y);
}

/// The taps of pixels that are kUnchanged or kNowhere.
HWY_INLINE FetchTaps OwnTaps(const SignalHistory& before, const ReprojectionTaps& taps, int x,
                             int y) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d);
  const bool any = taps.Place(x / LaneCount(), y) == HistoryPlace::kUnchanged;
  FetchTaps t;
  t.load[0] = {true, y, x, ColumnNumbers(x), hn::Set(di, y)};
  t.weight[0] = hn::IfThenElseZero(InRow(x, taps.x.width()), hn::Set(d, any ? 1.0f : 0.0f));
  const MF has_light = hn::Gt(hn::LoadU(d, before.length.Row(y) + x), zero);
  t.kept[0] = hn::IfThenElseZero(has_light, t.weight[0]);
  for (int i = 1; i < 4; ++i) {
    t.load[i] = t.load[0];
    t.weight[i] = t.kept[i] = zero;
  }
  t.single = true;
  t.searched = false;
  t.taps = &taps;
  t.x = x;
  t.y = y;
  return t;
}

HWY_INLINE FetchTaps LoadTaps(const SignalHistory& before, const ReprojectionTaps& taps, int x,
                              int y) {
  if (KnownPlace(taps.Place(x / LaneCount(), y))) {
    return OwnTaps(before, taps, x, y);
  }
  const DF d;
  const DI di;
  const int width = taps.x.width();
  const int height = taps.x.height();
  const MF in_row = InRow(x, width);
  const VI bx = hn::LoadU(di, taps.x.Row(y) + x);
  const VI by = hn::LoadU(di, taps.y.Row(y) + x);
  FetchTaps t;
  MF used = hn::FirstN(d, 0);
  MF others = used;
  for (int i = 0; i < 4; ++i) {
    t.weight[i] = hn::IfThenElseZero(in_row, hn::LoadU(d, taps.weight[i].Row(y) + x));
    const MF counts = hn::Gt(t.weight[i], hn::Zero(d));
    used = hn::Or(used, counts);
    others = i == 0 ? others : hn::Or(others, counts);
  }
  t.single = hn::AllFalse(d, others);
  const SideBySide block = FindSideBySide(bx, by, used, 2, width);
  VF length[4];
  for (int i = 0; i < 4; ++i) {
    const auto counts = hn::RebindMask(di, hn::Gt(t.weight[i], hn::Zero(d)));
    const VI tx = hn::IfThenElseZero(counts, hn::Add(bx, hn::Set(di, i & 1)));
    const VI ty = hn::IfThenElseZero(counts, hn::Add(by, hn::Set(di, i >> 1)));
    t.load[i] = TapAt(block, i & 1, i >> 1, height, tx, ty);
    length[i] = t.load[i](d, before.length);
  }
  KeepTapsWithLight(length, t.weight, t.kept);
  const DU du;
  const VU search =
      hn::IfThenElseZero(hn::RebindMask(du, in_row), hn::LoadU(du, taps.search.Row(y) + x));
  t.searched = !hn::AllTrue(du, hn::Eq(search, hn::Zero(du)));
  t.taps = &taps;
  t.x = x;
  t.y = y;
  return t;
}

/// One plane of the history `before` at a vector of pixels. Taps without light count for the length
/// alone.
HWY_INLINE VF FetchPlane(const Image1& plane, const SignalHistory& before, const FetchTaps& t) {
  const DF d;
  const bool light_only = &plane != &before.length;
  const VF* weight = light_only ? t.kept : t.weight;
  VF sum = hn::Mul(weight[0], t.load[0](d, plane));
  if (!t.single) {
    for (int i = 1; i < 4; ++i) {
      sum = hn::MulAdd(weight[i], t.load[i](d, plane), sum);
    }
  }
  if (t.searched) {
    HWY_ALIGN float lanes[hn::MaxLanes(d)];
    hn::Store(sum, d, lanes);
    const int count = std::min(LaneCount(), plane.width() - t.x);
    for (int i = 0; i < count; ++i) {
      if (t.taps->search(t.x + i, t.y) != 0) {
        lanes[i] = FetchSearched(plane, before.length, *t.taps, light_only, t.x + i, t.y);
      }
    }
    sum = hn::Load(d, lanes);
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
