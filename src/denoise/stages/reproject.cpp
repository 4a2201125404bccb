// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/reproject.h"

#include <cmath>

#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/reproject_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/reproject.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// A pixel of the present frame, for tests against taps of the last one.
struct Target {
  VF nx, ny, nz, i, gx, gy, px, py;
  VF allowed;  ///< difference of inverse depth that slope and jitter alone may make
  VU id;
};

/// Lanes whose tap, the one at (cx, cy) of the block that starts at (bx, by), lies in the picture
/// and shows the same surface.
HWY_INLINE MF TapMatches(const Target& t, const GuidePlanes& before, const SideBySide& block,
                         int cx, int cy, VI bx, VI by, const ReprojectParameters& p) {
  const DF d;
  const DI di;
  const VI tx = hn::Add(bx, hn::Set(di, cx));
  const VI ty = hn::Add(by, hn::Set(di, cy));
  const VI below = hn::Set(di, -1);
  const auto inside =
      hn::And(hn::And(hn::Gt(tx, below), hn::Lt(tx, hn::Set(di, before.id.width()))),
              hn::And(hn::Gt(ty, below), hn::Lt(ty, hn::Set(di, before.id.height()))));
  const TapLoad load = TapAt(block, cx, cy, before.id.height(), hn::IfThenElseZero(inside, tx),
                             hn::IfThenElseZero(inside, ty));
  const VF i = load(d, before.inverse_depth);
  const VF nx = load(d, before.normal[0]);
  const VF ny = load(d, before.normal[1]);
  const VF nz = load(d, before.normal[2]);
  const VF dx = hn::Sub(hn::ConvertTo(d, tx), t.px);
  const VF dy = hn::Sub(hn::ConvertTo(d, ty), t.py);
  const VF expected = hn::MulAdd(t.gx, dx, hn::MulAdd(t.gy, dy, t.i));
  const VF allowed = hn::MulAdd(hn::Set(d, p.depth_tolerance), expected, t.allowed);
  const VF cosine = hn::MulAdd(t.nx, nx, hn::MulAdd(t.ny, ny, hn::Mul(t.nz, nz)));
  MF same = hn::And(hn::Gt(i, hn::Zero(d)), hn::Le(hn::Abs(hn::Sub(i, expected)), allowed));
  same = hn::And(same, hn::Ge(cosine, hn::Set(d, p.min_cosine)));
  if (p.test_id) {
    const DU du;
    const VU id = load(du, before.id);
    const VU unknown = hn::Zero(du);
    const auto id_ok = hn::Or(hn::Eq(id, t.id), hn::Or(hn::Eq(id, unknown), hn::Eq(t.id, unknown)));
    same = hn::And(same, hn::RebindMask(d, id_ok));
  }
  return hn::And(same, hn::RebindMask(d, inside));
}

/// \param found  lanes with a tap of their own, at themselves where `own`
HWY_INLINE HistoryPlace PlaceOf(MF found, MF own, VU search, MF in_row) {
  const DF d;
  const DU du;
  if (!hn::AllTrue(du, hn::Eq(search, hn::Zero(du)))) {
    return HistoryPlace::kElsewhere;
  }
  if (hn::AllFalse(d, found)) {
    return HistoryPlace::kNowhere;
  }
  const MF at_home = hn::And(found, own);
  if (hn::AllTrue(d, hn::Or(at_home, hn::Not(in_row)))) {
    return HistoryPlace::kUnchanged;
  }
  return hn::AllTrue(d, hn::Or(at_home, hn::Not(found))) ? HistoryPlace::kOwn
                                                         : HistoryPlace::kElsewhere;
}

/// The row that a pixel of row y looks at, near enough to fetch it ahead of its use.
int RowSeen(int y, float motion) {
  return y + (std::abs(motion) < 1e4f ? static_cast<int>(std::floor(motion)) : 0);
}

int TapLanes() {
  return LaneCount();
}

