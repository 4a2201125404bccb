// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoiser's part of `stillray bench`: times of stages and whole frames, and the limits of the
/// machine.
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

/// One way to filter a frame.
struct FilterSubject {
  std::string name;    ///< preset, and its changes
  std::string kernel;  ///< "3x3", "5x5"
  int threads = 1;
  Backend backend = Backend::kCpu;
  Settings settings;
  bool one_signal = false;  ///< frames come with all their light in one signal
};

class FilterBench {
 public:
  Status Add(const FilterSubject& subject);
  /// Gives the frame to every subject in turn, and measures the limits in between. The scalar
  /// reference, which is slow, runs on every fourth frame.
  /// \param record  false: to warm up
  Status Run(const Frame& frame, bool record);

  bool empty() const { return entries_.empty(); }
  std::string Table() const;
  nlohmann::ordered_json Json() const;

 private:
  struct Entry {
    FilterSubject subject;
    Denoiser denoiser;
    /// Kept between frames, as every caller that goes on for long does.
    std::unique_ptr<tbb::task_arena> arena;
    DenoisedFrame out;
    Times whole;
    Times wavelet;  ///< all levels
    std::vector<Times> stages;
    size_t bytes = 0;
    size_t signals = 0;
  };

  static Status RunEntry(const Frame& frame, bool record, Entry* entry);
  /// Median of the copy of the least bytes that a filter of so many signals must touch.
  double CopyMs(size_t signals) const;
  /// Least time of the scalar version of the same settings; 0: not measured.
  double ScalarMs(const FilterSubject& subject) const;
  /// Least time of the wavelet's arithmetic at the peak rate of one thread.
  double PeakMs(const Entry& entry) const;

  std::vector<Entry> entries_;
  std::unique_ptr<CopyTest> copy_;
  Times copy_times_ = {"copy", {}};
  double peak_ = 0;  ///< multiply-adds per second and thread
  size_t pixels_ = 0;
  int frames_ = 0;
  Frame one_signal_;  ///< the frame for subjects with `one_signal`
};

}  // namespace stillray
