// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Controls the amount of work per queue submission.
///
/// Desktop drivers abort submissions that take longer than about two seconds, and other users of
/// the device wait until a submission ends. The number of paths per submission therefore starts
/// small and adapts to measured times: a frame that takes a fraction of the target is one
/// submission.
#pragma once

namespace stillray::render {

class SubmissionPace {
 public:
  /// \param target_ms  approximate duration of a submission in milliseconds, above 0
  explicit SubmissionPace(double target_ms) : target_ms_(target_ms) {}

  /// Maximum number of paths for the next submission.
  double paths() const { return paths_; }
  /// Whether a submission of `paths` paths is large enough to be submitted and measured. Once
  /// measured, a frame that takes less than half of the target is never split.
  bool IsEnough(double paths) const { return paths > 0.5 * paths_; }
  /// Adapts to a measured submission of `paths` paths. \param most maximum paths of a submission
  void Adapt(double paths, double milliseconds, double most);

  static constexpr double kFirstPaths = 1 << 14;
  static constexpr double kLeastPaths = 1 << 11;

 private:
  double target_ms_;
  double paths_ = kFirstPaths;
};

/// Predicts the number of path steps to record. Glass and cut-outs allow much longer paths than
/// occur in most frames, and steps without paths cost dispatches and barriers.
class StepForecast {
 public:
  /// Number of steps to record, at most `most`: the maximum of this frame so far and of the last
  /// frame, plus a margin, since the longest path varies; `most` without a measurement.
  int Planned(int most) const;
  /// Reports the number of steps of the longest path of a submission.
  void Used(int steps);
  void NextFrame();

  static constexpr int kSpareSteps = 2;

 private:
  static constexpr int kUnknown = -1;
  int before_ = kUnknown;
  int now_ = kUnknown;
};

}  // namespace stillray::render
