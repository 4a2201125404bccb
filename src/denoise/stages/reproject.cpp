// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/reproject.h"

#include <cmath>

#include "core/parallel.h"
#include "denoise/simd/find_taps_row.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/reproject_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/reproject.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/packed_normal-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// A vector of pixels of this frame, for tests against taps of the last one.
struct Target {
  VF nx, ny, nz, i, gx, gy, px, py;
  VF allowed;  ///< largest difference of inverse depth due to slope and jitter
  VU id;
  MF used;  ///< surfaces whose history is inside the image or next to it
};

/// The guides of a tap.
struct TapGuides {
  VF nx, ny, nz, i;
  VU id;
};

/// Lanes whose tap, at (dx, dy) from the previous positions, shows the expected surface.
HWY_INLINE MF ShowsSameSurface(const Target& t, const TapGuides& tap, VF dx, VF dy,
                               const ReprojectParameters& p) {
  const DF d;
  const VF expected = hn::MulAdd(t.gx, dx, hn::MulAdd(t.gy, dy, t.i));
  const VF allowed = hn::MulAdd(hn::Set(d, p.history_depth), expected, t.allowed);
  const VF cosine = hn::MulAdd(t.nx, tap.nx, hn::MulAdd(t.ny, tap.ny, hn::Mul(t.nz, tap.nz)));
  MF same = hn::And(hn::Gt(tap.i, hn::Zero(d)), hn::Le(hn::Abs(hn::Sub(tap.i, expected)), allowed));
  same = hn::And(same, hn::Ge(cosine, hn::Set(d, p.history_normal_cosine)));
  if (p.history_id != 0) {
    const DU du;
    const VU unknown = hn::Zero(du);
    const auto id_ok =
        hn::Or(hn::Eq(tap.id, t.id), hn::Or(hn::Eq(tap.id, unknown), hn::Eq(t.id, unknown)));
    same = hn::And(same, hn::RebindMask(d, id_ok));
  }
  return same;
}

/// Lanes whose tap, the one at (cx, cy) of the block that starts at (bx, by), is inside the image
/// and shows the expected surface.
template <bool kPacked>
HWY_INLINE MF TapMatches(const Target& t, const GuidePlanes& before, int cx, int cy, VI bx, VI by,
                         const ReprojectParameters& p) {
  const DF d;
  const DI di;
  const VI tx = hn::Add(bx, hn::Set(di, cx));
  const VI ty = hn::Add(by, hn::Set(di, cy));
  const VI below = hn::Set(di, -1);
  const auto inside =
      hn::And(hn::And(hn::Gt(tx, below), hn::Lt(tx, hn::Set(di, before.id.width()))),
              hn::And(hn::Gt(ty, below), hn::Lt(ty, hn::Set(di, before.id.height()))));
  const VI stride = hn::Set(di, static_cast<int>(before.id.stride()));
  const VI at = hn::IfThenElseZero(inside, hn::Add(hn::Mul(ty, stride), tx));
  const auto load = [&](const Image1& plane)
                        HWY_ATTR { return hn::GatherIndex(d, plane.Row(0), at); };
  TapGuides tap;
  if constexpr (kPacked) {
    VF n[3];
    UnpackNormal(hn::GatherIndex(DU(), before.packed_normal.Row(0), at), n);
    tap.nx = n[0];
    tap.ny = n[1];
    tap.nz = n[2];
  } else {
    tap.nx = load(before.normal[0]);
    tap.ny = load(before.normal[1]);
    tap.nz = load(before.normal[2]);
  }
  tap.i = load(before.inverse_depth);
  tap.id = hn::GatherIndex(DU(), before.id.Row(0), at);
  const VF dx = hn::Sub(hn::ConvertTo(d, tx), t.px);
  const VF dy = hn::Sub(hn::ConvertTo(d, ty), t.py);
  return hn::And(hn::And(ShowsSameSurface(t, tap, dx, dy, p), hn::RebindMask(d, inside)), t.used);
}

/// Rows of the last frame's guides, starting at one pixel; the rows are `stride` apart.
struct GuidesFrom {
  const uint32_t* packed_normal;  ///< if not nullptr, replaces nx, ny and nz
  const float* nx;
  const float* ny;
  const float* nz;
  const float* i;
  const uint32_t* id;
  ptrdiff_t stride;
};

