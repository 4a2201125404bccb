// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/filter_taps.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "core/random.h"

namespace stillray::quality::filter_taps_test {
namespace {

template <typename T>
std::vector<T> Noise(size_t count, uint32_t seed) {
  std::vector<T> values;
  for (uint32_t i = 0; i < count; ++i) {
    values.push_back(static_cast<T>(UniformFloat(HashCombine(seed, i)) - 0.5f) / T(3));
  }
  return values;
}

/// Products rounded, then added in order: the exact result of every target. Widths cover blocks of
/// vectors, single vectors and the rest.
template <typename T>
void ExpectExact(int width, size_t stride) {
  const std::vector<T> kernel = Noise<T>(19, 1);
  const std::vector<T> in = Noise<T>(static_cast<size_t>(width) + 18 * stride, 2);
  std::vector<T> out(static_cast<size_t>(width) + 1, T(7));
  FilterTaps(in.data(), stride, kernel, width, out.data());
  for (size_t x = 0; x < static_cast<size_t>(width); ++x) {
    T sum = 0;
    for (size_t k = 0; k < kernel.size(); ++k) {
      const T product = kernel[k] * in[k * stride + x];
      sum = sum + product;
    }
    ASSERT_EQ(out[x], sum) << "width " << width << ", stride " << stride << ", x " << x;
  }
  EXPECT_EQ(out.back(), T(7)) << "wrote past the end";
}

TEST(FilterTaps, GivesTheSameBitsOnEveryTarget) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    for (const int width : {0, 1, 3, 4, 15, 16, 17, 64, 65, 100, 256}) {
      for (const size_t stride : {size_t{1}, size_t{300}}) {
        ExpectExact<float>(width, stride);
        ExpectExact<double>(width, stride);
      }
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace
}  // namespace stillray::quality::filter_taps_test
