// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What imports of all formats share: the checks of the finished scene, and limits.
#pragma once

#include <cstdint>
#include <span>

#include "scene/image_decode.h"
#include "scene/import_log.h"
#include "stillray/scene.h"

namespace stillray {

/// Adds a camera and light where a file has none, with a warning. Fails if the scene has no
/// triangles or is too large to trace. All transforms of nodes must be traceable.
/// \param has_environment  the file defines an environment, which may be black
void CompleteScene(bool has_environment, ImportLog* log, Scene* scene);

/// Adds a file to the checksum of a scene, its length included: trailing zeros do not change the
/// checksum of the bytes.
uint64_t AddFileToChecksum(std::span<const uint8_t> bytes, uint64_t sum);

/// The memory that a scene's textures may take: bounded, and in proportion to the bytes of their
/// files, so that small files cannot exhaust it.
class TextureBudget {
 public:
  /// Takes the memory of one texture of `encoded_bytes`.
  /// \return kUnsupported, with the numbers, when it is exceeded
  Status Take(const ImageInfo& info, size_t encoded_bytes);

 private:
  uint64_t total_ = 0;
  uint64_t most_ = uint64_t{512} << 20;  ///< any compression is accepted below it
};

}  // namespace stillray
