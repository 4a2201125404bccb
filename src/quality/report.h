// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A self-contained HTML page about a rendered sequence: its images side by side, error maps,
/// quality over frames, times and settings. docs/report.md describes the page and its inputs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "stillray/image.h"
#include "stillray/io.h"
#include "stillray/status.h"

namespace stillray {

/// Converts linear radiance to a display image.
/// \param tonemap   the curve named in render.json; "" if there is none
/// \param exposure  stops
using DevelopPicture = std::function<Result<Rgb8Image>(
    const Image3& radiance, const std::string& tonemap, double exposure)>;

struct ReportOptions {
  int max_frames = 12;  ///< number of frames with embedded images, 1..1000, spread evenly
  /// Maximum size of the page in bytes, >= 1; frames are dropped to keep it, at least one frame is
  /// kept.
  int64_t max_page_bytes = 40'000'000;
  /// Initial width of the visible part, in image pixels; 0: the whole image.
  int zoom_width = 0;
  /// Display conversion of views with EXR files but no PNG files. Empty: exposure, clip to 0..1,
  /// sRGB.
  DevelopPicture develop;
  /// Called after each frame that is read; return false to cancel.
  std::function<bool(int done, int total)> progress;
};

struct ReportSummary {
  int frames_found = 0;
  int frames_shown = 0;
  size_t page_bytes = 0;
  std::vector<std::string> notes;  ///< missing or omitted parts, as on the page
};

/// Builds the page from a folder written by `stillray render`: noisy, temporal, denoised and
/// reference images, NAME.####.png or NAME.####.exr, and render.json. All but one image are
/// optional. The page depends only on the folder's files and its last path component.
/// \return kNotFound (no such folder, no frames), kBadData (damaged image or render.json, sizes
///     that differ, both naming the file), kInvalidArgument (options), kCancelled
Result<std::string> BuildReport(const std::string& folder, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// Sequences of any renderer and any denoiser: each a name for FindFrameFiles(), EXR or PNG files.
struct ReportSequences {
  std::string noisy;
  std::string clean;
  std::string reference;  ///< "": none
  // Development of EXR files.
  double exposure = 0;  ///< stops
  std::string tonemap;  ///< a curve of `develop`; "" for its default
  double fps = 24;      ///< of playback
};

/// Builds the page for the frames of `clean`. \return as above, and errors of FindFrameFiles
Result<std::string> BuildReport(const ReportSequences& sequences, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// Writes the page to a file, atomically.
Status WriteReport(const std::string& folder, const std::string& path, const ReportOptions& options,
                   ReportSummary* summary = nullptr);
Status WriteReport(const ReportSequences& sequences, const std::string& path,
                   const ReportOptions& options, ReportSummary* summary = nullptr);

}  // namespace stillray
