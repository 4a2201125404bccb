// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The number of samples per pixel and frame.
#pragma once

#include <string>

#include "stillray/render.h"

namespace stillray::view {

/// spp / cycle samples per pixel and frame, as in RenderSettings; at least one of the two is 1.
struct SampleRate {
  int spp = 1;
  int cycle = 1;

  double value() const { return static_cast<double>(spp) / cycle; }
  bool operator==(const SampleRate&) const = default;
};

inline constexpr int kMaxLiveSpp = 64;  ///< limits the latency of the response to input

/// "4", "1/8".
std::string ToText(const SampleRate& rate);

/// The next power of two above and below; both are clamped to 1/256 .. kMaxLiveSpp.
SampleRate Doubled(const SampleRate& rate);
SampleRate Halved(const SampleRate& rate);

}  // namespace stillray::view
