// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace stillray::view {
namespace {

template <typename T>
bool ParseWhole(std::string_view text, T* out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

std::string ToText(const SampleRate& rate) {
  return rate.cycle > 1 ? fmt::format("{}/{}", rate.spp, rate.cycle) : fmt::format("{}", rate.spp);
}

Result<SampleRate> ParseSampleRate(std::string_view text) {
  SampleRate rate;
  const size_t slash = text.find('/');
  double value = 0;
  bool parsed = false;
  if (slash != std::string_view::npos) {
    parsed = ParseWhole(text.substr(0, slash), &rate.spp) && rate.spp == 1 &&
             ParseWhole(text.substr(slash + 1), &rate.cycle);
  } else if (ParseWhole(text, &rate.spp)) {
    parsed = true;
  } else if (ParseWhole(text, &value) && value > 0 && value < 1) {
    rate = {1, static_cast<int>(std::lround(std::min(1.0 / value, 1e6)))};
    parsed = std::abs(rate.cycle * value - 1.0) < 1e-3;
  }
  if (!parsed || rate.spp < 1 || rate.spp > 65536 || rate.cycle < 1 || rate.cycle > kMaxCycle) {
    return Status::InvalidArgument(fmt::format(
        "samples per pixel are '{}', expected a whole number up to 65536, or 1/2 to 1/{}", text,
        kMaxCycle));
  }
  return rate;
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
