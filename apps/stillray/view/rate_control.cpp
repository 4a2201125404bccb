// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/rate_control.h"

#include <iterator>

#include "stillray/render.h"

namespace stillray::view {
namespace {

/// Deadband of the sample rate: the rate is reduced if frames are more than 10% late, and raised if
/// twice the samples would fit with a margin of 10%.
constexpr double kLate = 1.1;
constexpr double kSpare = 0.9;
constexpr int kFramesToFall = 2;
/// fraction of the frame time below which fewer samples save little time
constexpr double kSmallShare = 0.2;
constexpr int kFramesToJudge = 3;
/// a reduction is useless if paths take at least this fraction of their former time
constexpr double kUseless = 0.8;
constexpr int kFramesToHold = 90;
constexpr double kFarTooLate = 1.6;  // a single such frame is enough
constexpr int kFramesToShrink = 4;
constexpr double kSpareToGrow = 0.75;
/// A change that is reverted within this many frames counts as a mistake.
constexpr int kTrial = 90;
constexpr int kLongestPatience = 1500;
constexpr int kLastPart = static_cast<int>(std::size(RateControl::kParts)) - 1;
/// At lower sample rates the chosen filter, designed for one sample per pixel, is not worth its
/// cost.
constexpr int kLongestCycleOfChosen = 16;
constexpr SampleRate kFirstFastRate = {1, 64};
/// Maximum time of a refining frame, as a multiple of the target. Motion cancels the frame; the
/// limit bounds the time to the next image.
constexpr double kRefineTargets = 20;
/// In a refining view tracing may take as long as the filter, which at most halves the frame rate.
/// The gap between both limits is the deadband.
constexpr double kShareToRise = 0.8;
constexpr double kShareToFall = 1.2;

double AreaOf(int part, int now) {
  const double factor = double{RateControl::kParts[part]} / double{RateControl::kParts[now]};
  return factor * factor;
}

}  // namespace

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

FramePlan RateControl::Next(const RateChoice& choice, bool moves, bool attended) {
  if (choice.scale != choice_.scale || (!choice.auto_scale && part_ != 0)) {
    part_ = choice.auto_scale ? part_ : 0;
    grow_ = Patience{grow_.least};
    Changed();
  }
  choice_ = choice;
  if (fast_ && !MayUseFastFilter()) {
    fast_ = false;
    filter_ = Patience{filter_.least};
    Changed();
  }
  unmoved_ = moves ? 0 : unmoved_ + 1;
  const bool still = !moves && (still_ || unmoved_ >= kFramesToRefine);
  if (still_ && !still) {
    BeginToMove();
  }
  still_ = still;
  if (still) {
    plan_ = {still_rate_, choice.scale, false, !attended, true};
    if (attended && still_cost_.cost.total() > 0) {
      HighestRate(still_cost_, 1, choice.target_ms, kLongestCycleOfChosen, &plan_.rate);
    }
  } else {
    plan_ = {rate_, choice.scale * kParts[part_], fast_, false, false};
  }
  plan_.rate = choice.auto_rate ? plan_.rate : choice.rate;
  return plan_;
}

/// Selects filter, resolution and rate by the cost of the last refining frame.
void RateControl::BeginToMove() {
  Changed();
  paths_before_fall_ = 0;
  if (still_cost_.cost.total() <= 0) {
    return;
  }
  SampleRate fitting;
  if (HighestRate(still_cost_, 1, choice_.target_ms, LongestCycle(), &fitting)) {
    fast_ = false;
    part_ = 0;
    rate_ = fitting;
  } else if (MayUseFastFilter()) {
    if (!fast_) {
      part_ = 0;
      UseFastFilter();
    }
    chosen_floor_ms_ = still_cost_.floor_ms();
  } else {
    fast_ = false;
    part_ = 0;
    while (choice_.auto_scale && part_ < kLastPart &&
           !HighestRate(still_cost_, AreaOf(part_, 0), choice_.target_ms, kMaxCycle, &fitting)) {
      ++part_;
    }
    rate_ = fitting;
  }
}

void RateControl::Observe(const FrameCost& cost) {
  if (!still_) {
    ObserveMoving(cost);
  } else if (plan_.refines) {
    ObserveStill({cost, plan_.rate});
  }
}

/// The highest rate, at most the rate of `now`, at which an image of `area` times as many pixels
/// takes at most `limit_ms`; false, and the lowest allowed rate, if there is none.
bool RateControl::HighestRate(const Measured& now, double area, double limit_ms, int longest_cycle,
                              SampleRate* fitting) const {
  *fitting = now.rate;
  while (choice_.auto_rate && now.total_at(*fitting) * area > limit_ms &&
         fitting->cycle < longest_cycle) {
    *fitting = Halved(*fitting);
  }
  return now.total_at(*fitting) * area <= limit_ms;
}

/// Whether a refining view should use this rate, which is above the rate of `now`.
bool RateControl::IsWorthIt(const Measured& now, const SampleRate& rate) const {
  const double total = now.total_at(rate);
  const double traced = now.cost.overlapped ? now.trace_at(rate) : total - now.cost.filter_ms;
  const double limit_ms = choice_.target_ms * (rate.value() > 1 ? 1.0 : kRefineTargets);
  return total <= kSpare * limit_ms || traced <= kShareToRise * now.cost.filter_ms;
}

bool RateControl::IsTooLong(const Measured& now) const {
  const double total = now.cost.total();
  if (now.rate.value() > 1) {
    return total > kLate * choice_.target_ms &&
           now.cost.trace_ms > kShareToFall * now.cost.filter_ms;
  }
  return total > kFarTooLate * kRefineTargets * choice_.target_ms &&
         now.rate.cycle < kLongestCycleOfChosen;
}

void RateControl::ObserveStill(const Measured& now) {
  still_cost_ = now;
  SampleRate higher = Doubled(now.rate);
  if (higher == now.rate || !IsWorthIt(now, higher)) {
    still_rate_ = IsTooLong(now) ? Halved(now.rate) : now.rate;
    return;
  }
  // Below one sample per pixel all steps are taken at once, since the first image matters.
  while (higher.value() < 1 && IsWorthIt(now, Doubled(higher))) {
    higher = Doubled(higher);
  }
  still_rate_ = higher;
}

/// Resets costs that were measured with another rate, size or filter.
void RateControl::Changed() {
  over_ = under_ = roomy_ = quick_ = cramped_ = 0;
  least_ = {};
}

int RateControl::LongestCycle() const {
  return !fast_ && MayUseFastFilter() ? kLongestCycleOfChosen : kMaxCycle;
}

void RateControl::ObserveMoving(const FrameCost& cost) {
  const Measured now = {cost, plan_.rate};
  const double target_ms = choice_.target_ms;
  JudgeLastFall(cost);
  LearnFilterRatio(now);
  rise_.Age();
  grow_.Age();
  filter_.Age();
  const double total = cost.total();
  const bool late = total > target_ms * kLate;
  least_ = late && over_ > 0 && least_.total() < total ? least_ : cost;
  over_ = late ? over_ + 1 : 0;
  under_ = total + cost.paths_ms() <= target_ms * kSpare ? under_ + 1 : 0;
  SampleRate grown;
  roomy_ = FitsWhenGrown(now, &grown) ? roomy_ + 1 : 0;
  quick_ = ChosenFilterFits(now) ? quick_ + 1 : 0;
  cramped_ = IsCramped(now) ? cramped_ + 1 : 0;
  const bool far_too_late = total > target_ms * kFarTooLate;
  const bool gives_way = over_ >= (far_too_late ? kFramesToFall : kFramesToShrink);
  const Measured least = {least_, plan_.rate};
  if ((over_ >= kFramesToFall || far_too_late) && LowerRate(least)) {
    rise_.TakenBack();
    Changed();
  } else if ((gives_way && !fast_ && MayUseFastFilter()) || cramped_ >= kFramesToShrink) {
    chosen_floor_ms_ = least.floor_ms() * AreaOf(0, part_);
    part_ = 0;
    UseFastFilter();
  } else if (gives_way && choice_.auto_scale && part_ < kLastPart) {
    Shrink(least);
  } else if (quick_ >= filter_.frames) {
    UseChosenFilter(now);
  } else if (roomy_ >= grow_.frames) {
    --part_;
    rate_ = grown;
    paths_before_fall_ = 0;
    grow_.Try();
    Changed();
  } else if (choice_.auto_rate && under_ >= rise_.frames && !(Doubled(rate_) == rate_)) {
    rate_ = Doubled(rate_);
    rise_.Try();
    under_ = over_ = 0;
  }
}

bool RateControl::LowerRate(const Measured& now) {
  const bool judging = paths_before_fall_ > 0;
  if (!choice_.auto_rate || judging || hold_ > 0 ||
      now.cost.paths_ms() < kSmallShare * now.cost.total()) {
    return false;  // fewer samples would not reduce the frame time
  }
  SampleRate lower;
  const bool fits = HighestRate(now, 1, choice_.target_ms, LongestCycle(), &lower);
  if (lower == now.rate || (!fits && LongestCycle() < kMaxCycle)) {
    return false;
  }
  before_fall_ = rate_;
  paths_before_fall_ = now.cost.paths_ms();
  since_fall_ = 0;
  rate_ = lower;
  return true;
}

/// Whether the resolution is limited by the time of the chosen filter, and the faster filter might
/// help.
bool RateControl::IsCramped(const Measured& now) const {
  SampleRate rate;
  return !fast_ && part_ > 0 && MayUseFastFilter() &&
         !HighestRate(now, AreaOf(0, part_), choice_.target_ms, LongestCycle(), &rate);
}

void RateControl::UseFastFilter() {
  fast_ = true;
  rate_ = kFirstFastRate;
  paths_before_fall_ = 0;
  filter_.TakenBack();
  Changed();
}

/// Measures the time ratio of both filters, on the first frame after the switch.
void RateControl::LearnFilterRatio(const Measured& now) {
  if (fast_ && chosen_floor_ms_ > 0 && now.floor_ms() > 0) {
    filter_ratio_ = std::max(chosen_floor_ms_ * AreaOf(part_, 0) / now.floor_ms(), 1.0);
    chosen_floor_ms_ = 0;
  }
}

bool RateControl::ChosenFilterFits(const Measured& now) const {
  const Measured chosen = {{now.cost.paths_ms(), now.floor_ms() * filter_ratio_, 0}, now.rate};
  return fast_ && part_ == 0 && filter_ratio_ > 0 &&
         chosen.total_at({1, kLongestCycleOfChosen}) <= kSpareToGrow * choice_.target_ms;
}

void RateControl::UseChosenFilter(const Measured& now) {
  const Measured chosen = {{now.cost.paths_ms(), now.floor_ms() * filter_ratio_, 0}, now.rate};
  HighestRate(chosen, 1, kSpareToGrow * choice_.target_ms, kLongestCycleOfChosen, &rate_);
  rate_ = rate_.cycle > kLongestCycleOfChosen ? SampleRate{1, kLongestCycleOfChosen} : rate_;
  fast_ = false;
  paths_before_fall_ = 0;
  filter_.Try();
  Changed();
}

void RateControl::Shrink(const Measured& now) {
  SampleRate rate;
  const int part = part_;
  do {
    ++part_;
  } while (!HighestRate(now, AreaOf(part_, part), choice_.target_ms, kMaxCycle, &rate) &&
           part_ < kLastPart);
  rate_ = rate;
  paths_before_fall_ = 0;  // smaller images are always traced faster
  grow_.TakenBack();
  Changed();
}

bool RateControl::FitsWhenGrown(const Measured& now, SampleRate* rate) const {
  return part_ > 0 && HighestRate(now, AreaOf(part_ - 1, part_), choice_.target_ms * kSpareToGrow,
                                  LongestCycle(), rate);
}

void RateControl::JudgeLastFall(const FrameCost& cost) {
  hold_ = std::max(hold_ - 1, 0);
  if (paths_before_fall_ <= 0 || ++since_fall_ < kFramesToJudge) {
    return;
  }
  if (cost.paths_ms() > kUseless * paths_before_fall_ && rate_.value() < before_fall_.value()) {
    rate_ = before_fall_;
    over_ = under_ = 0;
    hold_ = kFramesToHold;
  }
  paths_before_fall_ = 0;
}

}  // namespace stillray::view