template <bool kPacked>
HWY_INLINE GuidesFrom FromPixel(const GuidePlanes& g, int x, int y) {
  GuidesFrom from = {};
  if constexpr (kPacked) {
    from.packed_normal = g.packed_normal.Row(y) + x;
  } else {
    from.nx = g.normal[0].Row(y) + x;
    from.ny = g.normal[1].Row(y) + x;
    from.nz = g.normal[2].Row(y) + x;
  }
  from.i = g.inverse_depth.Row(y) + x;
  from.id = g.id.Row(y) + x;
  from.stride = g.id.stride();
  return from;
}

/// TapMatches for contiguous taps that are all inside the image, with scalar (cx, cy).
template <bool kPacked>
HWY_INLINE MF BlockMatches(const Target& t, const GuidesFrom& from, int cx, int cy, VF dx, VF dy,
                           const ReprojectParameters& p) {
  const DF d;
  const ptrdiff_t at = cy * from.stride + cx;
  TapGuides tap;
  if constexpr (kPacked) {
    VF n[3];
    UnpackNormal(hn::LoadU(DU(), from.packed_normal + at), n);
    tap.nx = n[0];
    tap.ny = n[1];
    tap.nz = n[2];
  } else {
    tap.nx = hn::LoadU(d, from.nx + at);
    tap.ny = hn::LoadU(d, from.ny + at);
    tap.nz = hn::LoadU(d, from.nz + at);
  }
  tap.i = hn::LoadU(d, from.i + at);
  tap.id = hn::LoadU(DU(), from.id + at);
  return hn::And(ShowsSameSurface(t, tap, dx, dy, p), t.used);
}

/// \param found  lanes with taps
/// \param own    lanes whose tap is the pixel itself
HWY_INLINE TapPattern PatternOf(MF found, MF own, VU search, MF in_row) {
  const DF d;
  const DU du;
  if (!hn::AllTrue(du, hn::Eq(search, hn::Zero(du)))) {
    return TapPattern::kGather;
  }
  if (hn::AllFalse(d, found)) {
    return TapPattern::kDisoccluded;
  }
  const MF at_home = hn::And(found, own);
  if (hn::AllTrue(d, hn::Or(at_home, hn::Not(in_row)))) {
    return TapPattern::kIdentity;
  }
  return hn::AllTrue(d, hn::Or(at_home, hn::Not(found))) ? TapPattern::kIdentityOrNone
                                                         : TapPattern::kGather;
}

/// The approximate row that a pixel of row y reads, for prefetching.
int RowSeen(int y, float motion) {
  return y + (std::abs(motion) < 1e4f ? static_cast<int>(std::floor(motion)) : 0);
}

int TapLanes() {
  return LaneCount();
}

/// The guides of a row of this frame.
struct RowNow {
  GuidesOfRow guides;
  const float* mx;
  const float* my;
  const float* previous[3];  ///< Guides::previous_normal; nullptr: not given
};

/// Replaces the normals by HistoryNormal.
HWY_INLINE void TurnBack(const RowNow& now, int x, Target* t) {
  const DF d;
  const VF px = hn::LoadU(d, now.previous[0] + x);
  const VF py = hn::LoadU(d, now.previous[1] + x);
  const VF pz = hn::LoadU(d, now.previous[2] + x);
  const VF length2 = hn::MulAdd(px, px, hn::MulAdd(py, py, hn::Mul(pz, pz)));
  const MF given = hn::And(hn::Gt(length2, hn::Set(d, 1e-12f)), hn::Lt(length2, hn::Set(d, 1e12f)));
  const VF one = hn::Set(d, 1.0f);
  const VF scale = hn::Div(one, hn::Sqrt(hn::IfThenElse(given, length2, one)));
  t->nx = hn::IfThenElse(given, hn::Mul(px, scale), t->nx);
  t->ny = hn::IfThenElse(given, hn::Mul(py, scale), t->ny);
  t->nz = hn::IfThenElse(given, hn::Mul(pz, scale), t->nz);
}

/// \param window  work memory for unpacked normals
GuidesOfRow GuidesOf(const GuidePlanes& g, int y, NormalWindow* window) {
  const NormalRows normals = NormalsAround(g, y, window);
  return {{normals.x, normals.y, normals.z},
          g.inverse_depth.Row(y),
          {g.gradient[0].Row(y), g.gradient[1].Row(y)},
          g.id.Row(y)};
}

