// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// FillHoles of fill_guides: fills the holes of the image from the first level of the pyramid, all
// planes at once.
#include "denoise/fill_guides/fill_guides_task.h"

#include <limits>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/fill_guides/fill_holes.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/fill_guides/pyramid_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

using Work = FillGuidesWork;
using Task = FillGuidesTask;

/// One plane of a row with holes.
struct HoleRow {
  const float* vertical;  ///< the first level at this row, see UpsampleVertically
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

/// Fills the holes of row y.
void FillRow(const Task& t, const UpsampleAcross& across, int y) {
  const DF d;
  const DU du;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const float* known_row = t.held->known.Row(y);
  if (IsKnownRow(known_row, t.width())) {
    return;
  }
  const RowScratch scratch(t.cells(), 2 + t.planes.count);
  NextRow<HeldPlanes::kMaxPlanes + 3> next;
  next.Add(t.held->known, y + 1);
  next.Add(t.held->guides.depth, y + 1);
  next.Add(t.held->guides.id, y + 1);
  HoleRow rows[HeldPlanes::kMaxPlanes];
  for (int i = 0; i < t.planes.count; ++i) {
    const auto slot = static_cast<size_t>(i);
    const HeldPlane& plane = t.planes.plane[slot];
    rows[slot] = {scratch.Row(2 + i), plane.held->Row(y), plane.rule};
    UpsampleVertically(t.work->plane[slot].value.front(), y, scratch.Row(2 + i));
    next.Add(*plane.held, y + 1);
  }
  float* surface_part = scratch.Row(0);
  float* inverse_depth = scratch.Row(1);
  UpsampleVertically(t.work->surface.value.front(), y, surface_part);
  UpsampleVertically(t.work->inverse_depth.value.front(), y, inverse_depth);
  float* depth = t.held->guides.depth.Row(y);
  const bool has_id = !t.held->guides.id.empty();
  uint32_t* id = has_id ? t.held->guides.id.Row(y) : nullptr;
  const uint32_t* id_cells = has_id ? t.work->id.value.front().Row(y / kPyramidFactor) : nullptr;
  for (int x = 0; x < t.width(); x += LaneCount()) {
    next.Fetch(x);
    const MF hole = hn::AndNot(KnownAt(known_row, x), InRow(x, t.width()));
    if (hn::AllFalse(d, hole)) {
      continue;
    }
    const VF inverse = across(inverse_depth, x);
    const MF is_surface =
        hn::And(hn::Ge(across(surface_part, x), hn::Set(d, 0.5f)), hn::Gt(inverse, zero));
    const VF z = hn::IfThenElse(is_surface, hn::Div(one, hn::IfThenElse(is_surface, inverse, one)),
                                hn::Set(d, std::numeric_limits<float>::infinity()));
    hn::BlendedStore(z, hole, d, depth + x);
    for (int i = 0; i < t.planes.count; ++i) {
      const HoleRow& row = rows[i];
      VF filled = across(row.vertical, x);
      if (row.rule == FillRule::kSurfaceOnly) {
        filled = hn::IfThenElseZero(is_surface, filled);
      } else if (row.rule == FillRule::kSkyOnly) {
        filled = hn::IfThenZeroElse(is_surface, filled);
      }
      hn::BlendedStore(filled, hole, d, row.to + x);
    }
    if (has_id) {
      const VU filled = hn::IfThenElseZero(hn::RebindMask(du, is_surface), across.Own(id_cells, x));
      hn::BlendedStore(filled, hn::RebindMask(du, hole), du, id + x);
    }
  }
}

void FillRows(const Task& t, int y0, int y1) {
  const UpsampleAcross across;
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

HWY_EXPORT(FillRows);

void FillHoles(const FillGuidesTask& t) {
  ParallelRows(t.height(), kRowBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FillRows)(t, y0, y1);
  });
}

}  // namespace stillray::cpu
#endif
