// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/gltf_import.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/checksum.h"
#include "core/lower_case.h"
#include "core/status_prefix.h"
#include "scene/data_uri.h"
#include "scene/import_common.h"
#include "scene/mesh_tools.h"

namespace stillray {

namespace {

/// Element budget of every file, and additional elements per byte. Real files have less than one
/// element per byte, unless primitives share accessors.
constexpr uint64_t kFreeElements = 4'000'000;
constexpr uint64_t kElementsPerByte = 16;
constexpr uint64_t kMaxElements = 1'000'000'000;

/// The first node whose world transform is not IsTraceable; -1 if there is none.
int FindBadTransform(const std::vector<mat4>& worlds) {
  for (size_t i = 0; i < worlds.size(); ++i) {
    if (!IsTraceable(worlds[i])) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

/// Checks the complete scene and adds a missing camera and missing lights.
void Complete(GltfImport* import) {
  Scene& scene = import->scene;
  const int bad = scene.instances.empty() ? -1 : FindBadTransform(NodeTransforms(scene, 0.0));
  if (bad >= 0) {
    const auto at = std::find(import->node_of_gltf.begin(), import->node_of_gltf.end(), bad);
    import->log.Fail(Status::BadData(
        fmt::format("nodes[{}]: its transform has components that are not finite or beyond {:g}",
                    at - import->node_of_gltf.begin(), kMaxCoordinate)));
    return;
  }
  CompleteScene(import->has_environment, &import->log, &scene);
}

/// Checksum over all files of the scene.
uint64_t ChecksumOf(ByteSpan bytes, const GltfDocument& document) {
  uint64_t sum = AddFileToChecksum(bytes, kEmptyChecksum);
  for (const auto& [name, content] : document.files) {
    sum = AddFileToChecksum(*content, sum);
  }
  return sum;
}

Result<Scene> Import(ByteSpan bytes, const std::string& base_folder, const KeepGoing& keep_going) {
  GltfImport import;
  import.keep_going = keep_going;
  STILLRAY_RETURN_IF_ERROR(ParseGltf(bytes, base_folder, &import.document));
  const auto load_buffers = [](GltfImport* state) {
    LoadBuffers(&state->document, &state->log);
    state->elements_left = std::min(
        kMaxElements, kFreeElements + kElementsPerByte * uint64_t{state->document.total_bytes});
  };
  for (void (*step)(GltfImport*) :
       {&CheckExtensions, static_cast<void (*)(GltfImport*)>(load_buffers), &ImportNodes,
        &ImportSkins, &ImportMaterials, &ImportTextures, &ImportMeshes, &ImportAnimations,
        &Complete}) {
    if (!import.GoesOn()) {
      return Status::Cancelled();
    }
    step(&import);
    STILLRAY_RETURN_IF_ERROR(import.log.status());
  }
  import.scene.checksum = ChecksumOf(bytes, import.document);
  import.scene.warnings = import.log.TakeWarnings();
  return std::move(import.scene);
}

constexpr const char* kExpected =
    "a scene in glTF 2.0 (.gltf, .glb), Wavefront OBJ (.obj) or builtin:NAME";

/// Name of a known other format, by file extension.
std::string FormatName(const std::string& extension) {
  static constexpr std::array<std::array<std::string_view, 2>, 16> kFormats = {{
      {".fbx", "Autodesk FBX"},
      {".usd", "OpenUSD"},
      {".usda", "OpenUSD"},
      {".usdc", "OpenUSD"},
      {".usdz", "OpenUSD"},
      {".blend", "Blender"},
      {".abc", "Alembic"},
      {".dae", "COLLADA"},
      {".ply", "PLY"},
      {".stl", "STL"},
      {".3ds", "3D Studio"},
      {".max", "3ds Max"},
      {".ma", "Maya"},
      {".mb", "Maya"},
      {".c4d", "Cinema 4D"},
      {".pbrt", "pbrt"},
  }};
  for (const auto& [known, name] : kFormats) {
    if (extension == known) {
      return fmt::format("{} files ({})", name, extension);
    }
  }
  return extension.empty() ? "files of this kind" : "files in " + Printable(extension);
}

/// Whether a file with another extension could be glTF: the binary form starts with a magic number,
/// and the text form is a JSON object.
bool MayBeGltf(ByteSpan bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const size_t begin = text.find_first_not_of(" \t\r\n");
  return text.starts_with("glTF") || (begin != std::string_view::npos && text[begin] == '{');
}

}  // namespace

bool GltfImport::GoesOn() {
  if (!cancelled && keep_going && !keep_going()) {
    cancelled = true;
  }
  return !cancelled;
}

bool GltfImport::Charge(const std::string& user, uint64_t count) {
  if (count > elements_left) {
    log.Fail(
        Status::BadData(fmt::format("{}: asks for {} elements, {} more than a file of {} bytes may",
                                    user, count, count - elements_left, document.total_bytes)));
    return false;
  }
  elements_left -= count;
  return true;
}

Result<Scene> LoadGltfFromMemory(const uint8_t* data, size_t size, const std::string& base_folder,
                                 const KeepGoing& keep_going) {
  try {
    return Import(ByteSpan(data, size), base_folder, keep_going);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("no memory for a scene of {} bytes", size));
  }
}

Result<Scene> LoadGltf(const std::string& path, const KeepGoing& keep_going) {
  if (path.empty()) {
    return Status::InvalidArgument(
        fmt::format("the scene's name is empty, expected {}", kExpected));
  }
  Result<std::vector<uint8_t>> bytes = ReadFileBytes(path);
  if (!bytes.ok()) {
    return bytes.status();
  }
  const std::string extension = LowerExtension(path);
  if (extension != ".gltf" && extension != ".glb" && !MayBeGltf(*bytes)) {
    return Status::Unsupported(fmt::format("{}: {} are not read, expected {}", Printable(path),
                                           FormatName(extension), kExpected));
  }
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  const std::string folder = (parent.empty() ? std::filesystem::path(".") : parent).string();
  Result<Scene> scene = LoadGltfFromMemory(bytes->data(), bytes->size(), folder, keep_going);
  if (scene.status().code() == StatusCode::kCancelled) {
    return scene.status();
  }
  if (!scene.ok()) {
    return PrefixStatus(Printable(path), scene.status());
  }
  if (scene->name.empty()) {
    scene->name = std::filesystem::path(path).stem().string();
  }
  return scene;
}

}  // namespace stillray
