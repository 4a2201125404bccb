// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// GatherKnown of fill_guides: known and held pixels, downsampled to the first level of the pyramid.
#include "denoise/fill_guides/fill_guides_task.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/fill_guides/gather_known.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/fill_guides/pyramid_rows-inl.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

using Work = FillGuidesWork;
using Task = FillGuidesTask;

/// Lists the known pixels. \return their number
int64_t ListKnownRows(const Frame& frame, int y0, int y1, RowLists* list) {
  const DF d;
  const DI di;
  int64_t sum = 0;
  for (int y = y0; y < y1; ++y) {
    const float* depth = frame.guides.depth.Row(y);
    const float* samples = frame.samples.Row(y);
    int32_t* to = list->Begin(y);
    int count = 0;
    for (int x = 0; x < frame.width; x += LaneCount()) {
      // A NaN depth counts as known, so that it is reported as invalid.
      const MF has_depth = hn::Not(hn::Eq(hn::LoadU(d, depth + x), hn::Zero(d)));
      const MF has_sample = hn::Gt(hn::LoadU(d, samples + x), hn::Zero(d));
      const MF known = hn::And(hn::Or(has_depth, has_sample), InRow(x, frame.width));
      if (!hn::AllFalse(d, known)) {
        count += static_cast<int>(
            hn::CompressStore(ColumnNumbers(x), hn::RebindMask(di, known), di, to + count));
      }
    }
    list->SetCount(y, count);
    sum += count;
  }
  return sum;
}

/// Marks the columns of a row of the list in a row of zeros.
HWY_INLINE void MarkRow(std::span<const int32_t> columns, int width, float* mask) {
  std::fill_n(mask, width, 0.0f);
  for (const int32_t x : columns) {
    mask[x] = 1.0f;
  }
}

/// Downsamples the motion of known pixels to the first level.
void DownsampleMotionRows(const Frame& frame, int cell_y0, int cell_y1, Work* work) {
  const int width = frame.width;
  PyramidMask& mask = work->mask[Work::kNew];
  const int cells = mask.known.front().width();
  const RowScratch scratch(width, 1 + kPyramidFactor);
  for (int c = cell_y0; c < cell_y1; ++c) {
    ChildRows<float> marked;
    marked.count = std::min(kPyramidFactor, frame.height - c * kPyramidFactor);
    for (int i = 0; i < marked.count; ++i) {
      MarkRow(work->known_now.Row(c * kPyramidFactor + i), width, scratch.Row(1 + i));
      marked.row[i] = scratch.Row(1 + i);
    }
    float* inverse = mask.inverse.front().Row(c);
    DownsampleMaskRow(marked, width, cells, scratch.Row(0), mask.known.front().Row(c), inverse);
    for (size_t k = 0; k < 2; ++k) {
      DownsampleRow(ChildrenOf(frame.guides.motion.channel[k], c), marked, width, inverse, cells,
                    scratch.Row(0), work->motion[k].value.front().Row(c));
    }
  }
}

/// Masks of known surface and known sky, and the inverse depth of surfaces.
HWY_INLINE void ClassifyRow(const float* known_row, const float* depth, int width, float* surface,
                            float* sky, float* inverse_depth) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  for (int x = 0; x < width; x += LaneCount()) {
    const MF known = hn::Gt(hn::LoadU(d, known_row + x), zero);
    const VF z = hn::LoadU(d, depth + x);
    const MF is_surface = hn::And(known, hn::And(IsFiniteLane(z), hn::Gt(z, zero)));
    hn::StoreU(hn::IfThenElseZero(is_surface, one), d, surface + x);
    hn::StoreU(hn::IfThenElseZero(hn::AndNot(is_surface, known), one), d, sky + x);
    const VF safe = hn::IfThenElse(is_surface, z, one);
    hn::StoreU(hn::IfThenElseZero(is_surface, hn::Div(one, safe)), d, inverse_depth + x);
  }
}

