// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "bench/machine_limits.h"

#include <algorithm>
#include <cstring>

#include <tbb/parallel_for.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/machine_limits.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "core/clock.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// Number of independent chains: at least latency times FMA units of all current x86 and ARM cores.
constexpr int kChains = 12;

/// \return number of multiply-adds; `sink` prevents dead code elimination
int64_t MultiplyAdd(int64_t rounds, float* sink) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const V factor = hn::Set(d, *sink * 1e-9f + 0.999f);
  const V term = hn::Set(d, 1e-3f);
  // Different values, so that the compiler cannot merge the chains.
  const auto start = [&](float value) HWY_ATTR { return hn::Set(d, *sink + value); };
  V c0 = start(0), c1 = start(1), c2 = start(2), c3 = start(3), c4 = start(4), c5 = start(5);
  V c6 = start(6), c7 = start(7), c8 = start(8), c9 = start(9), c10 = start(10), c11 = start(11);
  for (int64_t i = 0; i < rounds; ++i) {
    c0 = hn::MulAdd(c0, factor, term);
    c1 = hn::MulAdd(c1, factor, term);
    c2 = hn::MulAdd(c2, factor, term);
    c3 = hn::MulAdd(c3, factor, term);
    c4 = hn::MulAdd(c4, factor, term);
    c5 = hn::MulAdd(c5, factor, term);
    c6 = hn::MulAdd(c6, factor, term);
    c7 = hn::MulAdd(c7, factor, term);
    c8 = hn::MulAdd(c8, factor, term);
    c9 = hn::MulAdd(c9, factor, term);
    c10 = hn::MulAdd(c10, factor, term);
    c11 = hn::MulAdd(c11, factor, term);
  }
  const V a = hn::Add(hn::Add(hn::Add(c0, c1), hn::Add(c2, c3)), hn::Add(c4, c5));
  const V b = hn::Add(hn::Add(hn::Add(c6, c7), hn::Add(c8, c9)), hn::Add(c10, c11));
  *sink = hn::GetLane(hn::Add(a, b));
  return rounds * kChains * static_cast<int64_t>(hn::Lanes(d));
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {
namespace {

HWY_EXPORT(MultiplyAdd);

}  // namespace

const char* InstructionSet() {
  const int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  return hwy::TargetName(targets & -targets);  // the lowest bit is the best target
}

double MultiplyAddsPerSecond() {
  float sink = 1;
  const Clock::time_point start = Clock::now();
  int64_t done = 0;
  while (SecondsSince(start) < 2e-3) {
    done += HWY_DYNAMIC_DISPATCH(MultiplyAdd)(2000, &sink);
  }
  return static_cast<double>(done) / SecondsSince(start);
}

CopyTest::CopyTest(size_t bytes) : from_(bytes / 2, 1), to_(bytes / 2, 0) {}

double CopyTest::Run() {
  const size_t n = from_.size();
  const size_t block = size_t{1} << 20;
  const Clock::time_point start = Clock::now();
  tbb::parallel_for(size_t{0}, (n + block - 1) / block, [&](size_t i) {
    std::memcpy(to_.data() + i * block, from_.data() + i * block, std::min(block, n - i * block));
  });
  return MillisecondsSince(start);
}

}  // namespace stillray
#endif