void FindTapsRows(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
                  const ReprojectParameters& p, int y0, int y1, ReprojectionTaps* taps) {
  const DF d;
  const DI di;
  const DU du;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = taps->x.width();
  const int height = taps->x.height();
  for (int y = y0; y < y1; ++y) {
    const int there = RowSeen(y, motion[1](width / 2, y));
    NextRow<32> next;
    next.Add(now.normal, y + 1);
    next.Add(now.inverse_depth, y + 1);
    next.Add(now.gradient, y + 1);
    next.Add(now.id, y + 1);
    next.Add(motion, y + 1);
    next.Add(before.normal, there + 2);
    next.Add(before.inverse_depth, there + 2);
    next.Add(before.id, there + 2);
    next.Add(taps->x, y + 1);
    next.Add(taps->y, y + 1);
    next.Add(taps->weight, y + 1);
    next.Add(taps->search, y + 1);
    int elsewhere = 0;
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      Target t;
      t.nx = hn::LoadU(d, now.normal[0].Row(y) + x);
      t.ny = hn::LoadU(d, now.normal[1].Row(y) + x);
      t.nz = hn::LoadU(d, now.normal[2].Row(y) + x);
      t.i = hn::LoadU(d, now.inverse_depth.Row(y) + x);
      t.gx = hn::LoadU(d, now.gradient[0].Row(y) + x);
      t.gy = hn::LoadU(d, now.gradient[1].Row(y) + x);
      t.id = hn::LoadU(du, now.id.Row(y) + x);
      t.allowed = hn::Mul(hn::Set(d, kReprojectSlack), hn::Add(hn::Abs(t.gx), hn::Abs(t.gy)));
      const VF px = hn::Add(ColumnsFrom(x), hn::LoadU(d, motion[0].Row(y) + x));
      const VF py = hn::Add(hn::Set(d, static_cast<float>(y)), hn::LoadU(d, motion[1].Row(y) + x));
      const VF low = hn::Set(d, -2.0f);
      const MF in_x =
          hn::And(hn::Gt(px, low), hn::Lt(px, hn::Set(d, static_cast<float>(width) + 1.0f)));
      const MF in_y =
          hn::And(hn::Gt(py, low), hn::Lt(py, hn::Set(d, static_cast<float>(height) + 1.0f)));
      const MF near_picture =
          hn::And(hn::And(in_x, in_y), hn::And(hn::Gt(t.i, zero), InRow(x, width)));
      t.px = hn::IfThenElseZero(near_picture, px);
      t.py = hn::IfThenElseZero(near_picture, py);
      const VF fx = hn::Floor(t.px);
      const VF fy = hn::Floor(t.py);
      const VF u = hn::Sub(t.px, fx);
      const VF v = hn::Sub(t.py, fy);
      VI bx = hn::ConvertTo(di, fx);
      VI by = hn::ConvertTo(di, fy);
      const VF weight_x[2] = {hn::Sub(one, u), u};
      const VF weight_y[2] = {hn::Sub(one, v), v};
      VF weight[4];
      VF sum = zero;
      const SideBySide block = FindSideBySide(bx, by, near_picture, 2, width);
      // Where nothing moves, or all by whole pixels, the other three count nothing.
      const bool between = !hn::AllTrue(d, hn::And(hn::Eq(u, zero), hn::Eq(v, zero)));
      weight[1] = weight[2] = weight[3] = zero;
      for (int i = 0; i < (between ? 4 : 1); ++i) {
        const MF matches =
            hn::And(near_picture, TapMatches(t, before, block, i & 1, i >> 1, bx, by, p));
        weight[i] = hn::IfThenElseZero(matches, hn::Mul(weight_x[i & 1], weight_y[i >> 1]));
        sum = hn::Add(sum, weight[i]);
      }
      // A sliver of a matching tap is no evidence: its weight would be raised a hundredfold.
      const MF found = hn::Gt(sum, hn::Set(d, 0.01f));
      const VF scale = hn::IfThenElseZero(found, hn::Div(one, hn::IfThenElse(found, sum, one)));
      VU search = hn::Zero(du);
      const MF lost = hn::AndNot(found, near_picture);
      if (p.search && !hn::AllFalse(d, lost)) {
        const VF half = hn::Set(d, 0.5f);
        const VI cx = hn::Sub(hn::ConvertTo(di, hn::Floor(hn::Add(t.px, half))), hn::Set(di, 1));
        const VI cy = hn::Sub(hn::ConvertTo(di, hn::Floor(hn::Add(t.py, half))), hn::Set(di, 1));
        for (int i = 0; i < 9; ++i) {
          const MF matches =
              hn::And(lost, TapMatches(t, before, SideBySide(), i % 3, i / 3, cx, cy, p));
          search =
              hn::Or(search, hn::IfThenElseZero(hn::RebindMask(du, matches), hn::Set(du, 1u << i)));
        }
        bx = hn::IfThenElse(hn::RebindMask(di, lost), cx, bx);
        by = hn::IfThenElse(hn::RebindMask(di, lost), cy, by);
      }
      const MF own =
          hn::RebindMask(d, hn::And(hn::Eq(bx, hn::Iota(di, x)), hn::Eq(by, hn::Set(di, y))));
      const HistoryPlace place =
          between ? HistoryPlace::kElsewhere : PlaceOf(found, own, search, InRow(x, width));
      taps->Place(x / LaneCount(), y) = place;
      elsewhere += place == HistoryPlace::kElsewhere ? 1 : 0;
      if (place == HistoryPlace::kUnchanged || place == HistoryPlace::kNowhere) {
        continue;
      }
      const auto keep = hn::RebindMask(di, near_picture);
      StoreInRow(di, hn::IfThenElseZero(keep, bx), taps->x.Row(y), x, width);
      StoreInRow(di, hn::IfThenElseZero(keep, by), taps->y.Row(y), x, width);
      for (int i = 0; i < 4; ++i) {
        StoreInRow(d, hn::Mul(weight[i], scale), taps->weight[i].Row(y), x, width);
      }
      StoreInRow(du, search, taps->search.Row(y), x, width);
    }
    taps->elsewhere[static_cast<size_t>(y)] = elsewhere;
  }
}