/// Downsamples all planes to one row of cells of the first level.
void DownsampleCellRow(const Task& t, int c) {
  const int width = t.width();
  const int cells = t.cells();
  const RowScratch scratch(width, 1 + 3 * kPyramidFactor);
  float* sums = scratch.Row(0);
  ChildRows<float> of[Work::kKindCount];
  ChildRows<float> inverse_depth;
  of[Work::kAny] = ChildrenOf(t.held->known, c);
  of[Work::kSurface].count = of[Work::kSky].count = inverse_depth.count = of[Work::kAny].count;
  for (int i = 0; i < inverse_depth.count; ++i) {
    float* surface = scratch.Row(1 + i);
    float* sky = scratch.Row(1 + kPyramidFactor + i);
    float* inverse = scratch.Row(1 + 2 * kPyramidFactor + i);
    ClassifyRow(of[Work::kAny].row[i], t.held->guides.depth.Row(c * kPyramidFactor + i), width,
                surface, sky, inverse);
    of[Work::kSurface].row[i] = surface;
    of[Work::kSky].row[i] = sky;
    inverse_depth.row[i] = inverse;
  }
  for (const Work::Kind kind : t.kinds()) {
    PyramidMask& mask = t.work->mask[kind];
    DownsampleMaskRow(of[kind], width, cells, sums, mask.known.front().Row(c),
                      mask.inverse.front().Row(c));
  }
  const auto downsample = [&](const ChildRows<float>& values, Work::Kind kind,
                              Pyramid* levels) HWY_ATTR {
    DownsampleRow(values, of[kind], width, t.work->mask[kind].inverse.front().Row(c), cells, sums,
                  levels->value.front().Row(c));
  };
  downsample(of[Work::kSurface], Work::kAny, &t.work->surface);
  downsample(inverse_depth, Work::kSurface, &t.work->inverse_depth);
  for (int i = 0; i < t.planes.count; ++i) {
    const auto slot = static_cast<size_t>(i);
    downsample(ChildrenOf(*t.planes.plane[slot].held, c), t.KindOf(i), &t.work->plane[slot]);
  }
  if (!t.held->guides.id.empty()) {
    DownsampleIdRow(ChildrenOf(t.held->guides.id, c), of[Work::kSurface], width, cells,
                    t.work->id.value.front().Row(c));
  }
}

/// The known children of one cell, row by row.
struct CellChildren {
  int x[kPyramidFactor * kPyramidFactor];
  int y[kPyramidFactor * kPyramidFactor];
  bool surface[kPyramidFactor * kPyramidFactor];
  int count = 0;
  int surfaces = 0;
};

/// Mean over the children of a kind, with sums in the order of DownsampleRow.
template <typename Value>
HWY_INLINE float MeanOf(const CellChildren& children, Work::Kind kind, float inverse,
                        const Value& value) {
  float column[kPyramidFactor] = {};
  for (int i = 0; i < children.count; ++i) {
    if (kind == Work::kAny || children.surface[i] == (kind == Work::kSurface)) {
      column[children.x[i] % kPyramidFactor] += value(i);
    }
  }
  return (column[0] + column[1] + column[2]) * inverse;
}

/// DownsampleCellRow for one cell.
void DownsampleCell(const Task& t, int cx, int cy) {
  CellChildren children;
  const HeldGuides& held = *t.held;
  for (int y = cy * kPyramidFactor; y < std::min((cy + 1) * kPyramidFactor, t.height()); ++y) {
    for (int x = cx * kPyramidFactor; x < std::min((cx + 1) * kPyramidFactor, t.width()); ++x) {
      if (held.known(x, y) > 0) {
        const bool surface = IsSurface(held.guides.depth(x, y));
        children.x[children.count] = x;
        children.y[children.count] = y;
        children.surface[children.count++] = surface;
        children.surfaces += surface;
      }
    }
  }
  float inverse[Work::kKindCount] = {};
  const int count[] = {children.count, children.surfaces, children.count - children.surfaces};
  for (const Work::Kind kind : t.kinds()) {
    PyramidMask& mask = t.work->mask[kind];
    inverse[kind] = count[kind] > 0 ? 1.0f / static_cast<float>(count[kind]) : 0.0f;
    mask.inverse.front()(cx, cy) = inverse[kind];
    mask.known.front()(cx, cy) = count[kind] > 0 ? 1.0f : 0.0f;
  }
  t.work->surface.value.front()(cx, cy) =
      static_cast<float>(children.surfaces) * inverse[Work::kAny];
  t.work->inverse_depth.value.front()(cx, cy) =
      MeanOf(children, Work::kSurface, inverse[Work::kSurface],
             [&](int i) { return 1.0f / held.guides.depth(children.x[i], children.y[i]); });
  for (int k = 0; k < t.planes.count; ++k) {
    const auto slot = static_cast<size_t>(k);
    const Image1& plane = *t.planes.plane[slot].held;
    const Work::Kind kind = t.KindOf(k);
    t.work->plane[slot].value.front()(cx, cy) = MeanOf(
        children, kind, inverse[kind], [&](int i) { return plane(children.x[i], children.y[i]); });
  }
  if (!held.guides.id.empty()) {
    uint32_t first = 0;
    for (int i = children.count - 1; i >= 0; --i) {
      first = children.surface[i] ? held.guides.id(children.x[i], children.y[i]) : first;
    }
    t.work->id.value.front()(cx, cy) = first;
  }
}