/// The pixels x, x + 1, ... of row y.
HWY_INLINE Target LoadTarget(const RowNow& now, int x, int y, int width, int height) {
  const DF d;
  const VF zero = hn::Zero(d);
  Target t;
  t.nx = hn::LoadU(d, now.guides.normal[0] + x);
  t.ny = hn::LoadU(d, now.guides.normal[1] + x);
  t.nz = hn::LoadU(d, now.guides.normal[2] + x);
  if (now.previous[0] != nullptr) {
    TurnBack(now, x, &t);
  }
  t.i = hn::LoadU(d, now.guides.inverse_depth + x);
  t.gx = hn::LoadU(d, now.guides.gradient[0] + x);
  t.gy = hn::LoadU(d, now.guides.gradient[1] + x);
  t.id = hn::LoadU(DU(), now.guides.id + x);
  t.allowed = hn::Mul(hn::Set(d, kReprojectSlack), hn::Add(hn::Abs(t.gx), hn::Abs(t.gy)));
  const VF px = hn::Add(ColumnsFrom(x), hn::LoadU(d, now.mx + x));
  const VF py = hn::Add(hn::Set(d, static_cast<float>(y)), hn::LoadU(d, now.my + x));
  const VF low = hn::Set(d, -2.0f);
  const MF in_x =
      hn::And(hn::Gt(px, low), hn::Lt(px, hn::Set(d, static_cast<float>(width) + 1.0f)));
  const MF in_y =
      hn::And(hn::Gt(py, low), hn::Lt(py, hn::Set(d, static_cast<float>(height) + 1.0f)));
  t.used = hn::And(hn::And(in_x, in_y), hn::And(hn::Gt(t.i, zero), InRow(x, width)));
  t.px = hn::IfThenElseZero(t.used, px);
  t.py = hn::IfThenElseZero(t.used, py);
  return t;
}

/// The 2x2 taps of a vector of pixels.
struct Taps {
  VI x, y;
  VF weight[4];
  VF sum;        ///< of the weights
  bool between;  ///< some motion is not an integer number of pixels
};

template <bool kPacked>
HWY_INLINE Taps FindBilinear(const Target& t, const GuidePlanes& before,
                             const ReprojectParameters& p) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const bool nearest = p.history_taps_nearest != 0;
  const VF half = hn::Set(d, nearest ? 0.5f : 0.0f);
  const VF fx = hn::Floor(hn::Add(t.px, half));
  const VF fy = hn::Floor(hn::Add(t.py, half));
  const VF off_x = hn::Sub(t.px, fx);
  const VF off_y = hn::Sub(t.py, fy);
  const VF u = nearest ? zero : off_x;
  const VF v = nearest ? zero : off_y;
  const VF weight_x[2] = {hn::Sub(one, u), u};
  const VF weight_y[2] = {hn::Sub(one, v), v};
  const VF dx[2] = {hn::Neg(off_x), hn::Sub(one, off_x)};
  const VF dy[2] = {hn::Neg(off_y), hn::Sub(one, off_y)};
  Taps taps;
  taps.x = hn::ConvertTo(di, fx);
  taps.y = hn::ConvertTo(di, fy);
  taps.weight[1] = taps.weight[2] = taps.weight[3] = zero;
  // If motion is an integer number of pixels, the other three weights are zero.
  taps.between = !hn::AllTrue(d, hn::And(hn::Eq(u, zero), hn::Eq(v, zero)));
  const int count = taps.between ? 4 : 1;
  const SideBySide block = FindSideBySide(taps.x, taps.y, t.used);
  const auto weigh = [&](int i, MF matches) HWY_ATTR {
    taps.weight[i] = hn::IfThenElseZero(matches, hn::Mul(weight_x[i & 1], weight_y[i >> 1]));
  };
  if (LiesInPicture(block, 0, 1, before.id.width(), before.id.height())) {
    const GuidesFrom from = FromPixel<kPacked>(before, block.x, block.y);
    weigh(0, BlockMatches<kPacked>(t, from, 0, 0, dx[0], dy[0], p));
    if (taps.between) {
      weigh(1, BlockMatches<kPacked>(t, from, 1, 0, dx[1], dy[0], p));
      weigh(2, BlockMatches<kPacked>(t, from, 0, 1, dx[0], dy[1], p));
      weigh(3, BlockMatches<kPacked>(t, from, 1, 1, dx[1], dy[1], p));
    }
  } else {
    for (int i = 0; i < count; ++i) {
      weigh(i, TapMatches<kPacked>(t, before, i & 1, i >> 1, taps.x, taps.y, p));
    }
  }
  taps.sum =
      hn::Add(hn::Add(hn::Add(taps.weight[0], taps.weight[1]), taps.weight[2]), taps.weight[3]);
  return taps;
}

