// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/sample_rate.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace stillray::view {
namespace {

// A frame may be late by a tenth before anything changes, and twice the samples must fit with a
// tenth to spare: the gap between both keeps the rate from swinging.
constexpr double kLate = 1.1;
constexpr double kSpare = 0.9;
constexpr int kFramesToFall = 2;
constexpr int kFramesToRise = 4;
constexpr double kSmallShare = 0.2;  // of a frame's time: less tracing would hardly be felt
constexpr int kFramesToJudge = 3;
constexpr double kUseless = 0.8;  // tracing takes at least this part of the time it took before
constexpr int kFramesToHold = 90;
constexpr double kFarTooLate = 1.6;  // one frame of this kind is enough
// A change of resolution starts all histories anew: it must be worth it for a while.
constexpr int kFramesToGrow = 40;
constexpr double kFilterSpareToGrow = 0.6;
constexpr double kRateToGrow = 1.0 / 4;  // above it, pixels are worth more than samples

template <typename T>
bool ParseWhole(std::string_view text, T* out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *out);
  return error == std::errc() && end == text.data() + text.size();
}

const float* NextScale(float scale) {
  return std::find_if(std::begin(RateControl::kScales), std::end(RateControl::kScales),
                      [&](float s) { return s > scale * 1.01f; });
}

float SmallerScale(float scale) {
  float best = RateControl::kScales[0];
  for (const float s : RateControl::kScales) {
    best = s < scale * 0.99f ? s : best;
  }
  return best;
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

void RateControl::set_scale(float scale) {
  if (scale != scale_) {
    over_ = under_ = roomy_ = 0;
  }
  scale_ = scale;
}

void RateControl::Observe(const FrameCost& cost, double target_ms, bool auto_scale) {
  JudgeLastFall(cost);
  const double total = cost.total();
  over_ = total > target_ms * kLate ? over_ + 1 : 0;
  under_ = cost.filter_ms + 2 * cost.trace_ms <= target_ms * kSpare ? under_ + 1 : 0;
  const float* larger = NextScale(scale_);
  const double growth = larger == std::end(kScales) ? 0 : std::pow(*larger / scale_, 2.0f);
  // A larger picture begins with half the samples for each of its pixels.
  const bool roomy = growth > 0 && rate_.value() >= kRateToGrow &&
                     cost.filter_ms * growth <= target_ms * kFilterSpareToGrow &&
                     (cost.filter_ms + cost.trace_ms / 2) * growth <= target_ms * kSpare;
  roomy_ = roomy ? roomy_ + 1 : 0;
  if (over_ >= kFramesToFall || total > target_ms * kFarTooLate) {
    Slower(cost, target_ms, auto_scale);
  } else if (under_ >= kFramesToRise || roomy_ >= kFramesToGrow) {
    Faster(auto_scale);
  }
}

void RateControl::Slower(const FrameCost& cost, double target_ms, bool auto_scale) {
  over_ = under_ = roomy_ = 0;
  const bool few_samples = Halved(rate_).value() < kSmallestGoodRate;
  // Where the filter alone takes most of the time, fewer samples would gain nothing.
  const bool filter_bound = cost.filter_ms > 0.8 * target_ms;
  if (auto_scale && (few_samples || filter_bound) && scale_ > kScales[0]) {
    scale_ = SmallerScale(scale_);
    trace_before_fall_ = 0;  // smaller pictures are traced faster in any case
    return;
  }
  const bool judging = trace_before_fall_ > 0;
  if (judging || hold_ > 0 || cost.trace_ms < kSmallShare * cost.total()) {
    return;  // a worse picture would not be a faster one
  }
  SampleRate lower = Halved(rate_);
  double trace = cost.trace_ms / 2;
  while (cost.filter_ms + trace > target_ms && lower.cycle < kMaxCycle &&
         !(auto_scale && Halved(lower).value() < kSmallestGoodRate)) {
    lower = Halved(lower);
    trace /= 2;
  }
  before_fall_ = rate_;
  trace_before_fall_ = cost.trace_ms;
  since_fall_ = 0;
  rate_ = lower;
}

void RateControl::JudgeLastFall(const FrameCost& cost) {
  hold_ = std::max(hold_ - 1, 0);
  if (trace_before_fall_ <= 0 || ++since_fall_ < kFramesToJudge) {
    return;
  }
  if (cost.trace_ms > kUseless * trace_before_fall_ && rate_.value() < before_fall_.value()) {
    rate_ = before_fall_;
    over_ = under_ = 0;
    hold_ = kFramesToHold;
  }
  trace_before_fall_ = 0;
}

void RateControl::Faster(bool auto_scale) {
  if (auto_scale && roomy_ >= kFramesToGrow) {
    set_scale(*NextScale(scale_));
    rate_ = Halved(rate_);
    return;
  }
  if (under_ >= kFramesToRise) {
    under_ = 0;
    rate_ = Doubled(rate_);
  }
}

}  // namespace stillray::view