/// Copies the known pixels of row y.
void CopyKnownRow(const Task& t, int y) {
  const std::span<const int32_t> columns = t.work->known_now.Row(y);
  const auto copy = [&](const auto& from, auto* to) {
    const auto* source = from.Row(y);
    auto* target = to->Row(y);
    for (const int32_t x : columns) {
      target[x] = source[x];
    }
  };
  float* known = t.held->known.Row(y);
  for (const int32_t x : columns) {
    known[x] = 1.0f;
  }
  copy(t.frame->guides.depth, &t.held->guides.depth);
  for (const HeldPlane& plane : t.planes) {
    copy(*plane.from, plane.held);
  }
  if (!t.held->guides.id.empty()) {
    copy(t.frame->guides.id, &t.held->guides.id);
  }
}

/// Motion of row y: that of the frame at known pixels, else filled.
void FillMotionRow(const Task& t, int y, const UpsampleAcross& across, const RowScratch& scratch) {
  const std::span<const int32_t> columns = t.work->known_now.Row(y);
  for (size_t k = 0; k < 2; ++k) {
    float* filled = scratch.Row(0);
    UpsampleRow(t.work->motion[k].value.front(), y, scratch.Row(1), across, filled);
    const float* from = t.frame->guides.motion.channel[k].Row(y);
    for (const int32_t x : columns) {
      filled[x] = from[x];
    }
    std::copy_n(filled, t.width(), t.held->guides.motion.channel[k].Row(y));
  }
}

/// Indices of a row's pixels in the held planes, and per SIMD vector whether they are contiguous.
struct HeldRow {
  int32_t* index;  ///< per pixel; 0 without held guides
  int32_t* start;  ///< per SIMD vector: index of its first lane if contiguous, else kScattered or
                   ///< kNothing
  static constexpr int32_t kScattered = -1;
  static constexpr int32_t kNothing = -2;
};

/// Finds the held pixels of row y along the motion, and marks those that are known.
void FindHeldRow(const Task& t, int y, HeldRow* row) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d);
  const int width = t.width();
  const VF right = hn::Set(d, static_cast<float>(width));
  const VF bottom = hn::Set(d, static_cast<float>(t.height()));
  const Image1& held = t.before->known;
  const auto stride = static_cast<int32_t>(held.stride());
  const float* mx = t.held->guides.motion[0].Row(y);
  const float* my = t.held->guides.motion[1].Row(y);
  float* known_row = t.held->known.Row(y);
  for (int x = 0; x < width; x += LaneCount()) {
    const VF px =
        hn::Floor(hn::Add(hn::Add(ColumnsFrom(x), hn::LoadU(d, mx + x)), hn::Set(d, t.shift.x)));
    const VF py = hn::Floor(hn::Add(
        hn::Add(hn::Set(d, static_cast<float>(y)), hn::LoadU(d, my + x)), hn::Set(d, t.shift.y)));
    const MF inside =
        hn::And(InRow(x, width), hn::And(hn::And(hn::Ge(px, zero), hn::Lt(px, right)),
                                         hn::And(hn::Ge(py, zero), hn::Lt(py, bottom))));
    const VI qx = hn::ConvertTo(di, hn::IfThenElseZero(inside, px));
    const VI qy = hn::ConvertTo(di, hn::IfThenElseZero(inside, py));
    const VI index = hn::Add(hn::Mul(qy, hn::Set(di, stride)), qx);
    const SideBySide block = FindSideBySide(qx, qy, inside, 1, width);
    const TapLoad load = TapAt(block, 0, 0, t.height(), qx, qy);
    const MF known = hn::And(inside, hn::Gt(load(d, held), zero));
    hn::StoreU(hn::IfThenElseZero(known, hn::Set(d, 1.0f)), d, known_row + x);
    hn::StoreU(index, di, row->index + x);
    row->start[x / LaneCount()] = hn::AllFalse(d, known) ? HeldRow::kNothing
                                  : block.found          ? load.row * stride + load.column
                                                         : HeldRow::kScattered;
  }
}

