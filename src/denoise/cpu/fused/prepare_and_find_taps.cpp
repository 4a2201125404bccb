// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/fused/fused.h"

#include <atomic>

#include "core/parallel.h"
#include "denoise/simd/find_taps_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/cpu/fused/prepare_and_find_taps.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/prepare_rows-inl.h"

#ifndef STILLRAY_PREPARE_AND_FIND_TAPS_ONCE
#define STILLRAY_PREPARE_AND_FIND_TAPS_ONCE
namespace stillray {

/// Arguments of FindTapsRow other than the guides of this frame.
struct WantedTaps {
  const GuidePlanes& before;
  const Image2& motion;
  const ReprojectParameters& p;
  ReprojectionTaps* taps;
};

}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

int64_t PrepareAndFindTapsRows(const PrepareGuidesInput& in, const WantedTaps& wanted, int y0,
                               int y1, GuidePlanes* out) {
  return PrepareRowsThen(
      in, false, y0, y1, out, [&](int y, const KeptRows& kept, const NextRow<32>& next) {
        const GuidesOfRow now = {{kept.normal(0, y), kept.normal(1, y), kept.normal(2, y)},
                                 kept.inverse_depth(y),
                                 {kept.gradient(0), kept.gradient(1)},
                                 kept.id(y)};
        cpu::FindTapsRow(now, wanted.before, wanted.motion, wanted.p, y, next, wanted.taps);
      });
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrepareAndFindTapsRows);

int64_t PrepareAndFindTaps(const PrepareGuidesInput& in, const GuidePlanes& before,
                           const Image2& motion, const ReprojectParameters& p, GuidePlanes* out,
                           ReprojectionTaps* taps) {
  BeginTaps(taps);
  const WantedTaps wanted = {before, motion, p, taps};
  std::atomic<int64_t> bad = 0;
  ParallelRows(in.depth->height(), 32, [&](int y0, int y1) {
    bad += HWY_DYNAMIC_DISPATCH(PrepareAndFindTapsRows)(in, wanted, y0, y1, out);
  });
  return bad;
}

}  // namespace stillray::cpu
#endif
