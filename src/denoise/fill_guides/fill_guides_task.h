// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What the passes of sparse_guides.cpp hand to each other.
#pragma once

#include <span>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/fill_guides/held_guides.h"

namespace stillray {

/// One frame on its way through the passes.
struct SparseGuidesTask {
  using Work = SparseGuidesWork;

  const Frame* frame;
  HeldGuides* held;
  HeldGuides* before;  ///< nullptr in a still view
  Work* work;
  HeldPlanes planes;
  HeldPlanes planes_before;
  Shift shift;

  int width() const { return frame->width; }
  int height() const { return frame->height; }
  int cell_rows() const { return work->surface.value.front().height(); }
  int cells() const { return work->surface.value.front().width(); }
  /// Kinds of pixels of which something is filled: all but the sky if it is black.
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

/// Rows that a thread takes at a time, of the picture and of cells.
inline constexpr int kRowBand = 16;
inline constexpr int kCellBand = 4;

/// Lists the pixels of the rows y0 to y1 - 1 that the frame knows. \return their number
int64_t ListKnown(const Frame& frame, int y0, int y1, RowLists* list);
/// The first level of this frame's motion, from the pixels that it knows.
void RaiseMotion(const SparseGuidesTask& task);
/// Takes all that is known, moved where the view moves, and raises it to the first level.
void TakeKnown(const SparseGuidesTask& task);
/// Guesses all holes of the picture from the first level.
void FillHoles(const SparseGuidesTask& task);

}  // namespace cpu
}  // namespace stillray
