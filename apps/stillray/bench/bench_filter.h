// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser's part of `stillray bench`: times of stages and complete frames, and the hardware
/// limits.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>
#include <nlohmann/json_fwd.hpp>

#include "bench/machine_limits.h"
#include "stillray/denoise.hpp"
#include "stillray/frame.h"

namespace stillray {

/// Times in milliseconds, one per repeat.
struct Times {
  std::string name;
  std::vector<double> ms;

  double Min() const;
  double Median() const;
};

/// One configuration of the denoiser.
struct FilterSubject {
  std::string name;    ///< preset and changed parameters
  std::string kernel;  ///< "3x3", "5x5"
  int threads = 1;
  Backend backend = Backend::kCpu;
  Settings settings;
  bool one_signal = false;  ///< the light of input frames is in a single signal
};

class FilterBench {
 public:
  Status Add(const FilterSubject& subject);
  /// Filters the frame with every subject in turn, and measures the hardware limits in between. The
  /// scalar reference, which is slow, runs on every fourth frame.
  /// \param record  false: warm-up frame
  Status Run(const Frame& frame, bool record);

  bool empty() const { return entries_.empty(); }
  std::string Table() const;
  nlohmann::ordered_json Json() const;

 private:
  struct Entry {
    FilterSubject subject;
    Denoiser denoiser;
    /// Reused for all frames, as in long-running applications.
    std::unique_ptr<tbb::task_arena> arena;
    DenoisedFrame out;
    Times whole;
    Times wavelet;  ///< total of all levels
    std::vector<Times> stages;
    size_t bytes = 0;
    size_t signals = 0;
  };

  static Status RunEntry(const Frame& frame, bool record, Entry* entry);
  /// Median time of a copy of the minimum memory traffic of a filter with this number of signals.
  double CopyMs(size_t signals) const;
  /// Minimum time of the scalar version with equal settings; 0: not measured.
  double ScalarMs(const FilterSubject& subject) const;
  /// Lower bound of the wavelet's time, from its arithmetic at the peak rate of one thread.
  double PeakMs(const Entry& entry) const;

  std::vector<Entry> entries_;
  std::unique_ptr<CopyTest> copy_;
  Times copy_times_ = {"copy", {}};
  double peak_ = 0;  ///< fused multiply-adds per second and thread
  size_t pixels_ = 0;
  int frames_ = 0;
  Frame one_signal_;  ///< the frame for subjects with `one_signal`
};

}  // namespace stillray
