// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Common parts of all importers: checks of the complete scene, and limits.
#pragma once

#include <cstdint>
#include <span>

#include "scene/image_decode.h"
#include "scene/import_log.h"
#include "stillray/scene.h"

namespace stillray {

/// Adds a missing camera and missing lights, with a warning. Fails if the scene has no triangles or
/// is too large to trace. All node transforms must satisfy IsTraceable.
/// \param has_environment  the file defines an environment, which may be black
void CompleteScene(bool has_environment, ImportLog* log, Scene* scene);

/// Adds a file to the checksum of a scene, including its length, since trailing zeros do not change
/// the checksum of the bytes.
uint64_t AddFileToChecksum(std::span<const uint8_t> bytes, uint64_t sum);

/// The memory limit of a scene's textures: bounded, and proportional to the encoded size, so that
/// small files cannot exhaust memory.
class TextureBudget {
 public:
  /// Charges the memory of one texture whose file has `encoded_bytes`.
  /// \return kUnsupported, with both sizes, if the budget is exceeded
  Status Take(const ImageInfo& info, size_t encoded_bytes);

 private:
  uint64_t total_ = 0;
  uint64_t most_ = uint64_t{512} << 20;  ///< below it, any compression ratio is accepted
};

}  // namespace stillray
