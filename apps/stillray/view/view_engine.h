// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer's work on threads of its own. Every call returns at once, whatever is being loaded or
/// traced; all are meant for one thread, that of the interface.
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

/// The scene that is being shown.
struct SceneInfo {
  uint64_t number = 0;  ///< of scenes opened, from 1; 0: none yet
  SceneRequest request;
  std::vector<std::string> cameras;
  std::vector<std::string> warnings;
  size_t triangles = 0;
  double length = 0;  ///< of its animation, seconds
  bool moving_lights = false;
};

class ViewEngine {
 public:
  /// \param wake    called from other threads whenever there is something new to show
  /// \param device  where frames are traced and filtered; when it fails, the CPU goes on, with a
  ///                message
  ViewEngine(const ViewSettings& settings, std::function<void()> wake, Device device = Device());
  /// Gives up the frame being made, and a scene that is being loaded (see SceneLoader::abandoned).
  ~ViewEngine();

  /// Loads a scene in the background; the one being shown stays until it is there. A later request
  /// takes the place of an earlier one. Failures come as messages.
  void Open(const SceneRequest& request);
  /// What the next frame is to be like. \return the number that frames bear which know of it
  /// (ViewFrame::posted)
  uint64_t Post(const ViewSettings& settings);
  /// Number of the newest frame, taken or not.
  uint64_t frames_made() const { return frames_made_; }
  /// The newest frame, if there is one that has not been taken; valid until the next call.
  const ViewFrame* TakeFrame() { return frames_.Take(); }
  std::vector<EngineMessage> TakeMessages();
  LoadState load_state() const { return loader_.state(); }
  SceneInfo scene_info() const;

  /// Writes what is shown: the composed picture as .png, at least as large as the window shows it,
  /// or the numbers of all panes as .exr, in the resolution that they have.
  void Save(const std::string& path);
  /// Every frame from here on goes into a video until StopClip().
  void StartClip(const std::string& path, double fps);
  void StopClip();
  /// Writes a file between two frames. \param job  what fails it says, or "saved PATH" is told
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
  bool IsDone(const ViewSettings& settings, const ViewFrame& frame) const;
  void AddJob(Job job);
  void Tell(bool is_error, std::string text);

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable work_;  // for the worker: settings, a scene, a job, the end
  std::atomic<bool> stop_ = false;

  // Guarded by mutex_.
  ViewSettings settings_;
  Device device_;  // for the next scene
  SceneInfo scene_info_;
  std::deque<Job> jobs_;
  std::vector<EngineMessage> messages_;

  std::atomic<uint64_t> posted_ = 0;  // counts calls of Post
  std::atomic<uint64_t> frames_made_ = 0;
  std::atomic<bool> scene_waiting_ = false;  // the loader has an outcome
  std::atomic<bool> recording_ = false;
  TripleBuffer<ViewFrame> frames_;

  // The worker's own.
  std::unique_ptr<ViewSession> session_;
  std::unique_ptr<VideoWriter> clip_;
  std::string clip_path_;
  std::vector<float> dividers_;
  int area_width_ = 0;  // of the area on the screen, for the last frame
  int area_height_ = 0;
  bool sharp_pixels_ = false;
  // What was shown last; pictures that were shared have no pixels.
  std::vector<Rgb8Image> shown_;
  std::vector<std::string> shown_panes_;
  LiveMetrics metrics_;
  double last_frame_at_ = 0;
  uint64_t last_posted_ = 0;
  bool idle_ = false;  // nothing would change until settings do

  SceneLoader loader_;  // last: they use everything above
  std::thread worker_;
};

}  // namespace stillray::view
