// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Traces and filters the frames of `stillray render`, on one device or, as a fallback, on the CPU;
/// or on two devices, which then work at the same time.
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
  Image3 reference;  ///< empty: none
  double milliseconds = 0;
  std::vector<LoggedStage> stages;
  size_t renderer_bytes = 0;
  std::string on_cpu;  ///< why the CPU traced it instead of the device; empty: it did not
};

/// A frame until its files are written.
struct RenderPicture {
  TracedFrame traced;
  Frame on_host;  ///< host copy of its planes, if it is on a device and files need them
  const Frame* in_files = nullptr;  ///< the frame with the planes that files need
  DenoisedFrame denoised;
  FrameLog log;
};

/// Cost of a frame in samples per pixel, from which its time is estimated. Filtering and writing
/// count as four.
double FrameWork(const RenderOptions& options, int64_t frame);
/// The cost of all earlier frames.
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
  /// \param ahead  whether a frame may be traced while the last one is filtered, if the devices
  ///     differ
  /// \return also kInvalidArgument if there is no lens for depth of field
  Status Prepare(const RenderDevices& devices, bool ahead);

  /// Renders and denoises a frame, and its reference if requested. Call it for one frame after the
  /// other: the next one may be traced already.
  /// \param earlier  picture of the same frame, filtered by an earlier run, which replaces
  ///     filtering: the history already includes its light; or nullptr
  Status Make(int64_t number, UnwrittenFrame* earlier, Progress* progress, RenderPicture* picture);

  /// The last frame whose light is in the history.
  int64_t last_filtered() const { return last_filtered_; }
  /// Whether the history is that after last_filtered(); false once a frame has failed during or
  /// after filtering.
  bool history_is_whole() const { return history_is_whole_; }
  Result<std::vector<uint8_t>> SaveHistory() const { return denoiser_->SaveHistory(); }
  /// \param last  the last frame whose light it includes
  Status RestoreHistory(const std::vector<uint8_t>& history, int64_t last);

  /// Whether the next frame is traced while one is filtered: one frame more in memory.
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
  post::ThinLens lens_;  ///< of the effect
  std::unique_ptr<DeviceRenderer> renderer_;
  std::string place_;
  bool on_device_ = false;  ///< frames stay on the device, which also filters them
  bool traces_ahead_ = false;
  std::optional<Denoiser> denoiser_;
  bool printed_fall_back_ = false;
  int64_t last_filtered_;
  bool history_is_whole_ = true;
  TracedFrame next_;         ///< is traced while another is filtered
  int64_t next_number_ = 0;  ///< its number
  TraceAhead ahead_;         ///< last, so that its thread ends before its data is freed
};

}  // namespace stillray
