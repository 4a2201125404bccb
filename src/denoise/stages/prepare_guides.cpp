// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prepare_guides.h"

#include <atomic>

#include "core/parallel.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/prepare_guides_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prepare_guides.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Returns the number of pixels with bad guides.
int64_t ConvertGuideRows(const PrepareGuidesInput& in, int y0, int y1, GuidePlanes* out) {
  const DF d;
  const DU du;
  const int width = in.depth->width();
  int64_t bad = 0;
  for (int y = y0; y < y1; ++y) {
    NextRow<16> next;
    next.Add(*in.depth, y + 1);
    next.Add(*in.normal, y + 1);
    if (in.id != nullptr) {
      next.Add(*in.id, y + 1);
    }
    AddStreamed(out->inverse_depth, y + 1, &next);
    AddStreamed(out->depth, y + 1, &next);
    AddStreamed(out->normal, y + 1, &next);
    AddStreamed(out->id, y + 1, &next);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF z = hn::LoadU(d, in.depth->Row(y) + x);
      const VF nx = hn::LoadU(d, (*in.normal)[0].Row(y) + x);
      const VF ny = hn::LoadU(d, (*in.normal)[1].Row(y) + x);
      const VF nz = hn::LoadU(d, (*in.normal)[2].Row(y) + x);
      const MF finite_normal =
          hn::And(IsFiniteLane(nx), hn::And(IsFiniteLane(ny), IsFiniteLane(nz)));
      const VF length2 = hn::MulAdd(nx, nx, hn::MulAdd(ny, ny, hn::Mul(nz, nz)));
      const MF positive = hn::Gt(z, hn::Zero(d));
      MF surface = hn::And(hn::And(positive, IsFiniteLane(z)), finite_normal);
      surface =
          hn::And(surface, hn::And(hn::Gt(length2, hn::Set(d, 1e-12f)), IsFiniteLane(length2)));
      const VF one = hn::Set(d, 1.0f);
      const VF scale = hn::Div(one, hn::Sqrt(hn::IfThenElse(surface, length2, one)));
      const VF i = hn::Div(one, hn::IfThenElse(surface, z, one));
      StreamInRow(d, hn::IfThenElseZero(surface, i), out->inverse_depth.Row(y), x, width);
      StreamInRow(d, hn::IfThenElseZero(surface, z), out->depth.Row(y), x, width);
      StreamInRow(d, hn::IfThenElseZero(surface, hn::Mul(nx, scale)), out->normal[0].Row(y), x,
                  width);
      StreamInRow(d, hn::IfThenElseZero(surface, hn::Mul(ny, scale)), out->normal[1].Row(y), x,
                  width);
      StreamInRow(d, hn::IfThenElseZero(surface, hn::Mul(nz, scale)), out->normal[2].Row(y), x,
                  width);
      const VU id = in.id != nullptr ? hn::LoadU(du, in.id->Row(y) + x) : hn::Zero(du);
      StreamInRow(du, hn::IfThenElseZero(hn::RebindMask(du, surface), id), out->id.Row(y), x,
                  width);
      const MF good = hn::And(positive, finite_normal);
      bad += static_cast<int64_t>(hn::CountTrue(d, hn::AndNot(good, InRow(x, width))));
    }
  }
  FinishStreams();
  return bad;
}

HWY_INLINE VF Gradient(VF before, VF centre, VF after, MF before_ok, MF after_ok) {
  const DF d;
  const VF backward = hn::Sub(centre, before);
  const VF forward = hn::Sub(after, centre);
  const VF both = hn::IfThenElse(hn::Lt(hn::Abs(backward), hn::Abs(forward)), backward, forward);
  return hn::IfThenElse(after_ok, hn::IfThenElse(before_ok, both, forward),
                        hn::IfThenElse(before_ok, backward, hn::Zero(d)));
}

void GradientRows(int y0, int y1, GuidePlanes* g) {
  const DF d;
  const DU du;
  const int width = g->id.width();
  for (int y = y0; y < y1; ++y) {
    NextRow<8> next;
    next.Add(g->normal, y + 2);
    next.Add(g->id, y + 2);
    next.Add(g->inverse_depth, y + 2);
    AddStreamed(g->gradient, y + 1, &next);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF nx = hn::LoadU(d, g->normal[0].Row(y) + x);
      const VF ny = hn::LoadU(d, g->normal[1].Row(y) + x);
      const VF nz = hn::LoadU(d, g->normal[2].Row(y) + x);
      const VU id = hn::LoadU(du, g->id.Row(y) + x);
      const auto same = [&](int dx, int dy) HWY_ATTR {
        const VF cosine =
            hn::MulAdd(nx, hn::LoadU(d, g->normal[0].Row(y + dy) + x + dx),
                       hn::MulAdd(ny, hn::LoadU(d, g->normal[1].Row(y + dy) + x + dx),
                                  hn::Mul(nz, hn::LoadU(d, g->normal[2].Row(y + dy) + x + dx))));
        const auto same_id = hn::Eq(id, hn::LoadU(du, g->id.Row(y + dy) + x + dx));
        return hn::And(hn::Ge(cosine, hn::Set(d, kGradientMinCosine)), hn::RebindMask(d, same_id));
      };
      const auto i = [&](int dx, int dy)
                         HWY_ATTR { return hn::LoadU(d, g->inverse_depth.Row(y + dy) + x + dx); };
      StreamInRow(d, Gradient(i(-1, 0), i(0, 0), i(1, 0), same(-1, 0), same(1, 0)),
                  g->gradient[0].Row(y), x, width);
      StreamInRow(d, Gradient(i(0, -1), i(0, 0), i(0, 1), same(0, -1), same(0, 1)),
                  g->gradient[1].Row(y), x, width);
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

HWY_EXPORT(ConvertGuideRows);
HWY_EXPORT(GradientRows);

int64_t PrepareGuides(const PrepareGuidesInput& in, GuidePlanes* out) {
  std::atomic<int64_t> bad = 0;
  const int height = in.depth->height();
  ParallelRows(height, 32, [&](int y0, int y1) {
    bad += HWY_DYNAMIC_DISPATCH(ConvertGuideRows)(in, y0, y1, out);
  });
  ParallelRows(height, 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(GradientRows)(y0, y1, out);
  });
  return bad;
}

}  // namespace stillray::cpu
#endif
