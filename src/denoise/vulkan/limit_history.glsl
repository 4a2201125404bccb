// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history_shared.h"

// The variance of single compressed samples is at most 1/4: times this it keeps its bits in halves.
const float kSingleScale = 65536.0f;

// What the history holds, under this frame's scale.
float RescaledCompressed(float c, int s) {
  return old_compressed_scale[s] > 0.0f && old_compressed_scale[s] != compressed_scale[s]
             ? RescaleCompressed(c, old_compressed_scale[s], compressed_scale[s])
             : c;
}
