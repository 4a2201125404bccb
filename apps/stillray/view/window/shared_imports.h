// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Imports images from the denoiser's device memory as textures, without a copy through the host.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "stillray/shared_picture.h"

namespace stillray::view {

/// Requires the OpenGL context in which it was created. Memory is imported at its first use, and
/// released with its image.
class SharedImports {
 public:
  /// \return kUnsupported naming the missing OpenGL features
  static Result<std::unique_ptr<SharedImports>> Create();
  ~SharedImports();
  SharedImports(const SharedImports&) = delete;
  SharedImports& operator=(const SharedImports&) = delete;

  /// Imports the image unless it has already been imported.
  /// \return kUnsupported if its device differs from OpenGL's; errors of the device
  Status Import(const std::shared_ptr<const SharedPicture>& picture);
  /// Copies an imported image to the bound texture of equal size on the device; keeps a reference
  /// until the copy is finished.
  Status CopyToTexture(const std::shared_ptr<const SharedPicture>& picture);

 private:
  struct Functions;
  struct Imported {
    std::weak_ptr<const SharedPicture> picture;
    uint32_t memory = 0;
    uint32_t buffer = 0;
  };
  struct Copy {
    std::shared_ptr<const SharedPicture> picture;
    void* done = nullptr;  ///< GLsync
  };

  explicit SharedImports(std::unique_ptr<Functions> functions);
  bool IsOnThisDevice(const SharedPicture& picture) const;
  const Imported* Find(const std::shared_ptr<const SharedPicture>& picture) const;
  Status Make(const SharedPicture& picture, Imported* imported) const;
  void Delete(const Imported& imported) const;
  void LetGo();

  std::unique_ptr<Functions> gl_;
  std::vector<Imported> imports_;
  std::deque<Copy> copies_;  ///< in flight, oldest first
};

}  // namespace stillray::view
