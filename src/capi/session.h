// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The implementation of a stillray_denoiser: settings, descriptions of images, and the engine with
/// its history.
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
#include "stillray/two_way.hpp"

namespace stillray::capi {

/// Threads and the filtering device, shared by a device and its denoisers.
struct Workplace {
  Workplace(int n, Device filter_device) : threads(n), arena(n), device(std::move(filter_device)) {}
  int threads;
  tbb::task_arena arena;
  Device device;
};

/// The sequence of a stillray_denoiser. Errors are returned as Status; the only exception is
/// std::bad_alloc.
class Session {
 public:
  Session(std::shared_ptr<Workplace> place, const Settings& settings)
      : place_(std::move(place)), settings_(settings) {}

  const Settings& settings() const { return settings_; }
  void SetSettings(const Settings& settings) {
    settings_ = settings;
    settings_changed_ = true;
  }
  /// Names of the outputs available with the current settings.
  std::vector<std::string> OutputNames() const { return OutputNames(settings_); }

  /// \param image  nullptr: remove it
  Status SetInput(std::string_view name, const stillray_image* image);
  Status SetOutput(std::string_view name, const stillray_image* image);
  Status SetJitter(float x, float y);
  Status SetFocalPixels(float focal_pixels);
  void SetProgress(stillray_progress progress, void* user);
  void SetFrameIndex(int64_t index) { index_ = index; }

  Status Execute();
  Status Push(int32_t cut);
  void Finish();
  /// \param pulled  whether a frame was ready
  Status Pull(bool* pulled);
  stillray_waiting Waiting() const;
  Status MemoryNeed(stillray_memory_need* need);
  Status Resize(int width, int height);
  void Reset();
  /// After an exception within a call: discards the engine, whose state may be inconsistent.
  void Abandon() {
    engine_.reset();
    two_way_.reset();
  }

  Result<std::vector<uint8_t>> SaveHistory();
  Status RestoreHistory(std::span<const uint8_t> bytes);
  stillray_statistics Statistics() const;
  /// A warning about the last frame, or "".
  const std::string& warning() const { return result_.warning; }

 private:
  static std::vector<std::string> OutputNames(const Settings& settings);
  Status Prepare();
  Status PrepareTwoWay();
  /// \param frame  receives the size of the inputs
  /// \param first  [out] optional: the quoted name of the input with which the sizes of all others
  ///     are compared
  Status CheckInputSizes(Frame* frame, std::string* first = nullptr) const;
  /// \param expected  the frame's size, and its origin
  Status CheckOutputs(const Settings& settings, int width, int height,
                      std::string_view expected) const;
  Status RefuseWhileFramesWait(const char* what) const;
  std::vector<std::string> EngineOutputs() const;
  void NumberFrame();
  Status CheckSize(std::string_view name, const stillray_image& image) const;
  Status Filter();
  /// Runs the engine on another thread while this one polls the callback.
  Status FilterWatched();
  /// As above, for a pushed frame that is ready.
  Status PullWatched();
  /// \return whether to continue
  bool Report(double fraction) const;
  void WriteOutputs(const Settings& settings);
  void WriteOutput(const Settings& settings, const std::string& name, const stillray_image& image);
  Image1 VarianceOfPicture(const Settings& settings) const;
  Image1 ShortestHistory() const;

  std::shared_ptr<Workplace> place_;
  Settings settings_;
  std::optional<Denoiser> engine_;
  std::optional<TwoWayDenoiser> two_way_;  ///< of the pushed frames
  bool settings_changed_ = false;          ///< since two_way_ was created
  ImageMap inputs_;
  ImageMap outputs_;
  stillray_progress progress_ = nullptr;
  void* progress_user_ = nullptr;
  int width_ = 0;  ///< of all frames; 0: any
  int height_ = 0;
  double last_filter_ms_ = 0;
  int64_t index_ = 0;  ///< of the next frame
  float jitter_x_ = 0;
  float jitter_y_ = 0;
  float focal_pixels_ = 0;
  Frame frame_;  ///< the last finished one, or the one in progress
  DenoisedFrame result_;
};

}  // namespace stillray::capi
