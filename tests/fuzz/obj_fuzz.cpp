// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Any bytes as OBJ text, and behind a line "---" as its material library and its pictures.
#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "check_scene.h"
#include "scene/obj_import.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr std::string_view kDivider = "\n---\n";
  const uint8_t* divider = std::search(data, data + size, kDivider.begin(), kDivider.end());
  const uint8_t* rest = std::min(divider + kDivider.size(), data + size);
  const auto files = [&](const std::string& /*name*/) -> stillray::Result<std::vector<uint8_t>> {
    return std::vector<uint8_t>(rest, data + size);
  };
  const stillray::Result<stillray::Scene> scene = stillray::ImportObj(
      std::span<const uint8_t>(data, static_cast<size_t>(divider - data)), files, {});
  if (scene.ok()) {
    stillray::CheckScene(*scene);
  } else {
    STILLRAY_CHECK(!scene.status().message().empty());
    STILLRAY_CHECK(scene.status().message().find('\n') == std::string::npos);
  }
  return 0;
}
