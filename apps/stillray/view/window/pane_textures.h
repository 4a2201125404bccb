// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images of a frame as OpenGL textures.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "view/view_frame.h"
#include "view/window/shared_imports.h"

namespace stillray::view {

class PaneTextures {
 public:
  PaneTextures() = default;
  /// Requires the textures' OpenGL context to be current.
  ~PaneTextures();
  PaneTextures(const PaneTextures&) = delete;
  PaneTextures& operator=(const PaneTextures&) = delete;

  /// Uploads the images if they have changed.
  /// \return the reason if shared images cannot be imported; their panes are then unchanged
  Status Upload(const ViewFrame& frame, bool sharp_pixels);
  /// Checks support for shared images. \return kUnsupported naming the missing OpenGL features
  Status PrepareSharing();
  int count() const { return count_; }
  /// The OpenGL name of a pane's texture.
  uint32_t texture(int pane) const { return panes_[static_cast<size_t>(pane)].name; }

 private:
  struct Pane {
    uint32_t name = 0;
    int width = 0;
    int height = 0;
    uint32_t format = 0;  ///< OpenGL format of the pixels
  };
  /// Binds the texture, reallocated if size or format differ.
  void BindPane(int width, int height, uint32_t format, Pane* pane) const;
  Status UploadPane(const ViewFrame& frame, size_t index);

  std::unique_ptr<SharedImports> imports_;  ///< nullptr: images are not shared
  std::vector<Pane> panes_;
  int count_ = 0;
  const ViewFrame* shown_ = nullptr;
  uint64_t shown_number_ = 0;
  bool sharp_ = false;
};

}  // namespace stillray::view
