// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The cameras of a sequence from a JSON file (docs/files.md).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "stillray/aov.h"
#include "stillray/status.h"

namespace stillray::motion {

struct CameraFile {
  std::string name;       ///< of the file, for messages
  uint64_t checksum = 0;  ///< of its text
  int width = 0;          ///< of the images, pixels
  int height = 0;
  /// By frame, in the middle of the shutter. Empty for cameras without a projection matrix, such as
  /// panoramic cameras.
  std::map<int64_t, std::optional<CameraMatrices>> frames;

  /// \return kNotFound if the file lacks the frame
  Result<std::optional<CameraMatrices>> Camera(int64_t frame) const;
};

/// \param name  of the file, for messages
/// \return kBadData naming the member, its value and what is expected
Result<CameraFile> ParseCameraFile(const std::string& text, const std::string& name);
/// \return also errors of reading the file
Result<CameraFile> ReadCameraFile(const std::string& path);

}  // namespace stillray::motion