void FetchHistoryRows(const SignalHistory& before, const ReprojectionTaps& taps, int y0, int y1,
                      SignalHistory* out) {
  const DF d;
  const Image1* in[kMostHistoryPlanes];
  Image1* to[kMostHistoryPlanes];
  const int planes = ListHistoryPlanes(before, out, in, to);
  const int width = taps.x.width();
  for (int y = y0; y < y1; ++y) {
    const int there = RowOfTaps(taps, width / 2, y);
    NextRow<2 * kMostHistoryPlanes + 7> next;
    next.Add(taps.x, y + 1);
    next.Add(taps.y, y + 1);
    next.Add(taps.weight, y + 1);
    next.Add(taps.search, y + 1);
    for (int k = 0; k < planes; ++k) {
      next.Add(*in[k], there + 2);
      next.Add(*to[k], y + 1);
    }
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const FetchTaps t = LoadTaps(before, taps, x, y);
      for (int k = 0; k < planes; ++k) {
        StoreInRow(d, FetchPlane(*in[k], before, t), to[k]->Row(y), x, width);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(TapLanes);
HWY_EXPORT(FindTapsRows);
HWY_EXPORT(FetchHistoryRows);

void FindTaps(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
              const ReprojectParameters& p, ReprojectionTaps* taps) {
  taps->lanes = HWY_DYNAMIC_DISPATCH(TapLanes)();
  ParallelRows(taps->x.height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FindTapsRows)(now, before, motion, p, y0, y1, taps);
  });
}

void FetchHistory(const SignalHistory& before, const ReprojectionTaps& taps, SignalHistory* out) {
  ParallelRows(taps.x.height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FetchHistoryRows)(before, taps, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