/// Tests the 3x3 block around the positions of the pixels that are `lost`: \return bits of the taps
/// that show the same surface
template <bool kPacked>
HWY_NOINLINE VU SearchAround(const Target& t, const GuidePlanes& before,
                             const ReprojectParameters& p, MF lost, VI* x, VI* y) {
  const DF d;
  const DI di;
  const DU du;
  const VF half = hn::Set(d, 0.5f);
  const VI cx = hn::Sub(hn::ConvertTo(di, hn::Floor(hn::Add(t.px, half))), hn::Set(di, 1));
  const VI cy = hn::Sub(hn::ConvertTo(di, hn::Floor(hn::Add(t.py, half))), hn::Set(di, 1));
  VU search = hn::Zero(du);
  for (int i = 0; i < 9; ++i) {
    const MF matches = hn::And(lost, TapMatches<kPacked>(t, before, i % 3, i / 3, cx, cy, p));
    search = hn::Or(search, hn::IfThenElseZero(hn::RebindMask(du, matches), hn::Set(du, 1u << i)));
  }
  *x = hn::IfThenElse(hn::RebindMask(di, lost), cx, *x);
  *y = hn::IfThenElse(hn::RebindMask(di, lost), cy, *y);
  return search;
}

/// \tparam kPacked  `before` has packed normals
template <bool kPacked>
void TapsOfRow(const GuidesOfRow& now, const GuidePlanes& before, const Image2& motion,
               const ReprojectParameters& p, int y, NextRow<32> next, ReprojectionTaps* out) {
  const DF d;
  const DI di;
  const DU du;
  const VF one = hn::Set(d, 1.0f);
  const int width = out->x.width();
  const int height = out->x.height();
  RowNow row = {now, motion[0].Row(y), motion[1].Row(y), {}};
  for (int c = 0; out->previous_normal != nullptr && c < 3; ++c) {
    row.previous[c] = (*out->previous_normal)[c].Row(y);
  }
  int32_t* const to_x = out->x.Row(y);
  int32_t* const to_y = out->y.Row(y);
  uint32_t* const to_search = out->search.Row(y);
  float* const to_weight[4] = {out->weight[0].Row(y), out->weight[1].Row(y), out->weight[2].Row(y),
                               out->weight[3].Row(y)};
  const int there = RowSeen(y, motion[1](width / 2, y));
  next.Add(motion, y + 1);
  next.Add(before.normal, there + 2);
  next.Add(before.packed_normal, there + 2);
  next.Add(before.inverse_depth, there + 2);
  next.Add(before.id, there + 2);
  AddStreamed(out->x, y + 1, &next);
  AddStreamed(out->y, y + 1, &next);
  AddStreamed(out->weight, y + 1, &next);
  AddStreamed(out->search, y + 1, &next);
  int gathers = 0;
  int scattered = 0;
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    const Target t = LoadTarget(row, x, y, width, height);
    Taps taps = FindBilinear<kPacked>(t, before, p);
    // Taps with a tiny weight are unreliable: normalisation would scale the weight up by more than
    // a hundred.
    const MF found = hn::Gt(taps.sum, hn::Set(d, 0.01f));
    const VF scale = hn::IfThenElseZero(found, hn::Div(one, hn::IfThenElse(found, taps.sum, one)));
    VU search = hn::Zero(du);
    const MF lost = hn::AndNot(found, t.used);
    if (p.history_search != 0 && !hn::AllFalse(d, lost)) {
      search = SearchAround<kPacked>(t, before, p, lost, &taps.x, &taps.y);
    }
    const MF own = hn::RebindMask(
        d, hn::And(hn::Eq(taps.x, ColumnNumbers(x)), hn::Eq(taps.y, hn::Set(di, y))));
    const MF in_row = InRow(x, width);
    TapPattern pattern = taps.between ? TapPattern::kGather : PatternOf(found, own, search, in_row);
    if (pattern == TapPattern::kGather && hn::AllTrue(du, hn::Eq(search, hn::Zero(du)))) {
      const SideBySide block = FindSideBySide(taps.x, taps.y, hn::And(found, in_row));
      if (hn::AllTrue(d, in_row) && LiesInPicture(block, 0, 1, width, height)) {
        pattern = TapPattern::kBlock2x2;
        out->Block(x / LaneCount(), y) = {block.x, block.y};
      }
    }
    out->Pattern(x / LaneCount(), y) = pattern;
    gathers += IsGather(pattern) ? 1 : 0;
    if (pattern == TapPattern::kIdentity || pattern == TapPattern::kDisoccluded) {
      continue;
    }
    for (int i = 0; i < 4; ++i) {
      StreamInRow(d, hn::Mul(taps.weight[i], scale), to_weight[i], x, width);
    }
    if (pattern == TapPattern::kBlock2x2) {
      continue;
    }
    ++scattered;
    const auto keep = hn::RebindMask(di, t.used);
    StreamInRow(di, hn::IfThenElseZero(keep, taps.x), to_x, x, width);
    StreamInRow(di, hn::IfThenElseZero(keep, taps.y), to_y, x, width);
    StreamInRow(du, search, to_search, x, width);
  }
  out->gathers[static_cast<size_t>(y)] = gathers;
  out->scattered[static_cast<size_t>(y)] = scattered;
}

