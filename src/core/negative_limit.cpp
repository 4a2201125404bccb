// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/negative_limit.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/negative_limit_shared.h"
#include "core/parallel.h"

namespace stillray {
namespace {

using Histogram = std::array<uint32_t, STILLRAY_LIGHT_BINS>;

/// The radiance to measure, and the pixels with samples.
struct Measured {
  std::array<const Image3*, kSignalKindCount> lights = {};
  int count = 0;
  const Image1* samples = nullptr;
  int stride = 1;
};

/// The largest component of all radiance at a pixel; NaN if any component is not finite.
float BrightestLight(const Measured& of, int x, int y) {
  float brightest = 0;
  for (int i = 0; i < of.count; ++i) {
    for (int c = 0; c < 3; ++c) {
      const float light = (*of.lights[static_cast<size_t>(i)])[c](x, y);
      if (!std::isfinite(light)) {
        return NAN;
      }
      brightest = std::max(brightest, light);
    }
  }
  return brightest;
}

void MeasureRow(const Measured& of, int y, Histogram* bins) {
  for (int x = of.stride / 2; x < of.lights[0]->width(); x += of.stride) {
    const bool sampled = of.samples == nullptr || (*of.samples)(x, y) > 0;
    const float light = sampled ? BrightestLight(of, x, y) : NAN;
    if (!std::isnan(light)) {
      ++(*bins)[LightBin(std::bit_cast<uint32_t>(light))];
    }
  }
}

/// Same as in update_exposure.comp.
float MeanLight(const Histogram& bins) {
  uint32_t measured = 0;
  for (const uint32_t count : bins) {
    measured += count;
  }
  const uint32_t brightest = BrightestPixels(measured);
  uint32_t waiting = 0;  // brightest pixels, which count as the next one
  uint32_t passed = 0;
  int dimmest = 0;
  float sum = 0;
  for (int bin = STILLRAY_LIGHT_BINS - 1; bin > 0; --bin) {
    const uint32_t count = bins[static_cast<size_t>(bin)];
    if (count == 0) {
      continue;
    }
    dimmest = bin;
    passed += count;
    waiting += count;
    if (passed > brightest) {
      sum += static_cast<float>(waiting) * LightOfBin(bin);
      waiting = 0;
    }
  }
  sum += static_cast<float>(waiting) * LightOfBin(dimmest);
  return measured > 0 ? sum / static_cast<float>(measured) : 0.0f;
}

float LimitOf(const Measured& of) {
  if (of.count == 0) {
    return 0;
  }
  std::array<std::atomic<uint32_t>, STILLRAY_LIGHT_BINS> total = {};
  const int rows = (of.lights[0]->height() - of.stride / 2 + of.stride - 1) / of.stride;
  ParallelRows(rows, 16, [&](int first, int last) {
    Histogram bins = {};
    for (int i = first; i < last; ++i) {
      MeasureRow(of, i * of.stride + of.stride / 2, &bins);
    }
    for (size_t i = 0; i < bins.size(); ++i) {
      if (bins[i] != 0) {
        total[i].fetch_add(bins[i], std::memory_order_relaxed);
      }
    }
  });
  Histogram bins;
  std::transform(total.begin(), total.end(), bins.begin(),
                 [](const std::atomic<uint32_t>& count) { return count.load(); });
  return NegativeLimit(MeanLight(bins));
}

}  // namespace

float NegativeLimitOf(const Frame& frame, bool sparse) {
  Measured of;
  for (const Signal& signal : frame.signals) {
    of.lights[static_cast<size_t>(of.count++)] = &signal.radiance;
  }
  of.samples = frame.samples.empty() ? nullptr : &frame.samples;
  of.stride = MeasureStride(frame.width, frame.height, sparse);
  return LimitOf(of);
}

float NegativeLimitOf(const Image3& light) {
  Measured of;
  of.lights[0] = &light;
  of.count = 1;
  of.stride = MeasureStride(light.width(), light.height(), false);
  return LimitOf(of);
}

}  // namespace stillray
