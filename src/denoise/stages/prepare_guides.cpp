// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/prepare_guides.h"

#include <atomic>

#include "core/parallel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/prepare_guides.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/prepare_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

int64_t PrepareRows(const PrepareGuidesInput& in, int y0, int y1, GuidePlanes* out) {
  return PrepareRowsThen(in, true, y0, y1, out, [](int, const KeptRows&, const NextRow<32>&) {});
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(PrepareRows);

int64_t PrepareGuides(const PrepareGuidesInput& in, GuidePlanes* out) {
  std::atomic<int64_t> bad = 0;
  ParallelRows(in.depth->height(), 32,
               [&](int y0, int y1) { bad += HWY_DYNAMIC_DISPATCH(PrepareRows)(in, y0, y1, out); });
  return bad;
}

}  // namespace stillray::cpu
#endif
