// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tracing beside filtering: a pipeline of two stages for a tracer and a filter on two devices.
/// While the caller filters frame n, frame n + 1 is traced on a thread of this object.
/// Source: the progressive paper's arrangement, a path tracer on the CPU beside a filter on the GPU
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

/// Traces one frame at a time. Objects that the task refers to, such as the renderer, must not be
/// used by others between Start() and the return of Take() or Cancel(). Not thread-safe itself; the
/// destructor cancels.
class TraceAhead {
 public:
  TraceAhead() = default;
  ~TraceAhead() { Cancel(); }
  TraceAhead(const TraceAhead&) = delete;
  TraceAhead& operator=(const TraceAhead&) = delete;

  /// Starts to trace; no other frame may be under way.
  /// \param trace  Status trace(const RenderProgress&), called on the other thread
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

  /// Whether a frame was started, and neither taken nor cancelled.
  bool under_way() const { return tracing_.under_way(); }

  /// Waits for the frame. Only while under_way().
  /// \param progress  called while it waits, on the caller's thread; if it returns false, the frame
  ///     is cancelled
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

  /// Ends the frame that is being traced, if there is one, and discards it.
  void Cancel() {
    if (tracing_.under_way()) {
      cancelled_ = true;
      // The result is not used: neither is an exception.
      try {
        static_cast<void>(tracing_.Take());
      } catch (const std::exception&) {
      }
    }
  }

 private:
  /// A frame that user input makes obsolete is cancelled after this time at the latest.
  static constexpr std::chrono::milliseconds kPollInterval{5};

  std::atomic<bool> cancelled_ = false;
  std::atomic<double> fraction_ = 0;
  Background<Status> tracing_;  ///< last, so that its task ends before its data is freed
};

}  // namespace stillray
