// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The window with its OpenGL 3.3 context and Dear ImGui set up in it.
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

  /// Sleeps until there is an event, or for so many seconds at most. \return whether the user did
  /// something, or the system wants the window drawn again
  bool WaitForEvents(double seconds);
  /// Ends a WaitForEvents; may be called from any thread while the window lives.
  static void Wake();
  /// Everything between these two is one frame of the interface.
  void BeginFrame();
  void EndFrame();

  /// Takes it off the screen at once.
  void Hide();
  bool should_close() const;
  /// Over the whole primary monitor, or back to where it was. Nothing happens if it is so already,
  /// or if there is no monitor.
  void SetFullscreen(bool on);
  void SetTitle(const std::string& title);
  /// Paths of files that were dropped on the window since the last call.
  std::vector<std::string> TakeDroppedFiles();
  /// Keys that went down since the last call, in their order.
  std::vector<KeyPress> TakeKeys() { return std::exchange(keys_, {}); }
  GLFWwindow* handle() const { return window_; }

 private:
  explicit GlWindow(GLFWwindow* window) : window_(window) {}

  void CountInput();

  GLFWwindow* window_;
  std::vector<std::string> dropped_;
  std::vector<KeyPress> keys_;
  bool input_ = false;
  int windowed_[4] = {0, 0, 0, 0};  ///< place and size before the full screen
};

}  // namespace stillray::view
