// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Shader packs of a build without Vulkan, which has none.
#include "denoise/shader_pack.h"

namespace stillray {
namespace {

Status WithoutVulkan() {
  return Status::Unsupported(
      "this stillray was built without Vulkan and has no shaders (its headers or glslc were "
      "missing, or STILLRAY_BUILD_VULKAN was off)");
}

}  // namespace

Result<ShaderTable> MakeShaderTable() {
  return WithoutVulkan();
}

std::span<const std::string_view> ScheduleInputNames() {
  return {};
}

std::span<const std::string_view> ScheduleOutputNames() {
  return {};
}

Result<FrameSchedule> MakeFrameSchedule(const ScheduleOptions&) {
  return WithoutVulkan();
}

}  // namespace stillray
