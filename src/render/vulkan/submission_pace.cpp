// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/submission_pace.h"

#include <algorithm>

namespace stillray::render {

void SubmissionPace::Adapt(double paths, double milliseconds, double most) {
  const double ratio = target_ms_ / std::max(milliseconds, 1e-3);
  if (ratio < 1) {
    paths_ = std::max(paths * std::max(ratio, 0.25), kLeastPaths);
  } else {
    paths_ = std::max(paths_, paths * std::min(ratio, 2.0));
  }
  paths_ = std::min(paths_, most);
}

int StepForecast::Planned(int most) const {
  const int known = std::max(before_, now_);
  return known == kUnknown ? most : std::min(most, known + kSpareSteps);
}

void StepForecast::Used(int steps) {
  now_ = std::max(now_, steps);
}

void StepForecast::NextFrame() {
  before_ = now_;
  now_ = kUnknown;
}

}  // namespace stillray::render