template <typename T>
HWY_INLINE void GatherHeldPlane(const HeldRow& row, const Plane<T>& from, int y, Plane<T>* to) {
  const hn::ScalableTag<T> d;
  const DI di;
  T* target = to->Row(y);
  const T* source = from.Row(0);
  NextRow<1> next;
  next.Add(*to, y + 1);
  for (int x = 0; x < to->width(); x += LaneCount()) {
    next.Fetch(x);
    const int32_t start = row.start[x / LaneCount()];
    if (start >= 0) {
      __builtin_prefetch(source + start + from.stride(), 0, 2);
      hn::StoreU(hn::LoadU(d, source + start), d, target + x);
    } else if (start == HeldRow::kScattered) {
      hn::StoreU(hn::GatherIndex(d, source, hn::LoadU(di, row.index + x)), d, target + x);
    }
  }
}

/// Row y of all planes: held pixels along the motion, then known pixels.
void GatherRow(const Task& t, int y, const UpsampleAcross& across) {
  {
    const RowScratch scratch(t.width(), 2);
    FillMotionRow(t, y, across, scratch);
    HeldRow row = {scratch.Row<int32_t>(0), scratch.Row<int32_t>(1)};
    FindHeldRow(t, y, &row);
    GatherHeldPlane(row, t.before->guides.depth, y, &t.held->guides.depth);
    for (int i = 0; i < t.planes.count; ++i) {
      const auto slot = static_cast<size_t>(i);
      GatherHeldPlane(row, *t.planes_before.plane[slot].held, y, t.planes.plane[slot].held);
    }
    if (!t.held->guides.id.empty()) {
      GatherHeldPlane(row, t.before->guides.id, y, &t.held->guides.id);
    }
  }
  CopyKnownRow(t, y);
}

/// Prefetches the known pixels of a row of cells, which are too far apart for the hardware
/// prefetcher.
void PrefetchCells(const Task& t, int c) {
  const auto fetch = [](const auto* address) { __builtin_prefetch(address, 1, 2); };
  const int first = c * kPyramidFactor;
  const int last = std::min(first + kPyramidFactor, t.height());
  for (int y = first; y < last; ++y) {
    for (const int32_t x : t.work->known_now.Row(y)) {
      fetch(t.frame->guides.depth.Row(y) + x);
      for (const HeldPlane& plane : t.planes) {
        fetch(plane.from->Row(y) + x);
      }
      for (int row = first; row < last; ++row) {
        fetch(t.held->known.Row(row) + x);
        fetch(t.held->guides.depth.Row(row) + x);
        for (const HeldPlane& plane : t.planes) {
          fetch(plane.held->Row(row) + x);
        }
      }
    }
  }
}

/// GatherKnown for some rows of cells.
void GatherCellRows(const Task& t, int cell_y0, int cell_y1) {
  const UpsampleAcross across;
  for (int c = cell_y0; c < cell_y1; ++c) {
    if (c + 1 < cell_y1 && t.before == nullptr) {
      PrefetchCells(t, c + 1);
    }
    const int first = c * kPyramidFactor;
    const int last = std::min(first + kPyramidFactor, t.height());
    size_t new_pixels = 0;
    for (int y = first; y < last; ++y) {
      new_pixels += t.work->known_now.Row(y).size();
      if (t.before != nullptr) {
        GatherRow(t, y, across);
      } else {
        CopyKnownRow(t, y);
      }
    }
    // A single cell costs about a tenth of a vectorised row of cells.
    if (!t.held->first_level_valid || new_pixels * 10 > static_cast<size_t>(t.cells())) {
      DownsampleCellRow(t, c);
      continue;
    }
    for (int y = first; y < last; ++y) {
      for (const int32_t x : t.work->known_now.Row(y)) {
        DownsampleCell(t, x / kPyramidFactor, c);
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(ListKnownRows);
HWY_EXPORT(DownsampleMotionRows);
HWY_EXPORT(GatherCellRows);

int64_t ListKnown(const Frame& frame, int y0, int y1, RowLists* list) {
  return HWY_DYNAMIC_DISPATCH(ListKnownRows)(frame, y0, y1, list);
}

void DownsampleMotion(const FillGuidesTask& t) {
  ParallelRows(t.cell_rows(), kCellBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(DownsampleMotionRows)(*t.frame, y0, y1, t.work);
  });
}

void GatherKnown(const FillGuidesTask& t) {
  ParallelRows(t.cell_rows(), kCellBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(GatherCellRows)(t, y0, y1);
  });
}

}  // namespace stillray::cpu
#endif
