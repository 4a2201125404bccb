// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/antialias.h"

#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/antialias_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/antialias.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Pixels beyond the edge of the picture repeat the one at its edge.
HWY_INLINE VI ClampColumns(VI x, int width) {
  const DI di;
  return hn::Min(hn::Max(x, hn::Zero(di)), hn::Set(di, width - 1));
}

HWY_INLINE void CatmullRom(VF t, VF w[4]) {
  const DF d;
  const VF t2 = hn::Mul(t, t);
  const VF t3 = hn::Mul(t2, t);
  const VF half = hn::Set(d, 0.5f);
  w[0] = hn::Sub(t2, hn::Mul(half, hn::Add(t3, t)));
  w[1] =
      hn::Add(hn::MulAdd(hn::Set(d, 1.5f), t3, hn::Mul(hn::Set(d, -2.5f), t2)), hn::Set(d, 1.0f));
  w[2] = hn::MulAdd(hn::Set(d, -1.5f), t3, hn::MulAdd(hn::Set(d, 2.0f), t2, hn::Mul(half, t)));
  w[3] = hn::Mul(half, hn::Sub(t3, t2));
}

/// NewPictureWeight for a vector of pixels.
HWY_INLINE VF Alpha(const AntialiasParameters& p, VF longest, int x, int y) {
  const DF d;
  const VF alpha = hn::Set(d, p.alpha);
  if (p.length == nullptr) {
    return alpha;
  }
  const VF one = hn::Set(d, 1.0f);
  const VF n = p.samples == nullptr ? one : hn::LoadU(d, p.samples->Row(y) + x);
  const MF some = hn::Gt(n, hn::Zero(d));
  const VF length = hn::Max(longest, n);
  const VF share = hn::Div(n, hn::IfThenElse(some, length, one));
  return hn::IfThenElse(some, hn::Min(hn::Max(alpha, share), one), alpha);
}

/// What a vector of pixels learns from its 3x3 neighbours.
struct Neighbourhood {
  VF low[3];
  VF high[3];
  VF mx, my;   ///< motion of the nearest surface in front of the centre's, or the centre's own
  VF longest;  ///< history of any pixel; 0 where lengths are not known
};

/// Whether nothing in a row moves.
HWY_INLINE bool IsStillRow(const Image2& motion, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const float* mx = motion[0].Row(y);
  const float* my = motion[1].Row(y);
  const int width = motion.width();
  bool still = true;
  for (int x = 0; x < width && still; x += LaneCount()) {
    const MF none = hn::And(hn::Eq(hn::LoadU(d, mx + x), zero), hn::Eq(hn::LoadU(d, my + x), zero));
    still = hn::AllTrue(d, hn::Or(none, hn::Not(InRow(x, width))));
  }
  return still;
}

/// \tparam kStill  none of the neighbours moves, whichever is nearest
/// \param inner  neighbours exist in all columns, so that plain loads find them; else the picture's
///               edge is repeated
template <bool kStill>
HWY_INLINE Neighbourhood LookAround(const Image3& colour, const Image2& motion,
                                    const GuidePlanes& guides, const Image1* length, int x, int y,
                                    bool inner) {
  const DF d;
  const DI di;
  const int width = colour.width();
  const int height = colour.height();
  const VI columns = hn::Iota(di, x);
  Neighbourhood n;
  for (int c = 0; c < 3; ++c) {
    n.low[c] = n.high[c] = hn::LoadU(d, colour[c].Row(y) + x);
  }
  const auto of_centre = [&](const Image1& plane) HWY_ATTR {
    return kStill ? hn::Zero(d) : hn::LoadU(d, plane.Row(y) + x);
  };
  const VF centre = of_centre(guides.inverse_depth);
  const VF gx = of_centre(guides.gradient[0]);
  const VF gy = of_centre(guides.gradient[1]);
  const VF slack = hn::MulAdd(hn::Set(d, kInFront), centre, centre);
  n.longest = hn::Zero(d);
  VF nearest = centre;
  n.mx = of_centre(motion[0]);
  n.my = of_centre(motion[1]);
  for (const int row : {y > 0 ? y - 1 : 0, y, y + 1 < height ? y + 1 : height - 1}) {
    for (int dx = -1; dx <= 1; ++dx) {
      const VI at = ClampColumns(hn::Add(columns, hn::Set(di, dx)), width);
      const auto load = [&](const Image1& plane) HWY_ATTR {
        return inner ? hn::LoadU(d, plane.Row(row) + x + dx)
                     : hn::GatherIndex(d, plane.Row(row), at);
      };
      for (int c = 0; c < 3; ++c) {
        const VF q = load(colour[c]);
        n.low[c] = hn::Min(n.low[c], q);
        n.high[c] = hn::Max(n.high[c], q);
      }
      if (length != nullptr) {
        n.longest = hn::Max(n.longest, load(*length));
      }
      if constexpr (kStill) {
        continue;
      }
      const VF i = load(guides.inverse_depth);
      const VF ox = hn::ConvertTo(d, hn::Sub(at, columns));
      const VF oy = hn::Set(d, static_cast<float>(row - y));
      const VF plane = hn::MulAdd(gx, ox, hn::MulAdd(gy, oy, slack));
      const MF nearer = hn::And(hn::Gt(i, nearest), hn::Gt(i, plane));
      if (!hn::AllFalse(d, nearer)) {
        nearest = hn::IfThenElse(nearer, i, nearest);
        n.mx = hn::IfThenElse(nearer, load(motion[0]), n.mx);
        n.my = hn::IfThenElse(nearer, load(motion[1]), n.my);
      }
    }
  }
  return n;
}

