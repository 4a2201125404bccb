// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Statistics over the frames of a render.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "quality/render_log.h"

namespace stillray::report {

/// Times of one step over the frames that list it.
struct StepTimes {
  std::string name;
  int frames = 0;
  double median_ms = 0;  ///< for an even number of frames: the mean of the two middle values
  double min_ms = 0;
  double max_ms = 0;
  double sum_ms = 0;
  double share = 0;  ///< of the sum over all stages, 0..1
};

struct TimeTable {
  /// In the order in which the frames list them; a stage that is missing in the first frame (for
  /// lack of a history) comes after its predecessor in later frames.
  std::vector<StepTimes> stages;
  std::optional<StepTimes> render;
  std::optional<StepTimes> denoise;
  std::optional<StepTimes> write;
};

TimeTable MakeTimeTable(const std::vector<RenderLogFrame>& frames);

}  // namespace stillray::report
