// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What a stillray_denoiser holds: settings, descriptions of images, and the engine with its
/// history.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tbb/task_arena.h>

#include "capi/frame_slots.h"
#include "stillray/denoise.hpp"
#include "stillray/stillray.h"

namespace stillray::capi {

/// Threads and the place where frames are filtered, shared by a device and its denoisers.
struct Workplace {
  Workplace(int n, Device filter_device) : threads(n), arena(n), device(std::move(filter_device)) {}
  int threads;
  tbb::task_arena arena;
  Device device;
};

/// The sequence behind a stillray_denoiser. Errors come as Status; only memory can throw.
class Session {
 public:
  Session(std::shared_ptr<Workplace> place, const Settings& settings)
      : place_(std::move(place)), settings_(settings) {}

  const Settings& settings() const { return settings_; }
  void SetSettings(const Settings& settings) { settings_ = settings; }
  /// Results that there are with the present settings.
  std::vector<std::string> OutputNames() const;

  /// \param image  nullptr: take it away
  Status SetInput(std::string_view name, const stillray_image* image);
  Status SetOutput(std::string_view name, const stillray_image* image);
  Status SetJitter(float x, float y);
  void SetProgress(stillray_progress progress, void* user);

  Status Execute();
  Status Resize(int width, int height);
  void Reset();
  /// After an exception within a call: whatever the engine holds may be half done.
  void Abandon() { engine_.reset(); }

  Result<std::vector<uint8_t>> SaveHistory();
  Status RestoreHistory(std::span<const uint8_t> bytes);
  stillray_statistics Statistics() const;
  /// What was odd about the last frame, or "".
  const std::string& warning() const { return result_.warning; }

 private:
  Status Prepare();
  Status CheckSizes();
  Status CheckOutputs() const;
  Status CheckSize(std::string_view name, const stillray_image& image) const;
  Status Filter();
  /// Runs the engine on another thread while this one asks the callback.
  Status FilterWatched();
  /// \return whether to go on
  bool Report(double fraction) const;
  void WriteOutputs();
  void WriteOutput(const std::string& name, const stillray_image& image);
  Image1 VarianceOfPicture() const;
  Image1 ShortestHistory() const;

  std::shared_ptr<Workplace> place_;
  Settings settings_;
  std::optional<Denoiser> engine_;
  ImageMap inputs_;
  ImageMap outputs_;
  stillray_progress progress_ = nullptr;
  void* progress_user_ = nullptr;
  int width_ = 0;  ///< of all frames; 0: any
  int height_ = 0;
  double last_filter_ms_ = 0;
  Frame frame_;
  DenoisedFrame result_;
};

}  // namespace stillray::capi
