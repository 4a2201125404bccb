// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history_shared.h"

// The variance of single compressed samples is at most 1/4; this factor keeps its precision in
// halves.
const float kSingleScale = 65536.0f;

// Largest length that a history with these moments may count for. \param compared  after its
// wavelet levels
float MostLength(vec4 m, vec4 compared_light) {
  return IsValid(compared_light.w)
             ? LimitedLength(m.z, m.w, compared_light.x, VarianceOf(compared_light.w),
                             compared_light.z / kSingleScale, limit_history.limit_dead,
                             limit_history.limit_gain)
             : m.z;
}

// The history's mean under this frame's scale.
float RescaledCompressed(float c, int s) {
  return old_compressed_scale[s] > 0.0f && old_compressed_scale[s] != compressed_scale[s]
             ? RescaleCompressed(c, old_compressed_scale[s], compressed_scale[s])
             : c;
}
