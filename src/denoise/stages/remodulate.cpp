// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/remodulate.h"

#include <atomic>

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/remodulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void RemodulateRows(const Image3& light, const AlbedoSum& albedo, const RemodulateParameters& p,
                    int y0, int y1, Image3* sum) {
  const DF d;
  const int width = sum->width();
  for (int y = y0; y < y1; ++y) {
    NextRow<20> next;
    next.Add(light, y + 1);
    for (int i = 0; i < albedo.count; ++i) {
      next.Add(*albedo.part[i], y + 1);
    }
    next.Add(*sum, y + 1);
    for (int x = 0; x < width; x += LaneCount()) {
      next.Fetch(x);
      const VF r = hn::LoadU(d, light[1].Row(y) + x);
      const VF b = hn::LoadU(d, light[2].Row(y) + x);
      const VF rgb[3] = {r, Green(hn::LoadU(d, light[0].Row(y) + x), r, b, p.rec601), b};
      for (int c = 0; c < 3; ++c) {
        VF factor = hn::Set(d, 1.0f);
        if (albedo.count > 0) {
          factor = hn::LoadU(d, (*albedo.part[0])[c].Row(y) + x);
          for (int i = 1; i < albedo.count; ++i) {
            factor = hn::Add(factor, hn::LoadU(d, (*albedo.part[i])[c].Row(y) + x));
          }
          factor = hn::Max(factor, hn::Set(d, kAlbedoFloor));
        }
        float* to = (*sum)[c].Row(y);
        const VF before = p.add ? hn::LoadU(d, to + x) : hn::Zero(d);
        StoreInRow(d, hn::MulAdd(rgb[c], factor, before), to, x, width);
      }
    }
  }
}

int64_t AddUnfilteredRows(const Image3& light, int y0, int y1, Image3* sum) {
  const DF d;
  const int width = sum->width();
  int64_t bad = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      VF in[3];
      MF finite = InRow(x, width);
      for (int c = 0; c < 3; ++c) {
        in[c] = hn::LoadU(d, light[c].Row(y) + x);
        finite = hn::And(finite, IsFiniteLane(in[c]));
      }
      for (int c = 0; c < 3; ++c) {
        const VF before = hn::LoadU(d, (*sum)[c].Row(y) + x);
        StoreInRow(d, hn::Add(before, hn::IfThenElseZero(finite, in[c])), (*sum)[c].Row(y), x,
                   width);
      }
      bad += static_cast<int64_t>(hn::CountTrue(d, hn::AndNot(finite, InRow(x, width))));
    }
  }
  return bad;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(RemodulateRows);
HWY_EXPORT(AddUnfilteredRows);

void Remodulate(const Image3& light, const AlbedoSum& albedo, const RemodulateParameters& p,
                Image3* sum) {
  ParallelRows(sum->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(RemodulateRows)(light, albedo, p, y0, y1, sum);
  });
}

int64_t AddUnfiltered(const Image3& light, Image3* sum) {
  std::atomic<int64_t> bad = 0;
  ParallelRows(sum->height(), 32, [&](int y0, int y1) {
    bad += HWY_DYNAMIC_DISPATCH(AddUnfilteredRows)(light, y0, y1, sum);
  });
  return bad;
}

}  // namespace stillray::cpu
#endif
