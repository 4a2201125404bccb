// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs the viewer's work on separate threads. Calls never block during loading or tracing, and
/// must be made from the interface thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "view/live_metrics.h"
#include "view/scene_loader.h"
#include "view/triple_buffer.h"
#include "view/view_frame.h"
#include "view/view_session.h"
#include "view/view_settings.h"

namespace stillray::view {

struct EngineMessage {
  bool is_error = false;
  std::string text;
};

/// The displayed scene.
struct SceneInfo {
  uint64_t number = 0;  ///< running number of opened scenes, from 1; 0: none yet
  SceneRequest request;
  std::vector<std::string> cameras;
  std::vector<std::string> warnings;
  size_t triangles = 0;
  double length = 0;  ///< duration of its animation in seconds
  bool moving_lights = false;
};

class ViewEngine {
 public:
  /// \param wake     called from other threads when new content is available
  /// \param devices  devices that trace and filter frames; if one fails, the CPU replaces it, with
  ///     a message
  ViewEngine(const ViewSettings& settings, std::function<void()> wake,
             const RenderDevices& devices = {});
  /// Cancels the frame in progress, and loading (see SceneLoader::abandoned).
  ~ViewEngine();

  /// Loads a scene in the background, while the current scene remains displayed. A later request
  /// replaces an earlier one. Failures are reported as messages.
  void Open(const SceneRequest& request);
  /// Sets the settings of the next frame. \return the number of this call, stored in frames that
  /// use the settings (ViewFrame::posted)
  uint64_t Post(const ViewSettings& settings);
  /// Number of the newest frame, taken or not.
  uint64_t frames_made() const { return frames_made_; }
  /// The newest frame, if it has not been taken; valid until the next call.
  const ViewFrame* TakeFrame() { return frames_.Take(); }
  std::vector<EngineMessage> TakeMessages();
  LoadState load_state() const { return loader_.state(); }
  SceneInfo scene_info() const;

  /// Saves the composed image as .png or .jpg, at least in the window's size; or, in frame
  /// resolution, the values of all panes as .exr, or the colour of the first colour pane as .hdr.
  void Save(const std::string& path);
  /// Records all following frames to a video until StopClip().
  void StartClip(const std::string& path, double fps);
  void StopClip();
  /// Writes a file between two frames. \param job its error, or "saved PATH", is reported as a
  /// message
  void SaveFile(const std::string& path, std::function<Status()> job);
  bool recording() const { return recording_; }

 private:
  using Job = std::function<void()>;
  void WorkLoop();
  bool WaitForWork();
  void TakeLoadedScene();
  void RunJobs();
  void MakeFrame();
  Rgb8Image AsOnScreen(const std::vector<Rgb8Image>& pictures) const;
  void RecordFrame(const ViewFrame& frame);
  void EndClip();
  Result<Rgb8Image> ShownPicture() const;
  Status SaveNow(const std::string& path) const;
  Status SaveRadiance(const std::string& path) const;
  bool IsDone(const ViewSettings& settings, const ViewFrame& frame) const;
  void AddJob(Job job);
  void Tell(bool is_error, std::string text);

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable work_;  // wakes the worker for settings, a scene, a job or shutdown
  std::atomic<bool> stop_ = false;

  // Guarded by mutex_.
  ViewSettings settings_;
  RenderDevices devices_;  // devices of the next scene
  SceneInfo scene_info_;
  std::deque<Job> jobs_;
  std::vector<EngineMessage> messages_;

  std::atomic<uint64_t> posted_ = 0;  // number of calls of Post
  std::atomic<uint64_t> frames_made_ = 0;
  std::atomic<bool> scene_waiting_ = false;  // the loader has an outcome
  std::atomic<bool> recording_ = false;
  TripleBuffer<ViewFrame> frames_;

  // Used only by the worker thread.
  std::unique_ptr<ViewSession> session_;
  std::unique_ptr<VideoWriter> clip_;
  std::string clip_path_;
  std::vector<float> dividers_;
  int area_width_ = 0;  // screen area of the last frame
  int area_height_ = 0;
  bool sharp_pixels_ = false;
  // The last images; shared images have no pixels.
  std::vector<Rgb8Image> shown_;
  std::vector<std::string> shown_panes_;
  LiveMetrics metrics_;
  double last_frame_at_ = 0;
  uint64_t last_posted_ = 0;
  bool idle_ = false;  // idle until the settings change

  SceneLoader loader_;  // last, since they use the members above
  std::thread worker_;
};

}  // namespace stillray::view
