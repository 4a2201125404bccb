// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Replaces the window in builds without its libraries.
#include "view/window/viewer.h"

namespace stillray::view {

Status RunViewer(const ViewOptions&) {
  return Status::Unsupported(
      "this build has no window: install libglfw3-dev, libimgui-dev and libgl-dev and build again "
      "(pictures without a window: --headless-frames N -o DIR)");
}

}  // namespace stillray::view
