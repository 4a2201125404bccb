// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/loaded_scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "stillray/io.h"

namespace stillray::view {
namespace {

constexpr int kSmallestSide = 16;
constexpr int kLargestSide = 8192;

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

int Side(int pixels, float scale) {
  return std::clamp(static_cast<int>(std::lround(static_cast<float>(pixels) * scale)),
                    kSmallestSide, kLargestSide);
}

}  // namespace

Result<LoadedScene> LoadForView(const SceneRequest& request, const ViewSettings& settings,
                                const LoadReport& report) {
  report("reading " + FileName(request.scene));
  Result<Scene> scene = LoadScene(request.scene);
  if (!scene.ok()) {
    return scene.status();
  }
  LoadedScene loaded;
  loaded.request = request;
  loaded.scene = std::make_unique<Scene>(std::move(scene.value()));
  if (!request.environment.empty()) {
    report("reading " + FileName(request.environment));
    STILLRAY_RETURN_IF_ERROR(AddEnvironment(request.environment, loaded.scene.get()));
  }
  report(fmt::format("sorting {} triangles", loaded.scene->TriangleCount()));
  Result<std::unique_ptr<Renderer>> renderer =
      Renderer::Create(*loaded.scene, RenderSettingsFor(settings, settings.rate, settings.scale));
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
  RenderSettings render;
  PictureSize(settings, scale, &render.width, &render.height);
  render.spp = rate.spp;
  render.cycle = rate.cycle;
  render.guides = settings.sparse_guides ? GuideCoverage::kSparse : GuideCoverage::kFull;
  render.bounces = settings.bounces;
  render.seed = settings.seed;
  render.sampler = settings.sampler;
  // Without antialiasing in time a moving sample point would only make edges shake.
  render.jitter = settings.denoise.antialias != Antialias::kOff;
  render.regularise = settings.regularise;
  return render;
}

}  // namespace stillray::view
