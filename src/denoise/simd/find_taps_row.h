// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// reproject row by row, on the calling thread.
#pragma once

#include "denoise/simd/next_row.h"
#include "denoise/stages/reproject.h"

namespace stillray {

/// Guides of one row of this frame for FindTapsRow; lanes beyond the last pixel may hold any value.
struct GuidesOfRow {
  const float* normal[3];
  const float* inverse_depth;
  const float* gradient[2];
  const uint32_t* id;
};

namespace cpu {
/// Call BeginTaps before the first row.
/// \param next  other rows to prefetch
void BeginTaps(ReprojectionTaps* taps);
void FindTapsRow(const GuidesOfRow& now, const GuidePlanes& before, const Image2& motion,
                 const ReprojectParameters& parameters, int y, const NextRow<32>& next,
                 ReprojectionTaps* taps);
}  // namespace cpu

}  // namespace stillray
