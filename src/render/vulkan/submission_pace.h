// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// How much work the submissions of a path tracer have.
///
/// Desktop drivers abort work that takes longer than about two seconds, and other users of the
/// device wait for as long as a submission takes. So submissions start with few enough paths to
/// stay below that, and adapt to the measured times: a frame that takes a fraction of the target is
/// one submission.
#pragma once

namespace stillray::render {

class SubmissionPace {
 public:
  /// \param target_ms  approximate duration of a submission in milliseconds, above 0
  explicit SubmissionPace(double target_ms) : target_ms_(target_ms) {}

  /// Maximum number of paths for the next submission.
  double paths() const { return paths_; }
  /// Whether a submission of so many should not wait for more, so that its time shows how many fit.
  /// Never for all of a frame that takes less than half of the target, once one has been measured.
  bool IsEnough(double paths) const { return paths > 0.5 * paths_; }
  /// A submission of so many paths took so many milliseconds. \param most  of any submission
  void Adapt(double paths, double milliseconds, double most);

  static constexpr double kFirstPaths = 1 << 14;
  static constexpr double kLeastPaths = 1 << 11;

 private:
  double target_ms_;
  double paths_ = kFirstPaths;
};

/// How many steps of paths to record. Glass and cut-outs allow paths of many more than most frames
/// have, and steps without paths cost dispatches and barriers.
class StepForecast {
 public:
  /// Of at most `most`: those of this frame so far and of the last one, and a few more, since the
  /// longest path of a frame varies; all of them if nothing is known.
  int Planned(int most) const;
  /// The longest path of a submission had so many.
  void Used(int steps);
  void NextFrame();

  static constexpr int kSpareSteps = 2;

 private:
  static constexpr int kUnknown = -1;
  int before_ = kUnknown;
  int now_ = kUnknown;
};

}  // namespace stillray::render
