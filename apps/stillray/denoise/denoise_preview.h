// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// --preview: display pictures of the denoised frames, as PNG files or one video.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "denoise/denoise_options.h"
#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray {

/// Checks that --preview names a supported output for these files.
/// \return kInvalidArgument naming the value and the expected ones
Status CheckPreview(const DenoiseOptions& options);

class Preview {
 public:
  /// \param options  preview, fps and files, past CheckPreview()
  /// \param display  exposure, tonemap, dither
  Preview(const DenoiseOptions& options, const Settings& display);

  /// Creates the folder and starts the video. A video cannot be continued: the first `finished`
  /// frames are encoded again, from the files of an earlier run.
  /// \return kUnsupported (ffmpeg is not installed), kIo, errors of reading a file
  Status Open(const ExrExtent& extent, const AovLayout& layout, size_t finished);

  /// Frames must be in order. Not thread-safe.
  Status Write(const SequenceFile& file, const Image3& colour);

  /// Completes a video, which appears under its name only now.
  Status Finish();

  /// "preview: look.mp4 (1.2 MB)", and the missing frames.
  std::string Summary() const;

 private:
  std::string PictureName(const SequenceFile& file) const;

  const DenoiseOptions& options_;
  Settings display_;
  std::string target_;  ///< the video, a pattern, or a folder
  bool wants_video_ = false;
  bool folder_ = false;
  int width_ = 0;
  int height_ = 0;
  int64_t other_size_ = 0;  ///< frames of another size than the video
  int64_t bytes_ = 0;
  std::unique_ptr<VideoWriter> video_;
};

}  // namespace stillray
