// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Estimates the size of the output of `stillray render` in advance.
#pragma once

#include <cstdint>
#include <string>

#include "render/render_options.h"

namespace stillray {

/// Bytes of the files of a run by format, estimated from the number of pixels. Actual sizes are
/// within a factor of two, depending on the compression of noise and texture.
struct OutputSize {
  int64_t exr = 0;
  int64_t png = 0;
  int64_t jpg = 0;
  int64_t mp4 = 0;
  int64_t total() const { return exr + png + jpg + mp4; }
};

/// \param first_frame  earlier frames have already been written
OutputSize EstimateOutputSize(const RenderOptions& options, int64_t first_frame);

/// "writing 120 frames of 1280 x 720 pixels to out/, about 480 MB (EXR 370 MB, PNG 100 MB, video
/// 9.0 MB)"
std::string OutputSizeText(const RenderOptions& options, int64_t first_frame);

/// A warning if the folder's disk has less space than the estimate; empty if it has enough.
std::string DiskSpaceWarning(const std::string& folder, const OutputSize& size);

}  // namespace stillray
