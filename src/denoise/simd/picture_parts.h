// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The input rows of demodulate and remodulate, for prefetching.
#pragma once

#include "denoise/simd/next_row.h"
#include "denoise/stages/demodulate.h"
#include "denoise/stages/remodulate.h"

namespace stillray {

template <size_t kMost>
void AddPictureParts(const PictureParts& parts, int y, NextRow<kMost>* next) {
  for (const SignalLight& signal : parts.signals) {
    next->Add(*signal.light, y);
    for (int i = 0; i < signal.albedo.count; ++i) {
      next->Add(*signal.albedo.part[i], y);
    }
  }
  for (const Image3* image : parts.unfiltered) {
    next->Add(*image, y);
  }
}

template <size_t kMost>
void AddRadiance(const DemodulateInput& in, int y, NextRow<kMost>* next) {
  for (int i = 0; i < in.count; ++i) {
    next->Add(*in.radiance[i], y);
  }
  for (int i = 0; i < in.albedo.count; ++i) {
    next->Add(*in.albedo.part[i], y);
  }
}

}  // namespace stillray
