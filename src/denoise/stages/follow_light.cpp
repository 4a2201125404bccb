// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/follow_light.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/stages/reproject_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/follow_light.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// The surfaces of the blocks x, x + 1, ... of row y.
struct SurfaceVector {
  VF inverse_depth;
  VF normal[3];
  VF gradient[2];
  VF slack;  ///< tolerance of inverse depth due to the gradient
  VU id;
};

HWY_INLINE SurfaceVector LoadSurface(const FollowedBlocks& b, int x, int y) {
  const DF d;
  SurfaceVector s;
  s.inverse_depth = hn::LoadU(d, b.inverse_depth.Row(y) + x);
  for (int c = 0; c < 3; ++c) {
    s.normal[c] = hn::LoadU(d, b.normal[c].Row(y) + x);
  }
  for (int c = 0; c < 2; ++c) {
    s.gradient[c] = hn::LoadU(d, b.gradient[c].Row(y) + x);
  }
  s.slack =
      hn::Mul(hn::Set(d, kReprojectSlack), hn::Add(hn::Abs(s.gradient[0]), hn::Abs(s.gradient[1])));
  s.id = hn::LoadU(DU(), b.id.Row(y) + x);
  return s;
}

/// Lanes whose surface equals that of the block at an offset.
HWY_INLINE MF ShowSurface(const FollowedBlocks& b, const SurfaceVector& s, int x, int y, int dx,
                          int dy) {
  const DF d;
  const DU du;
  const VF across = hn::Mul(s.gradient[0], hn::Set(d, static_cast<float>(kFollowBlock * dx)));
  const VF down = hn::Mul(s.gradient[1], hn::Set(d, static_cast<float>(kFollowBlock * dy)));
  const VF expected = hn::Add(hn::Add(s.inverse_depth, across), down);
  const VF there = hn::LoadU(d, b.inverse_depth.Row(y + dy) + x + dx);
  VF cosine = hn::Zero(d);
  for (int c = 0; c < 3; ++c) {
    cosine = hn::MulAdd(s.normal[c], hn::LoadU(d, b.normal[c].Row(y + dy) + x + dx), cosine);
  }
  const VU id = hn::LoadU(du, b.id.Row(y + dy) + x + dx);
  const VF allowed = hn::MulAdd(hn::Set(d, kFollowDepth), expected, s.slack);
  const VU none = hn::Zero(du);
  const auto same_id = hn::Or(hn::Or(hn::Eq(id, s.id), hn::Eq(id, none)), hn::Eq(s.id, none));
  const MF same_depth =
      hn::And(hn::Gt(there, hn::Zero(d)), hn::Le(hn::Abs(hn::Sub(there, expected)), allowed));
  const MF same_normal = hn::Ge(cosine, hn::Set(d, kFollowCosine));
  return hn::And(hn::And(same_depth, same_normal), hn::RebindMask(d, same_id));
}

/// FollowedChange.
HWY_INLINE VF FollowedChangeOf(VF sum, VF squares, VF known) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF zero = hn::Zero(d);
  const VF scale = hn::Div(one, hn::Max(known, one));
  const VF mean = hn::Mul(sum, scale);
  const VF square = hn::Mul(mean, mean);
  const VF spread = hn::Max(hn::Sub(hn::Mul(squares, scale), square), zero);
  const VF noise = hn::MulAdd(hn::Set(d, kFollowNoise), hn::Mul(spread, scale),
                              hn::Set(d, kFollowLeast * kFollowLeast));
  const VF share = hn::Div(noise, hn::Max(square, hn::Set(d, 1e-12f)));
  const VF significance = hn::Max(hn::Sub(one, share), zero);
  const VF most = hn::Set(d, kMostFollowed);
  const VF followed = hn::Min(hn::Max(hn::Mul(mean, significance), hn::Neg(most)), most);
  return hn::IfThenElseZero(hn::Ge(known, hn::Set(d, kFollowKnown)), followed);
}

void FollowRow(const FollowedBlocks& b, int y, float* ratio) {
  const DF d;
  const int width = b.change.width();
  const int y0 = std::max(y - kFollowRadius, 0);
  const int y1 = std::min(y + kFollowRadius, b.change.height() - 1);
  for (int x = 0; x < width; x += LaneCount()) {
    const SurfaceVector s = LoadSurface(b, x, y);
    const VF columns = ColumnsFrom(x);
    VF sum = hn::Zero(d);
    VF squares = hn::Zero(d);
    VF known = hn::Zero(d);
    MF at_edge = hn::FirstN(d, 0);
    for (int qy = y0; qy <= y1; ++qy) {
      for (int dx = -kFollowRadius; dx <= kFollowRadius; ++dx) {
        const MF same = ShowSurface(b, s, x, y, dx, qy - y);
        if (dx >= -1 && dx <= 1 && qy >= y - 1 && qy <= y + 1) {
          const VF qx = hn::Add(columns, hn::Set(d, static_cast<float>(dx)));
          const MF inside =
              hn::And(hn::Ge(qx, hn::Zero(d)), hn::Lt(qx, hn::Set(d, static_cast<float>(width))));
          at_edge = hn::Or(at_edge, hn::AndNot(same, inside));
        }
        const VF change = hn::IfThenElseZero(same, hn::LoadU(d, b.change.Row(qy) + x + dx));
        sum = hn::Add(sum, change);
        squares = hn::MulAdd(change, change, squares);
        known = hn::Add(known, hn::IfThenElseZero(same, hn::LoadU(d, b.known.Row(qy) + x + dx)));
      }
    }
    const VF followed = FollowedChangeOf(sum, squares, known);
    const VF factor = Exp2(hn::Mul(hn::Set(d, kLog2E), followed));
    StoreInRow(d, hn::IfThenElse(at_edge, hn::Set(d, 1.0f), factor), ratio, x, width);
  }
}

void FollowRows(const FollowedBlocks& blocks, int y0, int y1, Image1* ratio) {
  for (int y = y0; y < y1; ++y) {
    FollowRow(blocks, y, ratio->Row(y));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(FollowRows);

void FollowLight(const FollowedBlocks& blocks, Image1* ratio) {
  ParallelRows(ratio->height(), 8, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FollowRows)(blocks, y0, y1, ratio);
  });
}

}  // namespace stillray::cpu
#endif
