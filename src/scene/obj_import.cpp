// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "scene/obj_import.h"

#include <algorithm>
#include <filesystem>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "core/checksum.h"
#include "core/status_prefix.h"
#include "scene/data_uri.h"

namespace stillray {

namespace {

namespace fs = std::filesystem;

bool GoesOn(const ObjImport& import) {
  return !import.keep_going || import.keep_going();
}

Result<Scene> Import(std::span<const uint8_t> bytes, const ObjFiles& files,
                     const KeepGoing& keep_going) {
  ObjImport import;
  import.files = files;
  import.keep_going = keep_going;
  import.checksum = AddFileToChecksum(bytes, kEmptyChecksum);
  STILLRAY_RETURN_IF_ERROR(CheckObjText(bytes, &import.log, &import.text));
  for (void (*step)(ObjImport*) : {&ImportObjMaterials, &ImportObjMeshes}) {
    if (!GoesOn(import)) {
      return Status::Cancelled();
    }
    step(&import);
    STILLRAY_RETURN_IF_ERROR(import.log.status());
  }
  CompleteScene(false, &import.log, &import.scene);
  STILLRAY_RETURN_IF_ERROR(import.log.status());
  import.scene.checksum = import.checksum;
  import.scene.warnings = import.log.TakeWarnings();
  return std::move(import.scene);
}

/// Reads a file in `folder` or below it. Backslashes, as in Windows paths, are accepted.
Result<std::vector<uint8_t>> ReadBeside(const std::string& folder, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.empty() || relative.is_absolute() || *relative.begin() == ".." ||
      (name.size() > 1 && name[1] == ':')) {
    return Status::BadData(
        fmt::format("'{}' lies outside the folder of the scene", Printable(name)));
  }
  return ReadFileBytes((fs::path(folder) / relative).string());
}

}  // namespace

bool ReadsObj() {
  return true;
}

Result<Scene> ImportObj(std::span<const uint8_t> bytes, const ObjFiles& files,
                        const KeepGoing& keep_going) {
  try {
    return Import(bytes, files, keep_going);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory(fmt::format("no memory for a scene of {} bytes", bytes.size()));
  }
}

Result<Scene> LoadObj(const std::string& path, const KeepGoing& keep_going) {
  const Result<std::vector<uint8_t>> bytes = ReadFileBytes(path);
  if (!bytes.ok()) {
    return bytes.status();
  }
  const fs::path parent = fs::path(path).parent_path();
  const std::string folder = (parent.empty() ? fs::path(".") : parent).string();
  Result<Scene> scene = ImportObj(
      *bytes, [&](const std::string& name) { return ReadBeside(folder, name); }, keep_going);
  if (scene.status().code() == StatusCode::kCancelled) {
    return scene.status();
  }
  if (!scene.ok()) {
    return PrefixStatus(Printable(path), scene.status());
  }
  scene->name = fs::path(path).stem().string();
  return scene;
}

}  // namespace stillray
