// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history_shared.h"

// The variance of single compressed samples is at most 1/4; this factor keeps its precision in
// halves.
const float kSingleScale = 65536.0f;

// The factor of stored changes and, squared, of their squares, so that small ones are precise in
// half precision.
const float kChangeScale = 16.0f;

// Number of blocks along each axis.
ivec2 CoarseSize() {
  return (Size() + 1) / 2;
}

// MovingLight of a signal, after measure_change; for diffuse signals, the largest among them.
float MovingLightOf(int s) {
  if (!FindsMovingLight(limit_history.correct_history, atrous.grows)) {
    return 0.0f;
  }
  bool is_diffuse = s < limit_history.wide_signals;
  int first = is_diffuse ? 0 : s;
  int end = is_diffuse ? limit_history.wide_signals : s + 1;
  float moving = 0.0f;
  for (int i = first; i < end; ++i) {
    moving = max(moving, MovingLight(float(changed_blocks[i]), float(known_blocks[i]), is_diffuse));
  }
  return moving;
}

// Limit of the length of a history with these moments.
// \param limits  output of limit_history: ratio, relative bias
float MostLength(vec4 m, vec4 limits) {
  return LimitedLength(m.z, m.w, limits.y, limit_history.limit_gain);
}
