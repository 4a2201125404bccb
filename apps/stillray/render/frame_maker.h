// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Traces and filters the frames of `stillray render`: on one device or, as a fallback, on the CPU;
/// or concurrently on two devices.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "common/device_option.h"
#include "common/progress.h"
#include "common/trace_ahead.h"
#include "common/trace_device.h"
#include "render/render_options.h"
#include "render/run_log.h"
#include "sequence/resume_state.h"
#include "stillray/scene.h"

namespace stillray {

/// A traced frame, with a copy of the renderer's statistics: the renderer may already be tracing
/// the next frame.
struct TracedFrame {
  Frame frame;
  Image3 reference;  ///< reference image; empty: none
  double milliseconds = 0;
  std::vector<LoggedStage> stages;
  size_t renderer_bytes = 0;
  std::string on_cpu;  ///< reason for a fallback to the CPU; empty: none
};

/// Data of a frame until its files are written.
struct RenderPicture {
  TracedFrame traced;
  Frame on_host;  ///< host copy of the planes required by files, if the frame is in device memory
  const Frame* in_files = nullptr;  ///< the frame with the planes required by files
  DenoisedFrame denoised;
  FrameLog log;
};

/// Cost of a frame in samples per pixel, for time estimates. Filtering and writing count as four
/// samples.
double FrameWork(const RenderOptions& options, int64_t frame);
/// Total cost of all earlier frames.
double WorkBefore(const RenderOptions& options, int64_t frame);
/// "frame 3 of 120".
std::string FrameText(const RenderOptions& options, int64_t frame);

class FrameMaker {
 public:
  /// \param options, scene  must outlive the object and must not change
  FrameMaker(const RenderOptions& options, const Scene& scene)
      : options_(options), scene_(scene), last_filtered_(options.frames.first - 1) {}

  /// \return kNotFound naming the existing cameras
  Status FindCamera();
  /// Creates renderer and denoiser.
  /// \param ahead  whether a frame may be traced while the previous one is filtered, if the devices
  ///     differ
  /// \return also kInvalidArgument if there is no lens for depth of field
  Status Prepare(const RenderDevices& devices, bool ahead);

  /// Renders and denoises a frame, and its reference if requested. Call it in frame order, since
  /// the next frame may already be in progress.
  /// \param earlier  image of this frame from an earlier run, which replaces filtering, since the
  ///     history already includes the frame; or nullptr
  Status Make(int64_t number, UnwrittenFrame* earlier, Progress* progress, RenderPicture* picture);

  /// The last frame accumulated in the history.
  int64_t last_filtered() const { return last_filtered_; }
  /// Whether the history is valid as of last_filtered(); false once a frame has failed during or
  /// after filtering.
  bool history_is_whole() const { return history_is_whole_; }
  Result<std::vector<uint8_t>> SaveHistory() const { return denoiser_->SaveHistory(); }
  /// \param last  the last frame accumulated in the history
  Status RestoreHistory(const std::vector<uint8_t>& history, int64_t last);

  /// Whether the next frame is traced while one is filtered, which takes the memory of one more
  /// frame.
  bool traces_ahead() const { return traces_ahead_; }
  const Denoiser& denoiser() const { return *denoiser_; }
  /// The device that traces the first frame.
  const std::string& place() const { return place_; }

 private:
  Status MakeRenderer(const RenderDevices& devices);
  RenderMoment MomentOf(int64_t number) const;
  Status Trace(int64_t number, const RenderProgress& progress, TracedFrame* traced);
  Status TakeTraced(int64_t number, Progress* progress, RenderPicture* picture);
  Status Denoise(const RenderMoment& moment, Progress* progress, RenderPicture* picture);
  Status BringToHost(RenderPicture* picture) const;
  Status PrepareLens();
  Status ApplyPost(Image3* colour, RenderPicture* picture) const;
  RenderProgress Shown(int64_t number, Progress* progress) const;

  const RenderOptions& options_;
  const Scene& scene_;
  int camera_ = 0;
  post::ThinLens lens_;  ///< lens of the depth of field effect
  std::unique_ptr<DeviceRenderer> renderer_;
  std::string place_;
  bool on_device_ = false;  ///< frames remain in device memory, for a filter on the same device
  bool traces_ahead_ = false;
  std::optional<Denoiser> denoiser_;
  bool printed_fall_back_ = false;
  int64_t last_filtered_;
  bool history_is_whole_ = true;
  TracedFrame next_;         ///< frame traced while another one is filtered
  int64_t next_number_ = 0;  ///< number of next_
  TraceAhead ahead_;         ///< last member: its thread ends before the thread's data is freed
};

}  // namespace stillray
