// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace stillray::view {

/// A key press event. Dear ImGui samples keys once per interface frame, and misses keys that are
/// released within a frame, as during the long first frames of a window.
struct KeyPress {
  int key = 0;  ///< GLFW_KEY_...
  bool control = false;
  bool repeated = false;  ///< auto-repeat
};

}  // namespace stillray::view
