// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The work is bound by memory: some twenty planes, of which a frame knows one pixel in a hundred.
// So every plane is gone through twice, by rows of cells of the pyramid: once to take what is known
// and to raise it to the first level (in a still view only the cells that have learnt something),
// once to fill the holes from there. What lies between is an eighth of the work.
#include "denoise/sparse_guides.h"

#include <atomic>
#include <utility>

#include <tbb/parallel_for.h>

#include "core/parallel.h"
#include "denoise/held_guides.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/fill_guides_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/sparse_guides.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/pyramid_rows-inl.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

#ifndef STILLRAY_DENOISE_SPARSE_GUIDES_ONCE
#define STILLRAY_DENOISE_SPARSE_GUIDES_ONCE
namespace stillray {
namespace {

using Work = SparseGuidesWork;

/// One frame on its way through the passes.
struct Task {
  const Frame* frame;
  HeldGuides* held;
  HeldGuides* before;  ///< nullptr in a still view
  Work* work;
  HeldPlanes planes;
  HeldPlanes planes_before;
  Shift shift;

  int width() const { return frame->width; }
  int height() const { return frame->height; }
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

struct FoundPixels {
  int64_t count = 0;
  bool moves = false;
  LightSeen seen;
};

}  // namespace
}  // namespace stillray
#endif

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Lists the pixels that the frame knows. \return their number
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
      // NaN is known, to be broken.
      const MF has_depth = hn::Not(hn::Eq(hn::LoadU(d, depth + x), hn::Zero(d)));
      const MF has_sample = hn::Gt(hn::LoadU(d, samples + x), hn::Zero(d));
      const MF known = hn::And(hn::Or(has_depth, has_sample), InRow(x, frame.width));
      if (!hn::AllFalse(d, known)) {
        count += static_cast<int>(
            hn::CompressStore(hn::Iota(di, x), hn::RebindMask(di, known), di, to + count));
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

/// The first level of this frame's motion, from the pixels that it knows.
void RaiseMotionRows(const Frame& frame, int cell_y0, int cell_y1, Work* work) {
  const int width = frame.width;
  FillMask& mask = work->mask[Work::kNew];
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
    RaiseMaskRow(marked, width, cells, scratch.Row(0), mask.known.front().Row(c), inverse);
    for (size_t k = 0; k < 2; ++k) {
      RaiseRow(ChildrenOf(frame.guides.motion.channel[k], c), marked, width, inverse, cells,
               scratch.Row(0), work->motion[k].value.front().Row(c));
    }
  }
}

/// Whether known pixels are of a surface or of the sky, and the inverse depth of surfaces.
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

/// All planes of one row of cells of the first level.
void RaiseAllCells(const Task& t, int c) {
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
    FillMask& mask = t.work->mask[kind];
    RaiseMaskRow(of[kind], width, cells, sums, mask.known.front().Row(c),
                 mask.inverse.front().Row(c));
  }
  const auto raise = [&](const ChildRows<float>& values, Work::Kind kind,
                         FillLevels* levels) HWY_ATTR {
    RaiseRow(values, of[kind], width, t.work->mask[kind].inverse.front().Row(c), cells, sums,
             levels->value.front().Row(c));
  };
  raise(of[Work::kSurface], Work::kAny, &t.work->surface);
  raise(inverse_depth, Work::kSurface, &t.work->inverse_depth);
  for (int i = 0; i < t.planes.count; ++i) {
    const auto slot = static_cast<size_t>(i);
    raise(ChildrenOf(*t.planes.plane[slot].held, c), t.KindOf(i), &t.work->plane[slot]);
  }
  if (!t.held->guides.id.empty()) {
    RaiseIdRow(ChildrenOf(t.held->guides.id, c), of[Work::kSurface], width, cells,
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

/// Mean over the children of a kind, with sums in the order of RaiseRow.
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

/// What RaiseAllCells does, for one cell.
void RaiseCell(const Task& t, int cx, int cy) {
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
    FillMask& mask = t.work->mask[kind];
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

/// Takes what the frame knows of row y.
void TakeKnownRow(const Task& t, int y) {
  const std::span<const int32_t> columns = t.work->known_now.Row(y);
  const auto take = [&](const auto& from, auto* to) {
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
  take(t.frame->guides.depth, &t.held->guides.depth);
  for (const HeldPlane& plane : t.planes) {
    take(*plane.from, plane.held);
  }
  if (!t.held->guides.id.empty()) {
    take(t.frame->guides.id, &t.held->guides.id);
  }
}

/// Motion of row y: this frame's where it is known, else filled.
void MoveRow(const Task& t, int y, const SpreadAcross& across, const RowScratch& scratch) {
  const std::span<const int32_t> columns = t.work->known_now.Row(y);
  for (size_t k = 0; k < 2; ++k) {
    float* filled = scratch.Row(0);
    SpreadRow(t.work->motion[k].value.front(), y, scratch.Row(1), across, filled);
    const float* from = t.frame->guides.motion.channel[k].Row(y);
    for (const int32_t x : columns) {
      filled[x] = from[x];
    }
    std::copy_n(filled, t.width(), t.held->guides.motion.channel[k].Row(y));
  }
}

/// Where a row's pixels are held: vector by vector, indices and whether they lie side by side.
struct HeldRow {
  int32_t* index;  ///< of every pixel, 0 where nothing is held
  int32_t* start;  ///< per vector: that of its first lane, or one of these
  static constexpr int32_t kScattered = -1;
  static constexpr int32_t kNothing = -2;
};

/// Looks up what is held for the pixels of row y, and marks those that are known.
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
HWY_INLINE void TakeHeldPlane(const HeldRow& row, const Plane<T>& from, int y, Plane<T>* to) {
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

/// Moves what is held into row y, and takes what the frame knows of it.
void TakeMovedRow(const Task& t, int y, const SpreadAcross& across) {
  {
    const RowScratch scratch(t.width(), 2);
    MoveRow(t, y, across, scratch);
    HeldRow row = {scratch.Row<int32_t>(0), scratch.Row<int32_t>(1)};
    FindHeldRow(t, y, &row);
    TakeHeldPlane(row, t.before->guides.depth, y, &t.held->guides.depth);
    for (int i = 0; i < t.planes.count; ++i) {
      const auto slot = static_cast<size_t>(i);
      TakeHeldPlane(row, *t.planes_before.plane[slot].held, y, t.planes.plane[slot].held);
    }
    if (!t.held->guides.id.empty()) {
      TakeHeldPlane(row, t.before->guides.id, y, &t.held->guides.id);
    }
  }
  TakeKnownRow(t, y);
}

/// Fetches into the cache what the known pixels of a row of cells will ask for: they lie too far
/// apart for a core to guess.
void FetchCells(const Task& t, int c) {
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

/// Takes all that is known and raises it to the first level.
void TakeCellRows(const Task& t, int cell_y0, int cell_y1) {
  const SpreadAcross across;
  for (int c = cell_y0; c < cell_y1; ++c) {
    if (c + 1 < cell_y1 && t.before == nullptr) {
      FetchCells(t, c + 1);
    }
    const int first = c * kPyramidFactor;
    const int last = std::min(first + kPyramidFactor, t.height());
    size_t learnt = 0;
    for (int y = first; y < last; ++y) {
      learnt += t.work->known_now.Row(y).size();
      if (t.before != nullptr) {
        TakeMovedRow(t, y, across);
      } else {
        TakeKnownRow(t, y);
      }
    }
    // One cell alone costs about as much as a tenth of a vector's way through its row.
    if (!t.held->raised || learnt * 10 > static_cast<size_t>(t.cells())) {
      RaiseAllCells(t, c);
      continue;
    }
    for (int y = first; y < last; ++y) {
      for (const int32_t x : t.work->known_now.Row(y)) {
        RaiseCell(t, x / kPyramidFactor, c);
      }
    }
  }
}

/// One plane of a row with holes.
struct HoleRow {
  const float* mixed;  ///< see MixParents
  float* to;
  FillRule rule;
};

/// Whether pixels x, x + 1, ... of a row are known.
HWY_INLINE MF KnownAt(const float* known, int x) {
  const DF d;
  return hn::Gt(hn::LoadU(d, known + x), hn::Zero(d));
}

/// Whether a row has no holes.
HWY_INLINE bool IsKnownRow(const float* known, int width) {
  const DF d;
  bool all = true;
  for (int x = 0; x < width && all; x += LaneCount()) {
    all = hn::AllTrue(d, hn::Or(KnownAt(known, x), hn::Not(InRow(x, width))));
  }
  return all;
}

/// Guesses the holes of row y.
void FillRow(const Task& t, const SpreadAcross& across, int y) {
  const DF d;
  const DU du;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const float* known_row = t.held->known.Row(y);
  if (IsKnownRow(known_row, t.width())) {
    return;
  }
  const RowScratch scratch(t.cells(), 2 + t.planes.count);
  NextRow<SparseGuidesWork::kMostPlanes + 3> next;
  next.Add(t.held->known, y + 1);
  next.Add(t.held->guides.depth, y + 1);
  next.Add(t.held->guides.id, y + 1);
  HoleRow rows[SparseGuidesWork::kMostPlanes];
  for (int i = 0; i < t.planes.count; ++i) {
    const auto slot = static_cast<size_t>(i);
    const HeldPlane& plane = t.planes.plane[slot];
    rows[slot] = {scratch.Row(2 + i), plane.held->Row(y), plane.rule};
    MixParents(t.work->plane[slot].value.front(), y, scratch.Row(2 + i));
    next.Add(*plane.held, y + 1);
  }
  float* surface_part = scratch.Row(0);
  float* inverse_depth = scratch.Row(1);
  MixParents(t.work->surface.value.front(), y, surface_part);
  MixParents(t.work->inverse_depth.value.front(), y, inverse_depth);
  float* depth = t.held->guides.depth.Row(y);
  const bool has_id = !t.held->guides.id.empty();
  uint32_t* id = has_id ? t.held->guides.id.Row(y) : nullptr;
  const uint32_t* id_cells = has_id ? t.work->id.value.front().Row(y / kPyramidFactor) : nullptr;
  for (int x = 0; x < t.width(); x += LaneCount()) {
    next.Fetch(x);
    const MF hole = hn::Not(KnownAt(known_row, x));
    const VF inverse = across(inverse_depth, x);
    const MF is_surface =
        hn::And(hn::Ge(across(surface_part, x), hn::Set(d, 0.5f)), hn::Gt(inverse, zero));
    const VF z = hn::IfThenElse(is_surface, hn::Div(one, hn::IfThenElse(is_surface, inverse, one)),
                                hn::Set(d, std::numeric_limits<float>::infinity()));
    hn::BlendedStore(z, hole, d, depth + x);
    for (int i = 0; i < t.planes.count; ++i) {
      const HoleRow& row = rows[i];
      VF guess = across(row.mixed, x);
      if (row.rule == FillRule::kSurfaceOnly) {
        guess = hn::IfThenElseZero(is_surface, guess);
      } else if (row.rule == FillRule::kSkyOnly) {
        guess = hn::IfThenZeroElse(is_surface, guess);
      }
      hn::BlendedStore(guess, hole, d, row.to + x);
    }
    if (has_id) {
      const VU guess = hn::IfThenElseZero(hn::RebindMask(du, is_surface), across.Own(id_cells, x));
      hn::BlendedStore(guess, hn::RebindMask(du, hole), du, id + x);
    }
  }
}

void FillRows(const Task& t, int y0, int y1) {
  const SpreadAcross across;
  for (int y = y0; y < y1; ++y) {
    FillRow(t, across, y);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(ListKnownRows);
HWY_EXPORT(RaiseMotionRows);
HWY_EXPORT(TakeCellRows);
HWY_EXPORT(FillRows);

namespace {

constexpr int kBand = 16;
constexpr int kCellBand = 4;

bool Shines(const Image3& light, int x, int y) {
  return !light.empty() && (light[0](x, y) != 0 || light[1](x, y) != 0 || light[2](x, y) != 0);
}

/// What the frame knows: lists its pixels, and says what of it is new to `held`.
FoundPixels FindKnown(const Frame& frame, const HeldGuides& held, RowLists* list) {
  std::atomic<int64_t> count = 0;
  std::atomic<bool> moves = false;
  std::atomic<bool> emission = !held.emission.empty();
  std::atomic<bool> background = !held.background.empty();
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    count += HWY_DYNAMIC_DISPATCH(ListKnownRows)(frame, y0, y1, list);
    for (int y = y0; y < y1; ++y) {
      for (const int32_t x : list->Row(y)) {
        if (!moves &&
            (IsMoving(frame.guides.motion[0](x, y)) || IsMoving(frame.guides.motion[1](x, y)))) {
          moves = true;
        }
        if (!emission && Shines(frame.emission, x, y)) {
          emission = true;
        }
        if (!background && Shines(frame.background, x, y)) {
          background = true;
        }
      }
    }
  });
  return {count, moves, {emission, background}};
}

/// Lists held pixels that what is known now speaks against.
void FindGhosts(const Task& t) {
  t.work->ghosts.Resize(t.width(), t.height());
  const Guides& now = t.frame->guides;
  ParallelRows(t.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      int32_t* to = t.work->ghosts.Begin(y);
      int count = 0;
      for (const int32_t x : t.work->known_now.Row(y)) {
        int qx = 0;
        int qy = 0;
        if (t.shift.Find(now.motion, x, y, &qx, &qy) && t.before->known(qx, qy) > 0 &&
            Differ(now, x, y, t.before->guides, qx, qy)) {
          to[count++] = qy * t.width() + qx;
        }
      }
      t.work->ghosts.SetCount(y, count);
    }
  });
}

/// Forgets the same surface around the ghosts. Each band looks at all ghosts, for the rows that
/// are its own.
void ForgetGhosts(const Task& t, int radius) {
  const Guides& g = t.before->guides;
  ParallelRows(t.height(), kBand, [&](int y0, int y1) {
    for (int row = 0; row < t.height(); ++row) {
      for (const int32_t q : t.work->ghosts.Row(row)) {
        const int qx = q % t.width();
        const int qy = q / t.width();
        for (int y = std::max(qy - radius, y0); y < std::min(qy + radius + 1, y1); ++y) {
          float* known = t.before->known.Row(y);
          for (int x = std::max(qx - radius, 0); x <= std::min(qx + radius, t.width() - 1); ++x) {
            if (known[x] > 0 && !Differ(g, x, y, g, qx, qy)) {
              known[x] = 0;
            }
          }
        }
      }
    }
  });
}

int CellRows(const Task& t) {
  return t.work->surface.value.front().height();
}

void RaiseMotion(const Task& t) {
  ParallelRows(CellRows(t), kCellBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(RaiseMotionRows)(*t.frame, y0, y1, t.work);
  });
  const FillMask& mask = t.work->mask[Work::kNew];
  RaiseMask(&t.work->mask[Work::kNew]);
  tbb::parallel_for(0, 2,
                    [&](int k) { FillLevelHoles(mask, &t.work->motion[static_cast<size_t>(k)]); });
}

/// The levels between the passes through the picture, each plane on its own.
void FillLevelsOf(const Task& t) {
  Work& w = *t.work;
  for (const Work::Kind kind : t.kinds()) {
    RaiseMask(&w.mask[kind]);
  }
  tbb::parallel_for(-3, t.planes.count, [&](int i) {
    if (i >= 0) {
      FillLevelHoles(w.mask[t.KindOf(i)], &w.plane[static_cast<size_t>(i)]);
    } else if (i == -1) {
      FillLevelHoles(w.mask[Work::kAny], &w.surface);
    } else if (i == -2) {
      FillLevelHoles(w.mask[Work::kSurface], &w.inverse_depth);
    } else if (!t.held->guides.id.empty()) {
      FillLevelHoles(w.mask[Work::kSurface], &w.id);
    }
  });
}

bool HasHoles(const Image1& known) {
  std::atomic<bool> any = false;
  ParallelRows(known.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1 && !any; ++y) {
      const float* row = known.Row(y);
      int holes = 0;
      for (int x = 0; x < known.width(); ++x) {
        holes |= static_cast<int>(!(row[x] > 0));
      }
      if (holes != 0) {
        any = true;
      }
    }
  });
  return any;
}

void MakeAllLevels(const Frame& frame, const HeldPlanes& planes, bool moves, Work* work) {
  const int w = frame.width;
  const int h = frame.height;
  for (FillMask& mask : work->mask) {
    MakeLevels(w, h, &mask);
  }
  MakeLevels(w, h, &work->surface);
  MakeLevels(w, h, &work->inverse_depth);
  for (int i = 0; i < planes.count; ++i) {
    MakeLevels(w, h, &work->plane[static_cast<size_t>(i)]);
  }
  for (FillLevels& levels : work->motion) {
    if (moves) {
      MakeLevels(w, h, &levels);
    }
  }
  if (!frame.guides.id.empty()) {
    MakeLevels(w, h, &work->id);
  }
}

void StopMotion(HeldGuides* held) {
  if (!held->motionless) {
    for (Image1& plane : held->guides.motion.channel) {
      plane.Fill(0.0f);
    }
    held->motionless = true;
  }
}

}  // namespace

void CompleteGuides(const Frame& frame, HeldGuides* held, SparseGuidesWork* work) {
  if (!Fits(*held, frame)) {
    *held = HeldGuides();
  }
  work->known_now.Resize(frame.width, frame.height);
  const FoundPixels found = FindKnown(frame, *held, &work->known_now);
  const bool moves = found.moves && !held->empty();
  if (moves) {
    std::swap(*held, work->before);
    MakeRoom(frame, found.seen, &work->before);
  }
  MakeRoom(frame, found.seen, held);
  Task task = {&frame,
               held,
               moves ? &work->before : nullptr,
               work,
               PlanesOf(frame, held),
               {},
               Shift(frame.index)};
  MakeAllLevels(frame, task.planes, moves, work);
  if (moves) {
    task.planes_before = PlanesOf(frame, &work->before);
    held->motionless = held->raised = false;
    FindGhosts(task);
    ForgetGhosts(task, GhostRadius(frame, found.count));
    RaiseMotion(task);
  } else {
    StopMotion(held);
  }
  ParallelRows(CellRows(task), kCellBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(TakeCellRows)(task, y0, y1);
  });
  held->raised = true;
  if (!HasHoles(held->known)) {
    return;
  }
  FillLevelsOf(task);
  ParallelRows(frame.height, kBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FillRows)(task, y0, y1);
  });
}

}  // namespace stillray::cpu
#endif
