// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The window with its OpenGL 3.3 context and Dear ImGui.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "stillray/status.h"
#include "view/window/key_press.h"

struct GLFWwindow;

namespace stillray::view {

class GlWindow {
 public:
  /// \return kUnsupported if there is no display or no OpenGL 3.3
  static Result<std::unique_ptr<GlWindow>> Create(int width, int height, const std::string& title);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  /// Sleeps until an event occurs, or for at most `seconds`. \return whether there was user input
  /// or the window must be redrawn
  bool WaitForEvents(double seconds);
  /// Ends a WaitForEvents; may be called from any thread during the window's lifetime.
  static void Wake();
  /// Begin and end of one frame of the interface.
  void BeginFrame();
  void EndFrame();

  /// Hides the window immediately.
  void Hide();
  bool should_close() const;
  /// Switches between the whole primary monitor and the previous size. No effect if nothing
  /// changes, or if there is no monitor.
  void SetFullscreen(bool on);
  void SetTitle(const std::string& title);
  /// Paths of files dropped on the window since the last call.
  std::vector<std::string> TakeDroppedFiles();
  /// Keys pressed since the last call, in order.
  std::vector<KeyPress> TakeKeys() { return std::exchange(keys_, {}); }
  GLFWwindow* handle() const { return window_; }

 private:
  explicit GlWindow(GLFWwindow* window) : window_(window) {}

  void CountInput();

  GLFWwindow* window_;
  std::vector<std::string> dropped_;
  std::vector<KeyPress> keys_;
  bool input_ = false;
  int windowed_[4] = {0, 0, 0, 0};  ///< position and size before fullscreen
};

}  // namespace stillray::view
