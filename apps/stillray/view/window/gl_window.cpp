// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/window/gl_window.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GL/gl.h>
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

namespace stillray::view {
namespace {

constexpr float kFontPixels = 15;
constexpr const char* kFonts[] = {
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"};

std::string g_last_error;  // NOLINT: GLFW reports errors to a plain function

void KeepError(int, const char* text) {
  g_last_error = text;
}

void UseStyle(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.PopupRounding = 4;
  style.WindowBorderSize = 0;
  style.ItemSpacing = {8, 5};
  style.FramePadding = {6, 3};
  style.ScaleAllSizes(scale);
  ImVec4* colours = style.Colors;
  const ImVec4 accent(0.20f, 0.55f, 0.72f, 1.0f);
  const ImVec4 quiet(0.20f, 0.22f, 0.25f, 1.0f);
  colours[ImGuiCol_WindowBg] = {0.10f, 0.11f, 0.12f, 1.0f};
  colours[ImGuiCol_PopupBg] = {0.13f, 0.14f, 0.16f, 0.98f};
  colours[ImGuiCol_MenuBarBg] = {0.13f, 0.14f, 0.16f, 1.0f};
  colours[ImGuiCol_FrameBg] = quiet;
  colours[ImGuiCol_FrameBgHovered] = {0.26f, 0.29f, 0.33f, 1.0f};
  colours[ImGuiCol_FrameBgActive] = {0.28f, 0.33f, 0.38f, 1.0f};
  colours[ImGuiCol_Header] = {0.16f, 0.24f, 0.29f, 1.0f};
  colours[ImGuiCol_HeaderHovered] = {0.20f, 0.33f, 0.41f, 1.0f};
  colours[ImGuiCol_HeaderActive] = {0.20f, 0.40f, 0.51f, 1.0f};
  colours[ImGuiCol_Button] = {0.22f, 0.27f, 0.31f, 1.0f};
  colours[ImGuiCol_ButtonHovered] = {0.24f, 0.40f, 0.49f, 1.0f};
  colours[ImGuiCol_ButtonActive] = accent;
  colours[ImGuiCol_SliderGrab] = accent;
  colours[ImGuiCol_SliderGrabActive] = {0.35f, 0.72f, 0.88f, 1.0f};
  colours[ImGuiCol_CheckMark] = {0.45f, 0.80f, 0.95f, 1.0f};
  colours[ImGuiCol_TitleBgActive] = {0.16f, 0.30f, 0.38f, 1.0f};
  colours[ImGuiCol_ModalWindowDimBg] = {0.0f, 0.0f, 0.0f, 0.45f};
  colours[ImGuiCol_Separator] = {0.25f, 0.27f, 0.30f, 1.0f};
}

void UseFont(float scale) {
  ImGuiIO& io = ImGui::GetIO();
  for (const char* path : kFonts) {
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored) &&
        io.Fonts->AddFontFromFileTTF(path, kFontPixels * scale) != nullptr) {
      return;
    }
  }
  io.Fonts->AddFontDefault();
  io.FontGlobalScale = scale;
}

Status NoWindow(const char* what) {
  return Status::Unsupported(
      fmt::format("{}: {} (pictures without a window: --headless-frames N -o DIR)", what,
                  g_last_error.empty() ? "unknown reason" : g_last_error));
}

}  // namespace

/// Counts user input, as opposed to window system events: software OpenGL generates events in every
/// frame, and redrawing for them would never stop. Called by Dear ImGui's backend.
void GlWindow::CountInput() {
  static constexpr auto kMark = [](GLFWwindow* window) {
    static_cast<GlWindow*>(glfwGetWindowUserPointer(window))->input_ = true;
  };
  glfwSetWindowUserPointer(window_, this);
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double, double) { kMark(w); });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int, int, int) { kMark(w); });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double) { kMark(w); });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int modifiers) {
    kMark(w);
    if (action != GLFW_RELEASE) {
      auto* self = static_cast<GlWindow*>(glfwGetWindowUserPointer(w));
      self->keys_.push_back({key, (modifiers & GLFW_MOD_CONTROL) != 0, action == GLFW_REPEAT});
    }
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned) { kMark(w); });
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int) { kMark(w); });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* w, int) { kMark(w); });
  glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* w, int, int) { kMark(w); });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { kMark(w); });
  glfwSetWindowCloseCallback(window_, [](GLFWwindow* w) { kMark(w); });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    auto* self = static_cast<GlWindow*>(glfwGetWindowUserPointer(w));
    self->dropped_.insert(self->dropped_.end(), paths, paths + count);
    self->input_ = true;
  });
}

Result<std::unique_ptr<GlWindow>> GlWindow::Create(int width, int height,
                                                   const std::string& title) {
  glfwSetErrorCallback(KeepError);
  if (glfwInit() != GLFW_TRUE) {
    return NoWindow("no window can be opened");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  GLFWwindow* handle = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (handle == nullptr) {
    const Status status = NoWindow("no window with OpenGL 3.3 can be opened");
    glfwTerminate();
    return status;
  }
  std::unique_ptr<GlWindow> window(new GlWindow(handle));
  glfwMakeContextCurrent(handle);
  glfwSwapInterval(1);
  glfwSetWindowSizeLimits(handle, 480, 320, GLFW_DONT_CARE, GLFW_DONT_CARE);
  window->CountInput();

  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // do not write a file to the current folder
  float scale = 1;
  glfwGetWindowContentScale(handle, &scale, nullptr);
  scale = std::clamp(scale, 0.75f, 4.0f);
  UseStyle(scale);
  UseFont(scale);
  ImGui_ImplGlfw_InitForOpenGL(handle, true);
  // Tab switches the panes instead of the keyboard focus.
  ImGui::GetIO().KeyMap[ImGuiKey_Tab] = -1;
  ImGui_ImplOpenGL3_Init("#version 330 core");
  return window;
}

GlWindow::~GlWindow() {
  if (ImGui::GetCurrentContext() != nullptr) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool GlWindow::WaitForEvents(double seconds) {
  glfwWaitEventsTimeout(seconds);
  return std::exchange(input_, false);
}

void GlWindow::Wake() {
  glfwPostEmptyEvent();
}

void GlWindow::BeginFrame() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
}

void GlWindow::EndFrame() {
  ImGui::Render();
  int width = 0;
  int height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  glViewport(0, 0, width, height);
  glClearColor(0.06f, 0.06f, 0.07f, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
}

void GlWindow::Hide() {
  glfwHideWindow(window_);
  glfwPollEvents();
}

void GlWindow::SetFullscreen(bool on) {
  if (on == (glfwGetWindowMonitor(window_) != nullptr)) {
    return;
  }
  if (!on) {
    glfwSetWindowMonitor(window_, nullptr, windowed_[0], windowed_[1], windowed_[2], windowed_[3],
                         GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) {
    return;
  }
  glfwGetWindowPos(window_, &windowed_[0], &windowed_[1]);
  glfwGetWindowSize(window_, &windowed_[2], &windowed_[3]);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool GlWindow::should_close() const {
  return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

void GlWindow::SetTitle(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

std::vector<std::string> GlWindow::TakeDroppedFiles() {
  return std::exchange(dropped_, {});
}

}  // namespace stillray::view
