// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/loaded_scene.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <vector>

#include <fmt/format.h>

#include "stillray/io.h"
#include "view/scene_outline.h"

namespace stillray::view {
namespace {

constexpr int kSmallestSide = 16;
constexpr int kLargestSide = 8192;
/// Duration of submissions: short, since the window uses the same device, and obsolete frames are
/// cancelled between submissions.
constexpr double kSubmissionMs = 30;

std::string FileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

Status AddEnvironment(const std::string& path, Scene* scene) {
  bool linear = false;
  Result<Image3> map = ReadImage(path, &linear);
  if (!map.ok()) {
    return Status(map.status().code(), "environment: " + map.status().message());
  }
  if (!linear) {
    return Status::InvalidArgument(fmt::format(
        "environment {} is a display picture, expected radiance as .hdr or .exr", path));
  }
  scene->environment.map = std::move(map.value());
  scene->environment.radiance = vec3(1.0f);
  return Status::Ok();
}

/// Reports the phases of loading a scene, and handles cancellation.
class Phases {
 public:
  Phases(int steps, const LoadReport& report) : steps_(steps), report_(report) {}

  Status Begin(const std::string& what) { return Tell({what, step_++, steps_, -1}); }
  Status At(const std::string& what, double fraction) {
    return Tell({what, step_ - 1, steps_, fraction});
  }
  /// Callback for multithreaded work: serialises the calls of the report.
  KeepGoing KeepGoingWith(const std::string& what) {
    return [this, what] {
      constexpr std::chrono::milliseconds kInterval(20);
      const std::lock_guard<std::mutex> lock(mutex_);
      const auto now = std::chrono::steady_clock::now();
      if (now - asked_ > kInterval) {
        asked_ = now;
        goes_on_ = At(what, -1).ok();
      }
      return goes_on_;
    };
  }

 private:
  Status Tell(const LoadPhase& phase) {
    return report_(phase) ? Status::Ok() : Status::Cancelled();
  }

  int step_ = 0;
  int steps_;
  const LoadReport& report_;
  std::mutex mutex_;
  std::chrono::steady_clock::time_point asked_;
  bool goes_on_ = true;
};

/// Reads a file into the page cache, so that reading from a slow disk has a progress and can be
/// cancelled. Errors are reported by the importer.
Status Fetch(const std::string& path, Phases* phases) {
  std::error_code error;
  const auto bytes = static_cast<double>(std::filesystem::file_size(path, error));
  if (error || !std::filesystem::is_regular_file(path, error)) {
    return Status::Ok();
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<char> piece(size_t{1} << 20);
  double read = 0;
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
    read += static_cast<double>(file.gcount());
    STILLRAY_RETURN_IF_ERROR(phases->At(
        fmt::format("reading {}: {:.0f} of {:.0f} MB", FileName(path), read / 1e6, bytes / 1e6),
        read / std::max(bytes, 1.0)));
  }
  return Status::Ok();
}

int Side(int pixels, float scale) {
  return std::clamp(static_cast<int>(std::lround(static_cast<float>(pixels) * scale)),
                    kSmallestSide, kLargestSide);
}

}  // namespace

Result<LoadedScene> LoadForView(const SceneRequest& request, const ViewSettings& settings,
                                const LoadReport& report, const Device& device) {
  const bool has_environment = !request.environment.empty();
  Phases phases(has_environment ? 4 : 3, report);
  STILLRAY_RETURN_IF_ERROR(phases.Begin("reading " + FileName(request.scene)));
  STILLRAY_RETURN_IF_ERROR(Fetch(request.scene, &phases));
  const std::string outline = ToText(OutlineOf(request.scene));
  const std::string unpacking =
      "unpacking " + (outline.empty() ? FileName(request.scene) : outline);
  STILLRAY_RETURN_IF_ERROR(phases.Begin(unpacking));
  Result<Scene> scene = LoadScene(request.scene, phases.KeepGoingWith(unpacking));
  if (!scene.ok()) {
    return scene.status();
  }
  LoadedScene loaded;
  loaded.request = request;
  loaded.scene = std::make_unique<Scene>(std::move(scene.value()));
  if (has_environment) {
    STILLRAY_RETURN_IF_ERROR(phases.Begin("reading " + FileName(request.environment)));
    STILLRAY_RETURN_IF_ERROR(AddEnvironment(request.environment, loaded.scene.get()));
  }
  const std::string building =
      fmt::format("building the BVH of {} triangles", loaded.scene->TriangleCount());
  STILLRAY_RETURN_IF_ERROR(phases.Begin(building));
  TraceOptions options;
  options.submission_ms = kSubmissionMs;
  options.keep_going = phases.KeepGoingWith(building);
  Result<std::unique_ptr<DeviceRenderer>> renderer = DeviceRenderer::Create(
      device, *loaded.scene, RenderSettingsFor(settings, settings.rate, settings.scale), options);
  if (!renderer.ok()) {
    return renderer.status();
  }
  loaded.renderer = std::move(renderer.value());
  return loaded;
}

void PictureSize(const ViewSettings& settings, float scale, int* width, int* height) {
  *width = Side(settings.width, scale);
  *height = Side(settings.height, scale);
}

RenderSettings RenderSettingsFor(const ViewSettings& settings, const SampleRate& rate,
                                 float scale) {
  RenderSettings render = settings.render;
  PictureSize(settings, scale, &render.width, &render.height);
  render.spp = rate.spp;
  render.cycle = rate.cycle;
  // Without temporal antialiasing jitter would only make edges flicker.
  render.jitter = render.jitter && settings.denoise.antialias != Antialias::kOff;
  return render;
}

}  // namespace stillray::view
