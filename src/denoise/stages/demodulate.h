// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// demodulate: divides light by albedo, sums the lights of one signal, and marks invalid samples as
/// missing. Source: SVGF section 3, PSVGF section 4.1. Departs from them: a sample that is NaN,
/// infinite or negative in any channel, or whose albedo is not finite, is missing (samples = 0) and
/// is counted; light that is negative within rounding is zero (see negative_limit.h). A signal of
/// one channel (AlbedoSum::channel) is grey, with that channel as luminance, red and blue. No
/// state. Border: none. Reads 12 bytes per light and 0 to 36 of albedo, writes 16 to 20 bytes per
/// pixel.
#pragma once

#include <atomic>

#include "denoise/planes.h"

namespace stillray {

struct DemodulateInput {
  const Image3* radiance[6] = {};       ///< lights that make up this signal
  const Image1* second_moment[6] = {};  ///< of each, or nullptr (see Signal::second_moment)
  const Image3* own_albedo[6] = {};     ///< the albedo that each second moment was divided by
  int count = 0;
  AlbedoSum albedo;                 ///< divides the signal
  const Image1* samples = nullptr;  ///< nullptr: one sample everywhere
  bool luminance_rec601 = false;    ///< luminance weights of the result
  float negative_limit = 0;         ///< negative light above -negative_limit is zero
};

/// Counts over pixels that have a sample.
struct DemodulateCounts {
  int64_t non_finite = 0;
  int64_t negative = 0;

  DemodulateCounts& operator+=(const DemodulateCounts& other) {
    non_finite += other.non_finite;
    negative += other.negative;
    return *this;
  }
};

/// The sum of the counts of several threads.
class DemodulateTotal {
 public:
  void Add(const DemodulateCounts& counts) {
    non_finite_ += counts.non_finite;
    negative_ += counts.negative;
  }
  DemodulateCounts Sum() const { return {non_finite_, negative_}; }

 private:
  std::atomic<int64_t> non_finite_ = 0;
  std::atomic<int64_t> negative_ = 0;
};

namespace reference {
DemodulateCounts Demodulate(const DemodulateInput& in, NewLight* out);
}
namespace cpu {
DemodulateCounts Demodulate(const DemodulateInput& in, NewLight* out);
}

}  // namespace stillray
