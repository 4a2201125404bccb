// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The loop over the frames of a run: each frame is computed on the caller's thread while the
/// previous frame is written on another thread. The state is saved every 30 seconds and when the
/// run stops.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "sequence/background.h"
#include "stillray/status.h"

namespace stillray {

struct LoopOptions {
  size_t begin = 0;
  size_t end = 0;       ///< one past the last frame
  bool overlap = true;  ///< false: writes before the next frame, on one thread
  /// Maximum age of the saved state if the process is killed, unless a single frame takes longer.
  std::chrono::seconds save_interval{30};
  /// Polled before every frame; false stops with kCancelled. May be empty.
  std::function<bool()> keep_going;
  std::function<Clock::time_point()> now = Clock::now;
};

struct WriteResult {
  Status status;
  double milliseconds = 0;
  Clock::time_point end;
};

struct LoopEnd {
  Status status;       ///< why the loop stopped; kOk: all frames are written
  bool saved = false;  ///< whether the state after the last frame was saved at the end
  Status save_status;  ///< why it could not be saved
};

/// A Job has
///   Picture                               a type: one frame until it is written; two instances
///                                         are used alternately
///   Status Make(size_t at, Picture*)      computes a frame; the picture may hold frame at - 2
///   Status Write(Picture*)                on the writer's thread; must keep what Save needs
///   Status Finish(Picture*, WriteResult)  a frame was written, or could not be; on the caller's
///                                         thread, in the order of the frames
///   bool CanSave() const                  whether the history includes exactly the frames made
///   Status Save(std::span<Picture* const> unwritten)
///                                         saves the state; `unwritten` are the frames that were
///                                         made and not written, in their order
template <typename Job>
class FrameLoop {
 public:
  using Picture = typename Job::Picture;

  /// \param job  must outlive the loop
  FrameLoop(Job* job, LoopOptions options)
      : job_(*job), options_(std::move(options)), last_save_(options_.now()) {}

  /// Runs all frames. Call it once.
  LoopEnd Run() {
    for (size_t at = options_.begin; at < options_.end; ++at) {
      const bool stop = options_.keep_going && !options_.keep_going();
      const Status done = stop ? Status::Cancelled() : RunFrame(at);
      if (!done.ok()) {
        return Stop(done);
      }
    }
    return {};
  }

  /// For a Job with a slow Make: finishes the frame that is being written, if it is ready.
  Status Poll() { return writing_.ready() ? FinishWriting() : Status::Ok(); }

 private:
  Status RunFrame(size_t at) {
    Picture* picture = &pictures_[at % 2];
    STILLRAY_RETURN_IF_ERROR(job_.Make(at, picture));
    unwritten_.push_back(picture);
    // Waits for the previous frame; after this `picture` is the only unwritten one.
    STILLRAY_RETURN_IF_ERROR(FinishWriting());
    StartWriting(picture);
    const bool last = at + 1 == options_.end;
    const bool save = !last && options_.now() - last_save_ > options_.save_interval;
    if (!options_.overlap || save || last) {
      STILLRAY_RETURN_IF_ERROR(FinishWriting());
    }
    return save ? Save() : Status::Ok();
  }

  void StartWriting(Picture* picture) {
    writing_.Start(options_.overlap, [this, picture] {
      const Clock::time_point start = Clock::now();
      WriteResult result;
      result.status = job_.Write(picture);
      result.end = Clock::now();
      result.milliseconds = std::chrono::duration<double, std::milli>(result.end - start).count();
      return result;
    });
  }

  /// Waits until the frame that is being written, if any, is finished.
  Status FinishWriting() {
    if (!writing_.under_way()) {
      return Status::Ok();
    }
    const WriteResult result = writing_.Take();
    STILLRAY_RETURN_IF_ERROR(job_.Finish(unwritten_.front(), result));
    unwritten_.erase(unwritten_.begin());
    return Status::Ok();
  }

  Status Save() {
    const Status saved = job_.Save(unwritten_);
    last_save_ = options_.now();
    return saved;
  }

  /// Saves the state, so that the run can be resumed from here.
  LoopEnd Stop(Status reason) {
    LoopEnd end;
    // An error of an earlier frame has priority.
    const Status written = FinishWriting();
    end.status = written.ok() ? std::move(reason) : written;
    if (job_.CanSave()) {
      end.save_status = Save();
      end.saved = end.save_status.ok();
    }
    return end;
  }

  Job& job_;
  LoopOptions options_;
  Picture pictures_[2];
  std::vector<Picture*> unwritten_;  ///< made but not written, in order
  Clock::time_point last_save_;
  Background<WriteResult> writing_;  ///< last, so that its task ends before its data is freed
};

}  // namespace stillray
