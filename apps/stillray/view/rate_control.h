// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Plans the next frame: samples, resolution and filter follow the measured frame times, and
/// whether anything moves. No clock: the same calls give the same plans.
#pragma once

#include <algorithm>

#include "view/sample_rate.h"

namespace stillray::view {

/// The cost of a frame.
struct FrameCost {
  double trace_ms = 0;
  double filter_ms = 0;  ///< part that depends only on the size of the picture
  /// part of trace_ms that does not depend on the samples: guides of all pixels
  double fixed_ms = 0;
  /// The frame was traced while the last one was filtered: the slower of both takes the time.
  bool overlapped = false;
  double total() const { return overlapped ? std::max(trace_ms, filter_ms) : trace_ms + filter_ms; }
  /// Part of trace_ms that is proportional to the samples.
  double paths_ms() const { return std::max(trace_ms - fixed_ms, 0.0); }
};

/// The user's settings, and the allowed deviations from them.
struct RateChoice {
  SampleRate rate{1, 16};   ///< of every frame, unless `auto_rate`
  bool auto_rate = true;    ///< samples follow the frame time
  float scale = 1;          ///< largest fraction of the window's width and height, in (0, 1]
  bool auto_scale = true;   ///< the resolution follows the frame time
  bool fast_filter = true;  ///< the faster filter may replace the chosen one
  double target_ms = 50;    ///< target time of a frame while something moves, > 0
};

struct FramePlan {
  SampleRate rate;
  float scale = 1;           ///< of the window's width and height
  bool fast_filter = false;  ///< use the faster filter, with guides only where a path is traced
  bool refines = false;      ///< nothing moves: the frame may take longer than the target
  bool still = false;        ///< nothing has moved for kFramesToRefine frames
  bool operator==(const FramePlan&) const = default;
};

/// While something moves, frames should take no longer than the target: samples fall first; if 1/16
/// per pixel is not enough, the faster filter replaces the chosen one; if even that is too slow, or
/// not allowed, the resolution falls. Once nothing has moved for kFramesToRefine frames, frames
/// have the full resolution, the chosen filter and a sample per pixel, or more if the filter takes
/// longer than that: the picture refines.
///
/// Samples fall after two frames in a row that are a tenth late, at once after one that is far too
/// late, and rise after four in which twice as many would have fitted. The resolution falls after
/// four late frames that no rate would have saved (two that are far too late), and rises again
/// after 15 frames in which the larger picture would have fitted with a margin, if necessary with
/// fewer samples. Changes that are soon reverted are retried less and less often (hysteresis).
class RateControl {
 public:
  /// Fractions of the chosen width and height, coarse enough that each change is worthwhile.
  static constexpr float kParts[] = {1.0f, 0.71f, 0.5f, 0.35f, 0.25f};
  static constexpr int kFramesToRefine = 4;

  RateControl() = default;
  /// \param rate  of the first frames, which have the full resolution; by default they are small
  explicit RateControl(const SampleRate& rate) : rate_(rate), part_(0) {}

  /// \param moves     whether the view or the scene has changed since the last frame
  /// \param attended  whether the user has changed a setting since the last frame, and waits for
  ///     its effect
  FramePlan Next(const RateChoice& choice, bool moves, bool attended);
  /// Records the cost of the frame of the last plan.
  void Observe(const FrameCost& cost);

 private:
  /// Limits how often something is tried: less often each time it had to be reverted soon.
  struct Patience {
    int least;           ///< frames
    int frames = least;  ///< required number of good ones in a row
    int since = -1;      ///< frames since the last try; -1: it has succeeded
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
  bool still_ = false;  ///< the last plan was for a view that refines
  int unmoved_ = 0;     ///< frames since something moved
  SampleRate still_rate_{1, 4};
  Measured still_cost_;  ///< of the last frame that refined; 0 ms: none

  // While something moves.
  SampleRate rate_{1, 16};
  int part_ = 2;  ///< index into kParts; the first pictures are small, to appear at once
  bool fast_ = false;
  double chosen_floor_ms_ = 0;  ///< of the chosen filter at full size, when it was replaced
  double filter_ratio_ = 0;     ///< of that to the faster one's; 0: unknown
  int over_ = 0;                ///< frames in a row that took too long
  FrameCost least_;             ///< the cheapest of these
  int under_ = 0;               ///< frames in a row that would have fitted with twice the samples
  int roomy_ = 0;               ///< frames in a row in which a larger picture would have fitted
  int quick_ = 0;               ///< frames in a row in which the chosen filter would have fitted
  int cramped_ = 0;             ///< frames in a row in which the chosen filter kept it small
  Patience rise_{4};
  Patience grow_{15};
  Patience filter_{15};
  // A fall that did not make tracing faster is reverted: samples do not determine the time.
  SampleRate before_fall_;
  double paths_before_fall_ = 0;  ///< ms; 0: no fall is under test
  int since_fall_ = 0;
  int hold_ = 0;  ///< frames in which samples do not fall
};

}  // namespace stillray::view
