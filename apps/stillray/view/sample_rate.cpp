// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <algorithm>
#include <bit>

namespace stillray::view {

std::string ToText(const SampleRate& rate) {
  RenderSettings settings;
  settings.spp = rate.spp;
  settings.cycle = rate.cycle;
  return GetRenderParameter(settings, "spp").value();
}

SampleRate Doubled(const SampleRate& rate) {
  if (rate.cycle > 1) {
    return {1, static_cast<int>(std::bit_floor(static_cast<unsigned>(rate.cycle - 1)))};
  }
  const int next = static_cast<int>(std::bit_floor(static_cast<unsigned>(rate.spp))) * 2;
  return {std::max(rate.spp, std::min(next, kMaxLiveSpp)), 1};
}

SampleRate Halved(const SampleRate& rate) {
  if (rate.spp > 1) {
    return {static_cast<int>(std::bit_ceil(static_cast<unsigned>(rate.spp))) / 2, 1};
  }
  const int next = static_cast<int>(std::bit_floor(static_cast<unsigned>(rate.cycle))) * 2;
  return {1, std::min(next, kMaxCycle)};
}

}  // namespace stillray::view
