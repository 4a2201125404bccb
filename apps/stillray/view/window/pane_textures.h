// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The pictures of a frame as OpenGL textures.
#pragma once

#include <cstdint>
#include <vector>

#include "view/view_frame.h"

namespace stillray::view {

class PaneTextures {
 public:
  PaneTextures() = default;
  /// Needs the context that the textures were made in.
  ~PaneTextures();
  PaneTextures(const PaneTextures&) = delete;
  PaneTextures& operator=(const PaneTextures&) = delete;

  /// Uploads the pictures if they are others than the last ones.
  void Upload(const ViewFrame& frame, bool sharp_pixels);
  int count() const { return count_; }
  /// OpenGL's name of a pane's texture.
  uint32_t texture(int pane) const { return panes_[static_cast<size_t>(pane)].name; }

 private:
  struct Pane {
    uint32_t name = 0;
    int width = 0;
    int height = 0;
  };
  void UploadPane(const Rgb8Image& picture, Pane* pane) const;

  std::vector<Pane> panes_;
  int count_ = 0;
  const ViewFrame* shown_ = nullptr;
  uint64_t shown_number_ = 0;
  bool sharp_ = false;
};

}  // namespace stillray::view
