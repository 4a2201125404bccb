// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Moments of the frames of tests: ten per second, each with the one before as its last.
#pragma once

#include <cstdint>

#include "stillray/render.h"

namespace stillray::render {

inline RenderMoment Moment(int64_t index) {
  RenderMoment moment;
  moment.frame_index = index;
  moment.seconds = static_cast<double>(index) / 10;
  moment.previous_seconds = moment.seconds - 0.1;
  return moment;
}

}  // namespace stillray::render
