// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// One self-contained HTML page about a rendered sequence: its pictures side by side, error maps,
/// quality over frames, times and settings. docs/report.md describes the page and what it is made
/// from.
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

/// Makes a display picture of linear radiance.
/// \param tonemap   the curve that render.json names; "" if it names none
/// \param exposure  stops
using DevelopPicture = std::function<Result<Rgb8Image>(
    const Image3& radiance, const std::string& tonemap, double exposure)>;

struct ReportOptions {
  int max_frames = 12;  ///< frames whose pictures are embedded, 1..1000, spread evenly
  /// Fewer frames are embedded where the page would grow past this; >= 1, at least one frame stays.
  int64_t max_page_bytes = 40'000'000;
  /// Picture pixels that the viewer's width shows when the page opens; 0: the whole picture.
  int zoom_width = 0;
  /// For views that have EXR files but no PNG files. None: exposure, clip to 0..1, sRGB.
  DevelopPicture develop;
  /// Called after each frame that is read; return false to cancel.
  std::function<bool(int done, int total)> progress;
};

struct ReportSummary {
  int frames_found = 0;
  int frames_shown = 0;
  size_t page_bytes = 0;
  std::vector<std::string> notes;  ///< what is missing or was left out, as the page says it
};

/// Builds the page from a folder that `stillray render` filled: noisy, temporal, denoised and
/// reference pictures, NAME.####.png or NAME.####.exr, and render.json. Everything but one picture
/// is optional. The page depends on the folder's files and its last path component alone.
/// \return kNotFound (no such folder, no frames), kBadData (damaged picture or render.json, sizes
///         that differ, both naming the file), kInvalidArgument (options), kCancelled
Result<std::string> BuildReport(const std::string& folder, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// Pictures of any renderer and any denoiser: each a name of FindFrameFiles(), EXR or PNG files.
struct ReportSequences {
  std::string noisy;
  std::string clean;
  std::string reference;  ///< "": none
  // How pictures are made of EXR files.
  double exposure = 0;  ///< stops
  std::string tonemap;  ///< a curve that `develop` knows; "" as it likes
  double fps = 24;      ///< of playing
};

/// The same page of the frames that `clean` has. \return what FindFrameFiles returns besides
Result<std::string> BuildReport(const ReportSequences& sequences, const ReportOptions& options,
                                ReportSummary* summary = nullptr);

/// BuildReport into a file, which is replaced only once the page is complete.
Status WriteReport(const std::string& folder, const std::string& path, const ReportOptions& options,
                   ReportSummary* summary = nullptr);
Status WriteReport(const ReportSequences& sequences, const std::string& path,
                   const ReportOptions& options, ReportSummary* summary = nullptr);

}  // namespace stillray
