// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Computed input planes for tests of single stages.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "core/random.h"
#include "denoise/plan.h"
#include "denoise/planes.h"
#include "denoise/stages/prepare_guides.h"

namespace stillray::test {

inline constexpr int kWidth = 83;
inline constexpr int kHeight = 37;

inline float Random(int x, int y, uint32_t what) {
  return UniformFloat(
      HashCombine(HashCombine(static_cast<uint32_t>(x), static_cast<uint32_t>(y)), what));
}

/// Of a frame that has a history, with the preset "default".
inline const FramePlan& DefaultPlan() {
  static const FramePlan plan = MakePlan(Settings(), FrameFacts(), {.has_history = true});
  return plan;
}

/// A wall and some sky; a few pixels of the frame before show something behind it.
inline GuidePlanes MakeGuides(bool now) {
  Image1 depth(kWidth, kHeight);
  Image3 normal(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool sky = y < 3 || Random(x / 9, y / 9, 1) < 0.1f;
      const bool changed = !now && Random(x, y, 2) < 0.01f;
      depth(x, y) = sky ? std::numeric_limits<float>::infinity() : changed ? 9.0f : 4.0f;
      normal[2](x, y) = sky ? 0.0f : 1.0f;
    }
  }
  GuidePlanes guides(kWidth, kHeight, 16);
  guides.turn2 = Image1(kWidth, kHeight);
  cpu::PrepareGuides({&depth, &normal, nullptr}, &guides);
  return guides;
}

/// \param lit_alone  pixels without samples have no light
inline SignalHistory MakeHistory(bool lit_alone) {
  SignalHistory history(kWidth, kHeight, true, true, 16);
  history.compressed_scale = 0.5f;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool lit = Random(x, y, 3) < 0.7f;
      history.length(x, y) = lit ? 1.0f + std::floor(5 * Random(x, y, 4)) : 0.0f;
      for (uint32_t c = 0; c < 3; ++c) {
        history.colour[static_cast<int>(c)](x, y) = lit || !lit_alone ? Random(x, y, 5 + c) : 0.0f;
        history.behind[static_cast<int>(c)](x, y) = lit || !lit_alone ? Random(x, y, 8 + c) : 0.0f;
      }
      history.mean(x, y) = lit ? Random(x, y, 11) : 0.0f;
      history.variance(x, y) = lit ? Random(x, y, 12) : 0.0f;
      history.weights2(x, y) = lit ? Random(x, y, 13) : 0.0f;
      history.compressed(x, y) = lit ? Random(x, y, 14) : 0.0f;
    }
  }
  return history;
}

/// \param lit   share of the pixels that have a sample
/// \param seed  of a signal
inline NewLight MakeLight(float lit = 0.03f, uint32_t seed = 20) {
  NewLight light = {LumaImage3(kWidth, kHeight), Image1(kWidth, kHeight), Image1()};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (Random(x, y, seed) < lit) {
        light.samples(x, y) = 1;
        for (uint32_t c = 0; c < 3; ++c) {
          light.colour[static_cast<int>(c)](x, y) = 3 * Random(x, y, seed + 1 + c);
        }
      }
    }
  }
  return light;
}

/// How many pixels are not the same.
template <typename T>
int DifferentBits(const Plane<T>& a, const Plane<T>& b) {
  int count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      // A zero that keeps its sign is no other number.
      count += a(x, y) != b(x, y) ? 1 : 0;
    }
  }
  return count;
}

template <typename T, int N, typename Basis>
int DifferentBits(const Planes<T, N, Basis>& a, const Planes<T, N, Basis>& b) {
  int count = 0;
  for (int c = 0; c < N; ++c) {
    count += DifferentBits(a[c], b[c]);
  }
  return count;
}

}  // namespace stillray::test