/// The previous picture at (px, py), Catmull-Rom over 4x4 taps; lanes not `inside` are not read.
HWY_INLINE void SamplePrevious(const Image3& previous, VF px, VF py, MF inside, VF before[3]) {
  const DF d;
  const DI di;
  const int width = previous.width();
  const int height = previous.height();
  const VF sx = hn::IfThenElseZero(inside, px);
  const VF sy = hn::IfThenElseZero(inside, py);
  const VF fx = hn::Floor(sx);
  const VF fy = hn::Floor(sy);
  const VF u = hn::Sub(sx, fx);
  const VF v = hn::Sub(sy, fy);
  const VI bx = hn::Sub(hn::ConvertTo(di, fx), hn::Set(di, 1));
  const VI by = hn::Sub(hn::ConvertTo(di, fy), hn::Set(di, 1));
  // The last lane may not look beyond the last column: there the edge is repeated, lane by lane.
  const SideBySide block = FindSideBySide(bx, by, inside, 4, width - LaneCount());
  const auto load = [&](int i, int j) HWY_ATTR {
    const VI row = ClampColumns(hn::Add(by, hn::Set(di, j)), height);
    const VI column = ClampColumns(hn::Add(bx, hn::Set(di, i)), width);
    return TapAt(block, i, j, height, column, row);
  };
  const VF zero = hn::Zero(d);
  if (hn::AllTrue(d, hn::And(hn::Eq(u, zero), hn::Eq(v, zero)))) {  // nothing moved
    const TapLoad tap = load(1, 1);
    for (int c = 0; c < 3; ++c) {
      before[c] = tap(d, previous[c]);
    }
    return;
  }
  VF wx[4];
  VF wy[4];
  CatmullRom(u, wx);
  CatmullRom(v, wy);
  for (int c = 0; c < 3; ++c) {
    before[c] = zero;
  }
  for (int j = 0; j < 4; ++j) {
    VF sums[3] = {zero, zero, zero};
    for (int i = 0; i < 4; ++i) {
      const TapLoad tap = load(i, j);
      for (int c = 0; c < 3; ++c) {
        sums[c] = hn::MulAdd(wx[i], tap(d, previous[c]), sums[c]);
      }
    }
    for (int c = 0; c < 3; ++c) {
      before[c] = hn::MulAdd(wy[j], sums[c], before[c]);
    }
  }
}

void AntialiasRows(const Image3& colour, const Image3& previous, const Image2& motion,
                   const GuidePlanes& guides, const AntialiasParameters& p, int y0, int y1,
                   Image3* out) {
  const DF d;
  const int width = colour.width();
  const int height = colour.height();
  const VF edge = hn::Set(d, -0.5f);
  const VF right = hn::Set(d, static_cast<float>(width) - 0.5f);
  const VF bottom = hn::Set(d, static_cast<float>(height) - 0.5f);
  bool still[3] = {true, IsStillRow(motion, std::max(y0 - 1, 0)), IsStillRow(motion, y0)};
  for (int y = y0; y < y1; ++y) {
    still[0] = still[1];
    still[1] = still[2];
    still[2] = IsStillRow(motion, std::min(y + 1, height - 1));
    const bool all_still = still[0] && still[1] && still[2];
    NextRow<20> next;
    next.Add(colour, y + 2);
    next.Add(previous, y + 3);
    if (!all_still) {
      next.Add(motion, y + 2);
      next.Add(guides.inverse_depth, y + 2);
      next.Add(guides.gradient, y + 1);
    }
    if (p.length != nullptr) {
      next.Add(*p.length, y + 2);
    }
    next.Add(*out, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const bool inner = x > 0 && x + LaneCount() < width;
      const Neighbourhood n =
          all_still ? LookAround<true>(colour, motion, guides, p.length, x, y, inner)
                    : LookAround<false>(colour, motion, guides, p.length, x, y, inner);
      const VF px = hn::Add(ColumnsFrom(x), n.mx);
      const VF py = hn::Add(hn::Set(d, static_cast<float>(y)), n.my);
      const MF in_x = hn::And(hn::Gt(px, edge), hn::Lt(px, right));
      const MF in_y = hn::And(hn::Gt(py, edge), hn::Lt(py, bottom));
      const MF inside = hn::And(hn::And(in_x, in_y), InRow(x, width));
      VF before[3];
      if (all_still) {
        for (int c = 0; c < 3; ++c) {
          before[c] = hn::LoadU(d, previous[c].Row(y) + x);
        }
      } else {
        SamplePrevious(previous, px, py, inside, before);
      }
      const VF alpha = Alpha(p, n.longest, x, y);
      for (int c = 0; c < 3; ++c) {
        const VF now = hn::LoadU(d, colour[c].Row(y) + x);
        const VF kept = hn::Min(hn::Max(before[c], n.low[c]), n.high[c]);
        const VF blend = hn::MulAdd(alpha, hn::Sub(now, kept), kept);
        StoreInRow(d, hn::IfThenElse(inside, blend, now), (*out)[c].Row(y), x, width);
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

HWY_EXPORT(AntialiasRows);

void Antialias(const Image3& colour, const Image3& previous, const Image2& motion,
               const GuidePlanes& guides, const AntialiasParameters& p, Image3* out) {
  ParallelRows(colour.height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(AntialiasRows)(colour, previous, motion, guides, p, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
