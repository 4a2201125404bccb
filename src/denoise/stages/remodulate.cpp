// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/remodulate.h"

#include <atomic>

#include "core/colour_shared.h"
#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/remodulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void RemodulateRows(const Image3& light, const Image3* albedo_a, const Image3* albedo_b, int y0,
                    int y1, Image3* sum) {
  const DF d;
  const int width = sum->width();
  for (int c = 0; c < 3; ++c) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; x += LaneCount()) {
        const VF in = hn::LoadU(d, light[c].Row(y) + x);
        const VF before = hn::LoadU(d, (*sum)[c].Row(y) + x);
        VF albedo = hn::Zero(d);
        for (const Image3* part : {albedo_a, albedo_b}) {
          albedo = part != nullptr ? hn::Add(albedo, hn::LoadU(d, (*part)[c].Row(y) + x)) : albedo;
        }
        const bool multiply = albedo_a != nullptr || albedo_b != nullptr;
        const VF factor = multiply ? hn::Max(albedo, hn::Set(d, kAlbedoFloor)) : hn::Set(d, 1.0f);
        StoreInRow(d, hn::MulAdd(in, factor, before), (*sum)[c].Row(y), x, width);
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

void Remodulate(const Image3& light, const Image3* albedo_a, const Image3* albedo_b, Image3* sum) {
  ParallelRows(sum->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(RemodulateRows)(light, albedo_a, albedo_b, y0, y1, sum);
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
