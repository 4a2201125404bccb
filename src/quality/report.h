// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A self-contained HTML page about a rendered sequence: its pictures side by side, error maps,
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

/// Converts linear radiance to a display picture.
/// \param tonemap   the curve named in render.json; "" if there is none
/// \param exposure  stops
using DevelopPicture = std::function<Result<Rgb8Image>(
    const Image3& radiance, const std::string& tonemap, double exposure)>;

struct ReportOptions {
  int max_frames = 12;  ///< frames whose pictures are embedded, 1..1000, spread evenly
  /// Frames are dropped to keep the page below this size; >= 1, at least one frame stays.
  int64_t max_page_bytes = 40'000'000;
  /// Initial width of the visible part, in picture pixels; 0: the whole picture.
  int zoom_width = 0;
  /// For views with EXR files but no PNG files. Empty: exposure, clip to 0..1, sRGB.
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
/// reference pictures, NAME.####.png or NAME.####.exr, and render.json. All but one picture are
/// optional. The page depends only on the folder's files and its last path component.
/// \return kNotFound (no such folder, no frames), kBadData (damaged picture or render.json, sizes
///     that differ, both naming the file), kInvalidArgument (options), kCancelled
Result<std::string> BuildReport(const std::string& folder, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// Pictures of any renderer and any denoiser: each a name of FindFrameFiles(), EXR or PNG files.
struct ReportSequences {
  std::string noisy;
  std::string clean;
  std::string reference;  ///< "": none
  // Development of EXR files.
  double exposure = 0;  ///< stops
  std::string tonemap;  ///< a curve of `develop`; "" for its default
  double fps = 24;      ///< of playback
};

/// The same page for the frames of `clean`. \return also errors of FindFrameFiles
Result<std::string> BuildReport(const ReportSequences& sequences, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// Writes the page to a file, which is replaced only once the page is complete.
Status WriteReport(const std::string& folder, const std::string& path, const ReportOptions& options,
                   ReportSummary* summary = nullptr);
Status WriteReport(const ReportSequences& sequences, const std::string& path,
                   const ReportOptions& options, ReportSummary* summary = nullptr);

}  // namespace stillray
