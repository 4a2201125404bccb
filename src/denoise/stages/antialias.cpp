// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/antialias.h"

#include "core/parallel.h"
#include "denoise/stages/antialias_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/antialias.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

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

void AntialiasRows(const Image3& colour, const Image3& previous, const Image2& motion,
                   const GuidePlanes& guides, const AntialiasParameters& p, int y0, int y1,
                   Image3* out) {
  const DF d;
  const DI di;
  const int width = colour.width();
  const int height = colour.height();
  const VI stride = hn::Set(di, static_cast<int>(previous[0].stride()));
  for (int y = y0; y < y1; ++y) {
    const int rows[3] = {y > 0 ? y - 1 : 0, y, y + 1 < height ? y + 1 : height - 1};
    for (int x = 0; x < width; x += LaneCount()) {
      const VI columns = hn::Iota(di, x);
      VF now[3];
      VF low[3];
      VF high[3];
      for (int c = 0; c < 3; ++c) {
        now[c] = low[c] = high[c] = hn::LoadU(d, colour[c].Row(y) + x);
      }
      const VF centre = hn::LoadU(d, guides.inverse_depth.Row(y) + x);
      const VF gx = hn::LoadU(d, guides.gradient[0].Row(y) + x);
      const VF gy = hn::LoadU(d, guides.gradient[1].Row(y) + x);
      const VF slack = hn::MulAdd(hn::Set(d, kInFront), centre, centre);
      VF longest = hn::Zero(d);
      VF nearest = centre;
      VF mx = hn::LoadU(d, motion[0].Row(y) + x);
      VF my = hn::LoadU(d, motion[1].Row(y) + x);
      for (const int row : rows) {
        for (int dx = -1; dx <= 1; ++dx) {
          const VI at = ClampColumns(hn::Add(columns, hn::Set(di, dx)), width);
          for (int c = 0; c < 3; ++c) {
            const VF q = hn::GatherIndex(d, colour[c].Row(row), at);
            low[c] = hn::Min(low[c], q);
            high[c] = hn::Max(high[c], q);
          }
          if (p.length != nullptr) {
            longest = hn::Max(longest, hn::GatherIndex(d, p.length->Row(row), at));
          }
          const VF i = hn::GatherIndex(d, guides.inverse_depth.Row(row), at);
          const VF ox = hn::ConvertTo(d, hn::Sub(at, columns));
          const VF oy = hn::Set(d, static_cast<float>(row - y));
          const VF plane = hn::MulAdd(gx, ox, hn::MulAdd(gy, oy, slack));
          const MF nearer = hn::And(hn::Gt(i, nearest), hn::Gt(i, plane));
          nearest = hn::IfThenElse(nearer, i, nearest);
          mx = hn::IfThenElse(nearer, hn::GatherIndex(d, motion[0].Row(row), at), mx);
          my = hn::IfThenElse(nearer, hn::GatherIndex(d, motion[1].Row(row), at), my);
        }
      }
      const VF px = hn::Add(hn::ConvertTo(d, columns), mx);
      const VF py = hn::Add(hn::Set(d, static_cast<float>(y)), my);
      const VF edge = hn::Set(d, -0.5f);
      const MF in_x =
          hn::And(hn::Gt(px, edge), hn::Lt(px, hn::Set(d, static_cast<float>(width) - 0.5f)));
      const MF in_y =
          hn::And(hn::Gt(py, edge), hn::Lt(py, hn::Set(d, static_cast<float>(height) - 0.5f)));
      const MF inside = hn::And(hn::And(in_x, in_y), InRow(x, width));
      const VF sx = hn::IfThenElseZero(inside, px);
      const VF sy = hn::IfThenElseZero(inside, py);
      const VF fx = hn::Floor(sx);
      const VF fy = hn::Floor(sy);
      VF wx[4];
      VF wy[4];
      CatmullRom(hn::Sub(sx, fx), wx);
      CatmullRom(hn::Sub(sy, fy), wy);
      const VI bx = hn::ConvertTo(di, fx);
      const VI by = hn::ConvertTo(di, fy);
      VF before[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
      for (int j = 0; j < 4; ++j) {
        const VI row = ClampColumns(hn::Add(by, hn::Set(di, j - 1)), height);
        VF sums[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (int i = 0; i < 4; ++i) {
          const VI index =
              hn::Add(hn::Mul(row, stride), ClampColumns(hn::Add(bx, hn::Set(di, i - 1)), width));
          for (int c = 0; c < 3; ++c) {
            sums[c] = hn::MulAdd(wx[i], hn::GatherIndex(d, previous[c].Row(0), index), sums[c]);
          }
        }
        for (int c = 0; c < 3; ++c) {
          before[c] = hn::MulAdd(wy[j], sums[c], before[c]);
        }
      }
      for (int c = 0; c < 3; ++c) {
        before[c] = hn::Min(hn::Max(before[c], low[c]), high[c]);
      }
      const VF alpha = Alpha(p, longest, x, y);
      for (int c = 0; c < 3; ++c) {
        const VF blend = hn::MulAdd(alpha, hn::Sub(now[c], before[c]), before[c]);
        StoreInRow(d, hn::IfThenElse(inside, blend, now[c]), (*out)[c].Row(y), x, width);
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
