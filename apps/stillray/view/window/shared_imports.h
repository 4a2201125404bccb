// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Pictures in memory of the filter's device as textures, without a copy through the host.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "stillray/shared_picture.h"

namespace stillray::view {

/// Needs the context that it was made in. Memory is imported when it is first seen, and let go when
/// its picture is no more.
class SharedImports {
 public:
  /// \return kUnsupported naming what OpenGL lacks
  static Result<std::unique_ptr<SharedImports>> Create();
  ~SharedImports();
  SharedImports(const SharedImports&) = delete;
  SharedImports& operator=(const SharedImports&) = delete;

  /// Makes sure that the picture can be copied from.
  /// \return kUnsupported if it lies on another device than OpenGL's; what fails there
  Status Import(const std::shared_ptr<const SharedPicture>& picture);
  /// Copies an imported picture into the bound texture, which has its size, on the device; holds it
  /// until that is done.
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
  std::deque<Copy> copies_;  ///< on their way, oldest first
};

}  // namespace stillray::view
