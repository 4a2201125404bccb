// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/mix_pilot.h"

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/mix_pilot.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/mix_pilot-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void MixPilotRows(const MixPilotInput& in, float full, int y0, int y1, Image1* luminance,
                  Image1* variance) {
  const DF d;
  const int width = luminance->width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const auto load = [&](const Image1& plane)
                            HWY_ATTR { return hn::LoadU(d, plane.Row(y) + x); };
      const PilotValue pilot =
          MixedPilot({load(*in.luminance), load(*in.variance)}, {load(*luminance), load(*variance)},
                     load(*in.length), full);
      StoreInRow(d, pilot.luminance, luminance->Row(y), x, width);
      StoreInRow(d, pilot.variance, variance->Row(y), x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(MixPilotRows);

void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance) {
  ParallelRows(luminance->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MixPilotRows)(in, full, y0, y1, luminance, variance);
  });
}

}  // namespace stillray::cpu
#endif
