// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Any bytes as a scene: LoadGltfFromMemory must give a scene that keeps its promises, or an error.
#include <cstdint>

#include "check_scene.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const stillray::Result<stillray::Scene> scene = stillray::LoadGltfFromMemory(data, size, "");
  if (scene.ok()) {
    stillray::CheckScene(*scene);
  } else {
    STILLRAY_CHECK(!scene.status().message().empty());
    STILLRAY_CHECK(scene.status().message().find('\n') == std::string::npos);
  }
  return 0;
}
