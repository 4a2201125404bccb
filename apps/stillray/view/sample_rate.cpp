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
constexpr double kSmallShare = 0.2;  // of a frame's time: fewer samples would hardly be felt
constexpr int kFramesToJudge = 3;
constexpr double kUseless = 0.8;  // paths take at least this part of the time they took before
constexpr int kFramesToHold = 90;
constexpr double kFarTooLate = 1.6;  // one frame of this kind is enough
// A change of resolution starts all histories anew: it must be worth it for a while.
constexpr int kFramesToShrink = 4;
constexpr double kSpareToGrow = 0.75;
// What is taken back within so many frames was a mistake.
constexpr int kTrial = 90;
constexpr int kLongestPatience = 1500;
constexpr int kLastPart = static_cast<int>(std::size(RateControl::kParts)) - 1;

double AreaOf(int part, int now) {
  const double factor = double{RateControl::kParts[part]} / double{RateControl::kParts[now]};
  return factor * factor;
}

double PathsOf(const FrameCost& cost) {
  return std::max(cost.trace_ms - cost.fixed_ms, 0.0);
}

/// The highest rate, at most `rate`, with which a picture of `area` times as many pixels takes
/// `limit_ms`; the lowest one, and false, if none does.
bool HighestRate(const FrameCost& cost, const SampleRate& rate, double area, double limit_ms,
                 SampleRate* fitting) {
  *fitting = rate;
  const double floor = (cost.filter_ms + std::min(cost.fixed_ms, cost.trace_ms)) * area;
  const auto total = [&] { return floor + PathsOf(cost) * area * fitting->value() / rate.value(); };
  while (total() > limit_ms && fitting->cycle < kMaxCycle) {
    *fitting = Halved(*fitting);
  }
  return total() <= limit_ms;
}

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

void RateControl::Patience::Age() {
  if (since >= 0 && ++since > kTrial) {
    since = -1;
    frames = std::max(least, frames / 2);
  }
}

void RateControl::Patience::TakenBack() {
  frames = since >= 0 ? std::min(frames * 3, kLongestPatience) : frames;
  since = -1;
}

void RateControl::ChooseScale(float scale, bool may_fall) {
  if (scale != chosen_ || (!may_fall && part_ != 0)) {
    part_ = may_fall ? part_ : 0;
    grow_ = Patience{grow_.least};
    Changed();
  }
  chosen_ = scale;
  may_fall_ = may_fall;
}

/// Costs seen so far are of another rate or size.
void RateControl::Changed() {
  over_ = under_ = roomy_ = 0;
  least_ = {};
}

void RateControl::Observe(const FrameCost& cost, double target_ms) {
  JudgeLastFall(cost);
  rise_.Age();
  grow_.Age();
  const double total = cost.total();
  const bool late = total > target_ms * kLate;
  least_ = late && over_ > 0 && least_.total() < total ? least_ : cost;
  over_ = late ? over_ + 1 : 0;
  under_ = total + PathsOf(cost) <= target_ms * kSpare ? under_ + 1 : 0;
  SampleRate grown;
  roomy_ = FitsWhenGrown(cost, target_ms, &grown) ? roomy_ + 1 : 0;
  const bool far_too_late = total > target_ms * kFarTooLate;
  if ((over_ >= kFramesToFall || far_too_late) && LowerRate(least_, target_ms)) {
    rise_.TakenBack();
    Changed();
  } else if (over_ >= (far_too_late ? kFramesToFall : kFramesToShrink) && may_fall_ &&
             part_ < kLastPart) {
    Shrink(least_, target_ms);
  } else if (roomy_ >= grow_.frames) {
    --part_;
    rate_ = grown;
    paths_before_fall_ = 0;
    grow_.Try();
    Changed();
  } else if (under_ >= rise_.frames && !(Doubled(rate_) == rate_)) {
    rate_ = Doubled(rate_);
    rise_.Try();
    under_ = over_ = 0;
  }
}

bool RateControl::LowerRate(const FrameCost& cost, double target_ms) {
  const bool judging = paths_before_fall_ > 0;
  if (judging || hold_ > 0 || PathsOf(cost) < kSmallShare * cost.total()) {
    return false;  // fewer samples would not make a faster picture
  }
  SampleRate lower;
  HighestRate(cost, rate_, 1, target_ms, &lower);
  if (lower == rate_) {
    return false;
  }
  before_fall_ = rate_;
  paths_before_fall_ = PathsOf(cost);
  since_fall_ = 0;
  rate_ = lower;
  return true;
}

void RateControl::Shrink(const FrameCost& cost, double target_ms) {
  SampleRate rate;
  const int now = part_;
  do {
    ++part_;
  } while (!HighestRate(cost, rate_, AreaOf(part_, now), target_ms, &rate) && part_ < kLastPart);
  rate_ = rate;
  paths_before_fall_ = 0;  // smaller pictures are traced faster in any case
  grow_.TakenBack();
  Changed();
}

bool RateControl::FitsWhenGrown(const FrameCost& cost, double target_ms, SampleRate* rate) const {
  return part_ > 0 &&
         HighestRate(cost, rate_, AreaOf(part_ - 1, part_), target_ms * kSpareToGrow, rate);
}

void RateControl::JudgeLastFall(const FrameCost& cost) {
  hold_ = std::max(hold_ - 1, 0);
  if (paths_before_fall_ <= 0 || ++since_fall_ < kFramesToJudge) {
    return;
  }
  if (PathsOf(cost) > kUseless * paths_before_fall_ && rate_.value() < before_fall_.value()) {
    rate_ = before_fall_;
    over_ = under_ = 0;
    hold_ = kFramesToHold;
  }
  paths_before_fall_ = 0;
}

}  // namespace stillray::view