void TapsOfRow(const GuidesOfRow& now, const GuidePlanes& before, const Image2& motion,
               const ReprojectParameters& p, int y, const NextRow<32>& next,
               ReprojectionTaps* out) {
  before.packs_normals() ? TapsOfRow<true>(now, before, motion, p, y, next, out)
                         : TapsOfRow<false>(now, before, motion, p, y, next, out);
}

void FindTapsRows(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
                  const ReprojectParameters& p, int y0, int y1, ReprojectionTaps* taps) {
  NormalWindow window(now, 1, 0);
  for (int y = y0; y < y1; ++y) {
    NextRow<32> next;
    next.Add(now.normal, y + 1);
    next.Add(now.packed_normal, y + 1);
    next.Add(now.inverse_depth, y + 1);
    next.Add(now.gradient, y + 1);
    next.Add(now.id, y + 1);
    TapsOfRow(GuidesOf(now, y, &window), before, motion, p, y, next, taps);
  }
  FinishStreams();
}

void OneRow(const GuidesOfRow& now, const GuidePlanes& before, const Image2& motion,
            const ReprojectParameters& p, int y, const NextRow<32>& next, ReprojectionTaps* taps) {
  TapsOfRow(now, before, motion, p, y, next, taps);
  FinishStreams();
}

template <bool kWithConfidence>
void FetchHistoryRowsOf(const SignalHistory& before, const ReprojectionTaps& taps, int y0, int y1,
                        SignalHistory* out) {
  const DF d;
  const Image1* in[kMostHistoryPlanes];
  Image1* to[kMostHistoryPlanes];
  const int planes = ListHistoryPlanes(before, out, in, to);
  const int width = taps.x.width();
  for (int y = y0; y < y1; ++y) {
    const int there = RowOfTaps(taps, width / 2, y);
    NextRow<2 * kMostHistoryPlanes + 7> next;
    AddTaps(taps, y + 1, &next);
    for (int k = 0; k < planes; ++k) {
      next.Add(*in[k], there + 2);
      AddStreamed(*to[k], y + 1, &next);
    }
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      WithHistory<kWithConfidence>(
          before, taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
            for (int k = 0; k < planes; ++k) {
              const VF old = in[k] == &before.length ? old_of.Length() : old_of(*in[k]);
              StreamInRow(d, old, to[k]->Row(y), x, width);
            }
          });
    }
  }
  FinishStreams();
}

void FetchHistoryRows(const SignalHistory& before, const ReprojectionTaps& taps, int y0, int y1,
                      SignalHistory* out) {
  taps.confidence != nullptr ? FetchHistoryRowsOf<true>(before, taps, y0, y1, out)
                             : FetchHistoryRowsOf<false>(before, taps, y0, y1, out);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(TapLanes);
HWY_EXPORT(FindTapsRows);
HWY_EXPORT(OneRow);
HWY_EXPORT(FetchHistoryRows);

void BeginTaps(ReprojectionTaps* taps) {
  taps->SetLanes(HWY_DYNAMIC_DISPATCH(TapLanes)());
}

void FindTapsRow(const GuidesOfRow& now, const GuidePlanes& before, const Image2& motion,
                 const ReprojectParameters& p, int y, const NextRow<32>& next,
                 ReprojectionTaps* taps) {
  HWY_DYNAMIC_DISPATCH(OneRow)(now, before, motion, p, y, next, taps);
}

void FindTaps(const GuidePlanes& now, const GuidePlanes& before, const Image2& motion,
              const ReprojectParameters& p, ReprojectionTaps* taps) {
  BeginTaps(taps);
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
