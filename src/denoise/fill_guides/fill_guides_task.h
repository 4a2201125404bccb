// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The steps of the vector version and their arguments.
#pragma once

#include <span>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/fill_guides/held_guides.h"

namespace stillray {

/// One frame in progress.
struct FillGuidesTask {
  using Work = FillGuidesWork;

  const Frame* frame;
  HeldGuides* held;
  HeldGuides* before;  ///< guides of the last frame; nullptr in a static view
  Work* work;
  HeldPlanes planes;
  HeldPlanes planes_before;
  Shift shift;

  int width() const { return frame->width; }
  int height() const { return frame->height; }
  int cell_rows() const { return work->surface.value.front().height(); }
  int cells() const { return work->surface.value.front().width(); }
  /// The kinds of known pixels that fill holes, without the sky while it is black.
  std::span<const Work::Kind> kinds() const {
    static constexpr Work::Kind kAll[] = {Work::kAny, Work::kSurface, Work::kSky};
    return {kAll, held->background.empty() ? size_t{2} : size_t{3}};
  }
  Work::Kind KindOf(int plane) const {
    return planes.plane[static_cast<size_t>(plane)].rule == FillRule::kSkyOnly ? Work::kSky
                                                                               : Work::kSurface;
  }
};

namespace cpu {

/// Rows per task of a thread: of the image, and of cells.
inline constexpr int kRowBand = 16;
inline constexpr int kCellBand = 4;

/// Lists the known pixels of the rows y0 to y1 - 1. \return their number
int64_t ListKnown(const Frame& frame, int y0, int y1, RowLists* list);
/// Downsamples the motion of known pixels to the first level.
void DownsampleMotion(const FillGuidesTask& task);
/// Copies known pixels, gathers held guides for the others, and downsamples both to the first
/// level.
void GatherKnown(const FillGuidesTask& task);
/// Fills all holes of the image from the first level.
void FillHoles(const FillGuidesTask& task);

}  // namespace cpu
}  // namespace stillray
