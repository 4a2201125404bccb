// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Option --preview: display images of the denoised frames, as PNG files or one video.
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
  /// \param options  preview, fps and files, checked by CheckPreview()
  /// \param display  exposure, tonemap, dither
  Preview(const DenoiseOptions& options, const Settings& display);

  /// Creates the folder and starts the video. A video cannot be resumed: the first `finished`
  /// frames are encoded again, from the files of the earlier run.
  /// \return kUnsupported (ffmpeg is not installed), kIo, errors of reading a file
  Status Open(const ExrExtent& extent, const AovLayout& layout, size_t finished);

  /// Frames must be in order. Not thread-safe.
  Status Write(const SequenceFile& file, const Image3& colour);

  /// Completes a video, and renames it to its final name.
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
  int64_t other_size_ = 0;  ///< number of frames whose size differs from the video's
  int64_t bytes_ = 0;
  std::unique_ptr<VideoWriter> video_;
};

}  // namespace stillray
