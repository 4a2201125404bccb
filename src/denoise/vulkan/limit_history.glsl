// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history_shared.h"

// The variance of single compressed samples is at most 1/4; this factor keeps its precision in
// halves.
const float kSingleScale = 65536.0f;

// That of changes and, squared, of their squares: small ones are precise in halves.
const float kChangeScale = 16.0f;

// Blocks along each side.
ivec2 CoarseSize() {
  return (Size() + 1) / 2;
}

// MovingLight of a signal, after measure_change.
float MovingLightOf(int s) {
  bool finds = limit_history.correct_history != 0 && atrous.grows == 0;  // find_moving_light
  return finds ? MovingLight(float(changed_blocks[s]), float(known_blocks[s]),
                             s < limit_history.wide_signals)
               : 0.0f;
}

// Largest length that a history with these moments may count for. \param limits  the result of
// limit_history: ratio, relative bias
float MostLength(vec4 m, vec4 limits) {
  return LimitedLength(m.z, m.w, limits.y, limit_history.limit_gain);
}
