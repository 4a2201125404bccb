// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/import_common.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/checksum.h"
#include "scene/mesh_tools.h"

namespace stillray {

namespace {

/// Limit on the total size of a scene's textures, against memory exhaustion.
constexpr uint64_t kMaxTextureBytes = uint64_t{4} << 30;
/// Maximum compression ratio of real images.
constexpr uint64_t kTextureBytesPerByte = 256;

/// Adds a camera that views the whole scene from the front, slightly from above and from the right.
void AddCamera(const Aabb& bounds, Scene* scene) {
  const vec3 centre = 0.5f * (bounds.min + bounds.max);
  const float radius = 0.5f * glm::length(bounds.max - bounds.min);
  const vec3 back = glm::normalize(vec3(0.4f, 0.35f, 1.0f));
  const vec3 right = glm::normalize(glm::cross(vec3(0.0f, 1.0f, 0.0f), back));
  const vec3 up = glm::cross(back, right);
  Camera camera;
  camera.name = "made camera";
  camera.node = static_cast<int>(scene->nodes.size());
  const float distance = radius / std::sin(0.5f * camera.yfov);
  Node node;
  node.name = camera.name;
  node.has_matrix = true;
  node.matrix = mat4(vec4(right, 0.0f), vec4(up, 0.0f), vec4(back, 0.0f),
                     vec4(centre + back * distance, 1.0f));
  scene->nodes.push_back(std::move(node));
  scene->cameras.push_back(std::move(camera));
}

bool HasLight(const Scene& scene) {
  const vec3 sky = scene.environment.radiance;
  return !scene.lights.empty() || sky.x > 0 || sky.y > 0 || sky.z > 0 ||
         std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const Mesh& mesh) {
           return scene.materials[static_cast<size_t>(mesh.material)].emits();
         });
}

}  // namespace

void CompleteScene(bool has_environment, ImportLog* log, Scene* scene) {
  if (scene->instances.empty()) {
    log->Fail(Status::BadData("the scene has no triangles"));
    return;
  }
  const Aabb bounds = SceneBounds(*scene, 0.0);
  const vec3 size = bounds.max - bounds.min;
  if (!(std::max({size.x, size.y, size.z}) <= kMaxCoordinate)) {
    log->Fail(Status::BadData(fmt::format("the scene is larger than {:g} units", kMaxCoordinate)));
    return;
  }
  if (scene->cameras.empty()) {
    log->Warn("the file has no perspective camera: one that sees the whole scene was made");
    AddCamera(bounds, scene);
    if (!IsTraceable(scene->nodes.back().matrix)) {
      log->Fail(Status::BadData(fmt::format(
          "the file has no camera, and one that sees the whole scene would stand beyond {:g} units",
          kMaxCoordinate)));
      return;
    }
  }
  if (!has_environment && !HasLight(*scene)) {
    log->Warn("the file has no light: surroundings of radiance 1 were added");
    scene->environment.radiance = vec3(1.0f);
  }
}

uint64_t AddFileToChecksum(std::span<const uint8_t> bytes, uint64_t sum) {
  std::array<uint8_t, sizeof(uint64_t)> length{};
  const uint64_t size = bytes.size();
  std::memcpy(length.data(), &size, sizeof(size));
  return AddToChecksum(bytes, AddToChecksum(length, sum));
}

Status TextureBudget::Take(const ImageInfo& info, size_t encoded_bytes) {
  total_ += static_cast<uint64_t>(info.width) * static_cast<uint64_t>(info.height) * 4;
  most_ = std::min(most_ + kTextureBytesPerByte * encoded_bytes, kMaxTextureBytes);
  if (total_ > most_) {
    return Status::Unsupported(fmt::format(
        "{}x{} texels in {} bytes; with it the textures take {} MB of memory, at most {} MB "
        "are read from pictures of so few bytes",
        info.width, info.height, encoded_bytes, total_ / 1'000'000, most_ / 1'000'000));
  }
  return Status::Ok();
}

}  // namespace stillray
