// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/simd_math_test.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

float First(VF v) {
  return hn::GetLane(v);
}

void CheckExp2() {
  const DF d;
  double worst = 0;
  for (double x = -120; x <= 20; x += 0.00371) {
    const float in = static_cast<float>(x);
    const double exact = std::exp2(static_cast<double>(in));
    worst = std::max(worst, std::abs(First(Exp2(hn::Set(d, in))) / exact - 1.0));
  }
  EXPECT_LT(worst, 3e-7) << hwy::TargetName(HWY_TARGET);
  EXPECT_EQ(First(Exp2(hn::Set(d, 0.0f))), 1.0f);
  EXPECT_EQ(First(Exp2(hn::Set(d, -1000.0f))), 0.0f);
  EXPECT_EQ(First(Exp2(hn::Set(d, -HUGE_VALF))), 0.0f);
}

void CheckWeightExp2() {
  const DF d;
  double worst = 0;
  for (double x = -59.9; x < 99.0; x += 0.00037) {
    const float in = static_cast<float>(x);
    const double exact = std::exp2(static_cast<double>(in));
    worst = std::max(worst, std::abs(First(WeightExp2(hn::Set(d, in))) / exact - 1.0));
  }
  EXPECT_LT(worst, 1.5e-5) << hwy::TargetName(HWY_TARGET);
  EXPECT_EQ(First(WeightExp2(hn::Set(d, -60.5f))), 0.0f);
  EXPECT_EQ(First(WeightExp2(hn::Set(d, -1e30f))), 0.0f);
  EXPECT_EQ(First(WeightExp2(hn::Set(d, -HUGE_VALF))), 0.0f);
}

/// Negligible weights are small, not zero, and never NaN.
void CheckTinyWeights() {
  const DF d;
  const TinyIsZero tiny_is_zero;
  for (const float x : {-59.0f, -60.5f, -100.0f, -126.5f, -140.0f, -1e3f, -1e30f, -HUGE_VALF}) {
    const VF in[2] = {hn::Set(d, x), hn::Set(d, x)};
    VF out[2];
    WeightsExp2<true>(in, out);
    const float weight = First(out[1]);
    EXPECT_GE(weight, 0.0f) << x;
    EXPECT_LE(weight, 2 * std::exp2(std::max(x, -126.0f))) << x;
    EXPECT_TRUE(weight == 0 || std::isnormal(weight)) << x;
  }
}

void CheckLog2() {
  const DF d;
  double worst = 0;
  double worst_near_one = 0;
  for (double x = 1e-6; x < 1e4; x *= 1.00037) {
    const float in = static_cast<float>(x);
    const double exact = std::log2(static_cast<double>(in));
    const double error = std::abs(First(Log2(hn::Set(d, in))) - exact);
    worst = std::max(worst, error / std::max(1.0, std::abs(exact)));
    worst_near_one = std::abs(x - 1) < 0.05 ? std::max(worst_near_one, error) : worst_near_one;
  }
  EXPECT_LT(worst, 2e-7) << hwy::TargetName(HWY_TARGET);
  EXPECT_LT(worst_near_one, 1e-7) << hwy::TargetName(HWY_TARGET);
  EXPECT_EQ(First(Log2(hn::Set(d, 1.0f))), 0.0f);
  EXPECT_EQ(First(Log2(hn::Set(d, 8.0f))), 3.0f);
}

void CheckStoreInRow() {
  const DF d;
  for (int width = 1; width < 3 * LaneCount(); ++width) {
    std::vector<float> row(static_cast<size_t>(5 * LaneCount()), -1.0f);
    for (int x = 0; x < width; x += LaneCount()) {
      StoreInRow(d, ColumnsFrom(x), row.data(), x, width);
    }
    for (int x = 0; x < static_cast<int>(row.size()); ++x) {
      EXPECT_EQ(row[static_cast<size_t>(x)], x < width ? static_cast<float>(x) : -1.0f);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {

HWY_EXPORT(CheckExp2);
HWY_EXPORT(CheckWeightExp2);
HWY_EXPORT(CheckTinyWeights);
HWY_EXPORT(CheckLog2);
HWY_EXPORT(CheckStoreInRow);

/// Runs `check` on every instruction set of this machine.
template <typename Check>
void OnEveryTarget(const Check& check) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

TEST(SimdMath, Exp2) {
  OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckExp2)(); });
}
TEST(SimdMath, WeightExp2) {
  OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckWeightExp2)(); });
}
TEST(SimdMath, TinyWeights) {
  OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckTinyWeights)(); });
}
TEST(SimdMath, Log2) {
  OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckLog2)(); });
}
TEST(SimdMath, StoreInRowKeepsWhatLiesBeyond) {
  OnEveryTarget([] { HWY_DYNAMIC_DISPATCH(CheckStoreInRow)(); });
}

}  // namespace stillray
#endif
