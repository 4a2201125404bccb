// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// An image to measure, with the layers for reprojection to the previous frame.
#pragma once

#include <string>
#include <string_view>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

/// File extensions that can be measured.
inline constexpr std::string_view kPictureEndings[] = {".exr", ".png", ".hdr", ".jpg", ".jpeg"};

struct PictureFile {
  Image3 colour;
  bool linear = false;  ///< true: linear radiance; false: display values
  Image2 motion;        ///< layers motion.X and motion.Y of an EXR file; empty if there are none
  Image1 depth;         ///< layer depth.Z of an EXR file; empty if there is none
  Image1 objects;       ///< the layer requested
};

/// The colour of an EXR file is ExrColour(), or the sum of its light passes.
/// \param objects  an additional layer of EXR files, or kAnyObjects; empty: none. The plane stays
///     empty if the file has no such layer
/// \return errors of ReadWholeFile, DecodeExr, ExrColour and DecodeImage
Result<PictureFile> ReadPictureFile(const std::string& path, const std::string& objects = {});

/// The numbers of objects that stillray (`id.X`) or Blender (`NAME.IndexOB.X`) writes.
inline constexpr const char* kAnyObjects = "auto";

}  // namespace stillray
