// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace stillray::view {

/// A key that went down. Dear ImGui looks at keys once per frame of the interface: it does not see
/// one that is up again by then, as after the first frames of a window, which take long.
struct KeyPress {
  int key = 0;  ///< GLFW_KEY_...
  bool control = false;
  bool repeated = false;  ///< by holding it down
};

}  // namespace stillray::view
