// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A picture that is measured, with the layers that tell where its pixels were one frame before.
#pragma once

#include <string>
#include <string_view>

#include "stillray/image.h"
#include "stillray/status.h"

namespace stillray {

/// Endings of the files that can be measured.
inline constexpr std::string_view kPictureEndings[] = {".exr", ".png", ".hdr", ".jpg", ".jpeg"};

struct PictureFile {
  Image3 colour;
  bool linear = false;  ///< radiance, else display values
  Image2 motion;        ///< layers motion.X and motion.Y of an EXR file; empty if there are none
  Image1 depth;         ///< layer depth.Z likewise
};

/// The colour of an EXR file is that of ExrColour(), or the sum of its light passes.
/// \return what ReadWholeFile, DecodeExr, ExrColour and DecodeImage return
Result<PictureFile> ReadPictureFile(const std::string& path);

}  // namespace stillray
