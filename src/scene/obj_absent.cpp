// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/printable.h"
#include "scene/obj_import.h"

namespace stillray {

namespace {

constexpr const char* kAbsent =
    "this build does not read Wavefront OBJ: tinyobjloader was not found when stillray was built";

}  // namespace

Result<Scene> LoadObj(const std::string& path, const KeepGoing& /*keep_going*/) {
  return Status::Unsupported(fmt::format("{}: {}", Printable(path), kAbsent));
}

Result<Scene> ImportObj(std::span<const uint8_t> /*bytes*/, const ObjFiles& /*files*/,
                        const KeepGoing& /*keep_going*/) {
  return Status::Unsupported(kAbsent);
}

bool ReadsObj() {
  return false;
}

}  // namespace stillray
