// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/filter_taps.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "quality/filter_taps.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillray::quality {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// `kVectors` independent sums at a time, to hide the latency of additions. Returns the first
/// position not yet done.
template <int kVectors, typename T>
size_t FilterVectors(const T* HWY_RESTRICT in, size_t stride, const T* HWY_RESTRICT kernel,
                     size_t taps, size_t x, size_t width, T* HWY_RESTRICT out) {
  const hn::ScalableTag<T> d;
  const size_t lanes = hn::Lanes(d);
  for (; x + kVectors * lanes <= width; x += kVectors * lanes) {
    auto sum0 = hn::Zero(d);
    auto sum1 = hn::Zero(d);
    auto sum2 = hn::Zero(d);
    auto sum3 = hn::Zero(d);
    for (size_t k = 0; k < taps; ++k) {
      const auto weight = hn::Set(d, kernel[k]);
      const T* tap = in + k * stride + x;
      sum0 = hn::Add(sum0, hn::Mul(weight, hn::LoadU(d, tap)));
      if constexpr (kVectors == 4) {
        sum1 = hn::Add(sum1, hn::Mul(weight, hn::LoadU(d, tap + lanes)));
        sum2 = hn::Add(sum2, hn::Mul(weight, hn::LoadU(d, tap + 2 * lanes)));
        sum3 = hn::Add(sum3, hn::Mul(weight, hn::LoadU(d, tap + 3 * lanes)));
      }
    }
    hn::StoreU(sum0, d, out + x);
    if constexpr (kVectors == 4) {
      hn::StoreU(sum1, d, out + x + lanes);
      hn::StoreU(sum2, d, out + x + 2 * lanes);
      hn::StoreU(sum3, d, out + x + 3 * lanes);
    }
  }
  return x;
}

template <typename T>
void Filter(const T* HWY_RESTRICT in, size_t stride, const T* HWY_RESTRICT kernel, size_t taps,
            size_t width, T* HWY_RESTRICT out) {
  size_t x = FilterVectors<4>(in, stride, kernel, taps, 0, width, out);
  x = FilterVectors<1>(in, stride, kernel, taps, x, width, out);
  for (; x < width; ++x) {
    T sum = 0;
    for (size_t k = 0; k < taps; ++k) {
      sum += kernel[k] * in[k * stride + x];
    }
    out[x] = sum;
  }
}

void FilterFloat(const float* in, size_t stride, const float* kernel, size_t taps, size_t width,
                 float* out) {
  Filter(in, stride, kernel, taps, width, out);
}

void FilterDouble(const double* in, size_t stride, const double* kernel, size_t taps, size_t width,
                  double* out) {
  Filter(in, stride, kernel, taps, width, out);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray::quality
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::quality {

HWY_EXPORT(FilterFloat);
HWY_EXPORT(FilterDouble);

void FilterTaps(const float* in, size_t stride, const std::vector<float>& kernel, int width,
                float* out) {
  HWY_DYNAMIC_DISPATCH(FilterFloat)
  (in, stride, kernel.data(), kernel.size(), static_cast<size_t>(width), out);
}

void FilterTaps(const double* in, size_t stride, const std::vector<double>& kernel, int width,
                double* out) {
  HWY_DYNAMIC_DISPATCH(FilterDouble)
  (in, stride, kernel.data(), kernel.size(), static_cast<size_t>(width), out);
}

}  // namespace stillray::quality
#endif  // HWY_ONCE
