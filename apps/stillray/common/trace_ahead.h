// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Concurrent tracing and filtering: a two-stage pipeline for path tracer and denoiser on two
/// devices. While the caller filters frame n, a thread of this object traces frame n + 1. Source:
/// the progressive paper, with a path tracer on the CPU and a filter on the GPU
/// (docs/references.md).
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <utility>

#include "sequence/background.h"
#include "stillray/render.h"
#include "stillray/status.h"

namespace stillray {

/// Traces one frame at a time. Objects referenced by the task, such as the renderer, must not be
/// used elsewhere between Start() and the return of Take() or Cancel(). Not thread-safe; the
/// destructor cancels.
class TraceAhead {
 public:
  TraceAhead() = default;
  ~TraceAhead() { Cancel(); }
  TraceAhead(const TraceAhead&) = delete;
  TraceAhead& operator=(const TraceAhead&) = delete;

  /// Starts tracing; no other frame may be in progress.
  /// \param trace  Status trace(const RenderProgress&), called on the internal thread
  template <typename Trace>
  void Start(Trace trace) {
    cancelled_ = false;
    fraction_ = 0;
    tracing_.Start(true, [this, trace = std::move(trace)]() mutable {
      return trace([this](double fraction) {
        fraction_ = fraction;
        return !cancelled_;
      });
    });
  }

  /// Whether a frame has been started, and neither taken nor cancelled.
  bool under_way() const { return tracing_.under_way(); }

  /// Waits for the frame. Requires under_way().
  /// \param progress  called on the caller's thread while waiting; cancels the frame by returning
  ///     false
  /// \return the result of `trace`; kCancelled
  Status Take(const RenderProgress& progress) {
    while (!tracing_.WaitFor(kPollInterval)) {
      if (progress && !progress(fraction_)) {
        Cancel();
        return Status::Cancelled();
      }
    }
    return tracing_.Take();
  }

  /// Cancels the frame in progress, if any, and discards it.
  void Cancel() {
    if (tracing_.under_way()) {
      cancelled_ = true;
      // Neither result nor exception is used.
      try {
        static_cast<void>(tracing_.Take());
      } catch (const std::exception&) {
      }
    }
  }

 private:
  /// Maximum delay of cancelling a frame that is made obsolete by user input.
  static constexpr std::chrono::milliseconds kPollInterval{5};

  std::atomic<bool> cancelled_ = false;
  std::atomic<double> fraction_ = 0;
  Background<Status> tracing_;  ///< last member: its task ends before the task's data is freed
};

}  // namespace stillray
