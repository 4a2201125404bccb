// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The images, error maps and metrics of a report.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "quality/render_log.h"
#include "quality/report.h"
#include "quality/report_files.h"
#include "stillray/quality.h"
#include "stillray/status.h"

namespace stillray::report {

/// The kind of values that are compared. Numbers of different sources are not comparable.
enum Source : int {
  kLinear,   ///< scene-linear radiance: EXR files of the view and of the reference
  kDisplay,  ///< display values: PNG files of both
};
inline constexpr int kSourceCount = 2;

enum MapKind : int { kFlipMap, kRelativeSquaredErrorMap };
inline constexpr int kMapCount = 2;

/// One view of one frame of the page. Strings are empty if the view is missing.
struct ShownView {
  std::string png;             ///< content of the PNG file, or encoded from the EXR file
  bool made_from_exr = false;  ///< true if there was no PNG file
  std::array<std::string, kMapCount> maps;  ///< bytes of palette PNG files
  Source map_source = kLinear;
};

struct ShownFrame {
  int64_t number = 0;
  std::array<ShownView, kViewCount> views;
};

using ViewMetrics = std::array<std::optional<ImageMetrics>, kTestViewCount>;
using ViewNumbers = std::array<std::optional<double>, kTestViewCount>;

struct MeasuredFrame {
  int64_t number = 0;
  std::array<ViewMetrics, kSourceCount> metrics;
  /// TemporalError(); none if the previous frame was not measured or no history is visible.
  std::array<ViewNumbers, kSourceCount> temporal_error;
  /// MeasureLightChange(); none as for TemporalError(), and if the reference is constant.
  std::array<std::array<std::optional<LightChange>, kTestViewCount>, kSourceCount> light_change;
};

struct Measurements {
  int width = 0;
  int height = 0;
  std::vector<ShownFrame> shown;
  bool thinned_for_size = false;        ///< fewer than max_frames, for max_page_bytes
  std::vector<MeasuredFrame> measured;  ///< frames with a reference, in order
  bool without_motion = false;          ///< temporal errors were measured without motion
};

/// Reads the images of the page, and the images that can be compared with a reference. Linear
/// radiance is measured wherever available; display values only if some view has nothing else, and
/// then for all views with display values, so that all views can be compared on one scale.
/// \return kBadData (damaged image; sizes that differ from the first image's or from render.json's,
///     naming both), kCancelled, and errors of reading an image
Result<Measurements> Measure(const SequenceFiles& files, const RenderLog& log,
                             const ReportOptions& options);

}  // namespace stillray::report
