// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// demodulate: divides radiance by albedo, sums the radiance images of one signal, and marks
/// invalid samples as missing. Source: SVGF section 3, PSVGF section 4.1. Departs from them: a
/// sample that is NaN, infinite or negative in any channel, or whose albedo is not finite, is
/// missing (samples = 0) and is counted; radiance that is negative within rounding becomes zero
/// (see negative_limit.h). A signal of one channel (AlbedoSum::channel) is grey: luminance, red and
/// blue are equal to that channel. No state. Border: none. Reads 12 bytes per radiance image and 0
/// to 36 of albedo, writes 16 to 20 bytes per pixel.
#pragma once

#include <atomic>

#include "denoise/planes.h"

namespace stillray {

struct DemodulateInput {
  const Image3* radiance[6] = {};       ///< the terms of the signal; unused ones are nullptr
  const Image1* second_moment[6] = {};  ///< of each term, or nullptr (see Signal::second_moment)
  const Image3* own_albedo[6] = {};     ///< the albedo that each second moment was divided by
  int count = 0;
  AlbedoSum albedo;                 ///< the divisor of the signal
  const Image1* samples = nullptr;  ///< nullptr: one sample everywhere
  bool luminance_rec601 = false;    ///< luminance weights: Rec. 601, else Rec. 709
  float negative_limit = 0;         ///< values in (-negative_limit, 0) become zero
};

/// Numbers of invalid pixels among those with samples.
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
