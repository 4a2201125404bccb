// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Plans the next frame: adapts samples, resolution and filter to measured frame times and to
/// motion. Does not read a clock: equal calls give equal plans.
#pragma once

#include <algorithm>

#include "view/sample_rate.h"

namespace stillray::view {

/// Measured cost of a frame.
struct FrameCost {
  double trace_ms = 0;
  double filter_ms = 0;  ///< part that depends only on the image size
  /// part of trace_ms that does not depend on the samples: guides of all pixels
  double fixed_ms = 0;
  /// The frame was traced while the previous one was filtered: the maximum of both times counts.
  bool overlapped = false;
  double total() const { return overlapped ? std::max(trace_ms, filter_ms) : trace_ms + filter_ms; }
  /// Part of trace_ms that is proportional to the samples.
  double paths_ms() const { return std::max(trace_ms - fixed_ms, 0.0); }
};

/// The user's settings, and the allowed deviations from them.
struct RateChoice {
  SampleRate rate{1, 16};   ///< rate of all frames, unless `auto_rate`
  bool auto_rate = true;    ///< samples follow the frame time
  float scale = 1;          ///< maximum fraction of the window's width and height, in (0, 1]
  bool auto_scale = true;   ///< the resolution follows the frame time
  bool fast_filter = true;  ///< the faster filter may replace the chosen one
  double target_ms = 50;    ///< target time of a frame while something moves, > 0
};

struct FramePlan {
  SampleRate rate;
  float scale = 1;           ///< fraction of the window's width and height
  bool fast_filter = false;  ///< use the faster filter, with guides only where a path is traced
  bool refines = false;      ///< static view: the frame may take longer than the target
  bool still = false;        ///< the view has been static for kFramesToRefine frames
  bool operator==(const FramePlan&) const = default;
};

/// During motion, frames should not exceed the target time: the sample rate is reduced first; if
/// 1/16 sample per pixel is still too slow, the faster filter replaces the chosen filter; if that
/// is too slow or not allowed, the resolution is reduced. After kFramesToRefine static frames the
/// image is refined: full resolution, the chosen filter, and one sample per pixel, or more if the
/// filter takes longer than tracing.
///
/// The sample rate is reduced after two consecutive frames that are 10% late, immediately after a
/// frame that is far too late, and raised after four frames in which twice the samples would have
/// fitted. The resolution is reduced after four late frames that no rate would have saved (two if
/// far too late), and raised after 15 frames in which the larger image would have fitted with a
/// margin, if necessary with fewer samples. Changes that are soon reverted are retried at growing
/// intervals (hysteresis).
class RateControl {
 public:
  /// Fractions of the chosen width and height, coarse enough that each change is worthwhile.
  static constexpr float kParts[] = {1.0f, 0.71f, 0.5f, 0.35f, 0.25f};
  static constexpr int kFramesToRefine = 4;

  RateControl() = default;
  /// \param rate  rate of the first frames, which then have the full resolution instead of a small
  ///     one
  explicit RateControl(const SampleRate& rate) : rate_(rate), part_(0) {}

  /// \param moves     whether view or scene have changed since the last frame
  /// \param attended  whether the user has changed a setting since the last frame and waits for the
  ///     effect
  FramePlan Next(const RateChoice& choice, bool moves, bool attended);
  /// Records the cost of the frame of the last plan.
  void Observe(const FrameCost& cost);

 private:
  /// Exponential back-off: limits how often a change is tried after it had to be reverted.
  struct Patience {
    int least;           ///< frames
    int frames = least;  ///< required number of consecutive good frames
    int since = -1;      ///< frames since the last try; -1: the try has succeeded
    void Try() { since = 0; }
    void Age();
    void TakenBack();
  };

  /// A cost and its sample rate.
  struct Measured {
    FrameCost cost;
    SampleRate rate;
    /// Part of the time that does not depend on the samples.
    double floor_ms() const {
      return cost.overlapped ? std::max(cost.trace_ms - cost.paths_ms(), cost.filter_ms)
                             : cost.total() - cost.paths_ms();
    }
    double trace_at(const SampleRate& other) const {
      return cost.trace_ms - cost.paths_ms() + cost.paths_ms() * other.value() / rate.value();
    }
    double total_at(const SampleRate& other) const {
      return cost.overlapped ? std::max(trace_at(other), cost.filter_ms)
                             : floor_ms() + cost.paths_ms() * other.value() / rate.value();
    }
  };

  void BeginToMove();
  void ObserveMoving(const FrameCost& cost);
  void ObserveStill(const Measured& now);
  bool IsWorthIt(const Measured& now, const SampleRate& rate) const;
  bool IsTooLong(const Measured& now) const;
  bool HighestRate(const Measured& now, double area, double limit_ms, int longest_cycle,
                   SampleRate* fitting) const;
  bool MayUseFastFilter() const { return choice_.auto_rate && choice_.fast_filter; }
  /// The longest cycle before the filter or the resolution is reduced.
  int LongestCycle() const;
  bool LowerRate(const Measured& now);
  bool IsCramped(const Measured& now) const;
  void UseFastFilter();
  void UseChosenFilter(const Measured& now);
  bool ChosenFilterFits(const Measured& now) const;
  void LearnFilterRatio(const Measured& now);
  void Shrink(const Measured& now);
  bool FitsWhenGrown(const Measured& now, SampleRate* rate) const;
  void JudgeLastFall(const FrameCost& cost);
  void Changed();

  RateChoice choice_;
  FramePlan plan_;
  bool still_ = false;  ///< the last plan was for a refining view
  int unmoved_ = 0;     ///< frames since the last motion
  SampleRate still_rate_{1, 4};
  Measured still_cost_;  ///< cost of the last refining frame; 0 ms: none

  // State during motion.
  SampleRate rate_{1, 16};
  int part_ = 2;  ///< index into kParts; the first images are small, to appear immediately
  bool fast_ = false;
  /// floor_ms of the chosen filter at full size, when it was replaced.
  double chosen_floor_ms_ = 0;
  double filter_ratio_ = 0;  ///< time ratio of the chosen to the faster filter; 0: unknown
  int over_ = 0;             ///< consecutive late frames
  FrameCost least_;          ///< minimum cost of the late frames
  int under_ = 0;            ///< consecutive frames in which twice the samples would have fitted
  int roomy_ = 0;            ///< consecutive frames in which a larger image would have fitted
  int quick_ = 0;            ///< consecutive frames in which the chosen filter would have fitted
  int cramped_ = 0;  ///< consecutive frames whose resolution was limited by the chosen filter
  Patience rise_{4};
  Patience grow_{15};
  Patience filter_{15};
  // A reduction of the rate that did not accelerate tracing is reverted.
  SampleRate before_fall_;
  double paths_before_fall_ = 0;  ///< ms; 0: no reduction is being tested
  int since_fall_ = 0;
  int hold_ = 0;  ///< remaining frames in which the rate is not reduced
};

}  // namespace stillray::view
