// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Guides row by row: prepare_guides, alone or fused with reproject.
#if defined(STILLRAY_DENOISE_SIMD_PREPARE_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_PREPARE_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_PREPARE_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_PREPARE_ROWS_INL_H_
#endif

#include <algorithm>

#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/packed_normal-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/prepare_guides.h"
#include "denoise/stages/prepare_guides_shared.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Work memory in the cache: three rows of guides, and the slope of the middle one.
class KeptRows {
 public:
  explicit KeptRows(int width) : width_(width), rows_(width, 3 * kPlanes + 2) {}
  float* inverse_depth(int y) const { return rows_.Row(First(y)); }
  float* normal(int c, int y) const { return rows_.Row(First(y) + 1 + c); }
  uint32_t* id(int y) const { return rows_.Row<uint32_t>(First(y) + 4); }
  float* gradient(int c) const { return rows_.Row(3 * kPlanes + c); }
  /// Clears the pixels left and right of the image: no surface.
  void EmptyEnds(int y) const {
    for (int i = 0; i < kPlanes; ++i) {
      float* row = rows_.Row(First(y) + i);
      row[-1] = row[width_] = 0;
    }
  }
  /// Clears a row above or below the image: no surface.
  void Empty(int y) const {
    for (int i = 0; i < kPlanes; ++i) {
      std::fill_n(rows_.Row(First(y) + i) - 1, width_ + 2, 0.0f);
    }
  }

 private:
  static constexpr int kPlanes = 5;
  static int First(int y) { return (y + 3) % 3 * kPlanes; }
  int width_;
  RowScratch rows_;
};

/// Updates the flag of a block (1: every pixel is a surface); final after its last vector.
HWY_INLINE void MarkFull(MF surface, int x, uint32_t* row) {
  static_assert(kBlockPixels % hn::MaxLanes(DF()) == 0);
  uint32_t& block = row[x / kBlockPixels];
  const bool whole = hn::AllTrue(DF(), surface);
  block = whole && (x % kBlockPixels == 0 || block != 0) ? 1 : 0;
}

/// Converts a row of guides; stores it in `kept`, and with kWritten in `out`.
/// \return the number of pixels with bad guides
template <bool kWritten>
int64_t ConvertRow(const PrepareGuidesInput& in, int y, const KeptRows& kept, GuidePlanes* out) {
  const DF d;
  const DU du;
  const int width = in.depth->width();
  const bool packs_normals = out->packs_normals();
  int64_t bad = 0;
  const auto store = [&](VF v, float* row, Image1* plane, int x) HWY_ATTR {
    StoreInRow(d, v, row, x, width);
    if constexpr (kWritten) {
      StreamInRow(d, v, plane->Row(y), x, width);
    }
  };
  for (int x = 0; x < width; x += LaneCount()) {
    const VF z = hn::LoadU(d, in.depth->Row(y) + x);
    const VF nx = hn::LoadU(d, (*in.normal)[0].Row(y) + x);
    const VF ny = hn::LoadU(d, (*in.normal)[1].Row(y) + x);
    const VF nz = hn::LoadU(d, (*in.normal)[2].Row(y) + x);
    const MF finite_normal = hn::And(IsFiniteLane(nx), hn::And(IsFiniteLane(ny), IsFiniteLane(nz)));
    const VF length2 = hn::MulAdd(nx, nx, hn::MulAdd(ny, ny, hn::Mul(nz, nz)));
    const MF positive = hn::Gt(z, hn::Zero(d));
    MF surface = hn::And(hn::And(positive, IsFiniteLane(z)), finite_normal);
    surface = hn::And(surface, hn::And(hn::Gt(length2, hn::Set(d, 1e-12f)), IsFiniteLane(length2)));
    const VF one = hn::Set(d, 1.0f);
    const VF scale = hn::Div(one, hn::Sqrt(hn::IfThenElse(surface, length2, one)));
    const VF i = hn::Div(one, hn::IfThenElse(surface, z, one));
    store(hn::IfThenElseZero(surface, i), kept.inverse_depth(y), &out->inverse_depth, x);
    VF n[3] = {nx, ny, nz};
    for (VF& component : n) {
      component = hn::IfThenElseZero(surface, hn::Mul(component, scale));
    }
    if (packs_normals) {  // all stages use the rounded normals
      const VU packed = PackNormal(n);
      UnpackNormal(packed, n);
      for (int c = 0; c < 3; ++c) {
        StoreInRow(d, n[c], kept.normal(c, y), x, width);
      }
      if constexpr (kWritten) {
        StreamInRow(du, packed, out->packed_normal.Row(y), x, width);
      }
    } else {
      for (int c = 0; c < 3; ++c) {
        store(n[c], kept.normal(c, y), &out->normal[c], x);
      }
    }
    const VU given = in.id != nullptr ? hn::LoadU(du, in.id->Row(y) + x) : hn::Zero(du);
    const VU id = hn::IfThenElseZero(hn::RebindMask(du, surface), given);
    StoreInRow(du, id, kept.id(y), x, width);
    if constexpr (kWritten) {
      StreamInRow(d, hn::IfThenElseZero(surface, z), out->depth.Row(y), x, width);
      StreamInRow(du, id, out->id.Row(y), x, width);
    }
    if constexpr (kWritten) {
      MarkFull(hn::And(surface, InRow(x, width)), x, out->full.Row(y));
    }
    const MF good = hn::And(positive, finite_normal);
    bad += static_cast<int64_t>(hn::CountTrue(d, hn::AndNot(good, InRow(x, width))));
  }
  kept.EmptyEnds(y);
  return bad;
}

HWY_INLINE VF Gradient(VF before, VF centre, VF after, MF before_ok, MF after_ok) {
  const DF d;
  const VF backward = hn::Sub(centre, before);
  const VF forward = hn::Sub(after, centre);
  const VF both = hn::IfThenElse(hn::Lt(hn::Abs(backward), hn::Abs(forward)), backward, forward);
  return hn::IfThenElse(after_ok, hn::IfThenElse(before_ok, both, forward),
                        hn::IfThenElse(before_ok, backward, hn::Zero(d)));
}

inline void GradientRow(const KeptRows& kept, int y, const NextRow<32>* next, GuidePlanes* g) {
  const DF d;
  const DU du;
  const int width = g->id.width();
  float* turn2 = g->turn2.empty() ? nullptr : g->turn2.Row(y);
  for (int x = 0; x < width; x += LaneCount()) {
    if (next != nullptr) {
      next->Fetch(x);
    }
    const VF nx = hn::LoadU(d, kept.normal(0, y) + x);
    const VF ny = hn::LoadU(d, kept.normal(1, y) + x);
    const VF nz = hn::LoadU(d, kept.normal(2, y) + x);
    const VU id = hn::LoadU(du, kept.id(y) + x);
    const auto cosine_to = [&](int dx, int dy) HWY_ATTR {
      return hn::MulAdd(nx, hn::LoadU(d, kept.normal(0, y + dy) + x + dx),
                        hn::MulAdd(ny, hn::LoadU(d, kept.normal(1, y + dy) + x + dx),
                                   hn::Mul(nz, hn::LoadU(d, kept.normal(2, y + dy) + x + dx))));
    };
    const VF left = cosine_to(-1, 0);
    const VF right = cosine_to(1, 0);
    const VF up = cosine_to(0, -1);
    const VF down = cosine_to(0, 1);
    const auto same = [&](VF cosine, int dx, int dy) HWY_ATTR {
      const auto same_id = hn::Eq(id, hn::LoadU(du, kept.id(y + dy) + x + dx));
      return hn::And(hn::Ge(cosine, hn::Set(d, kGradientMinCosine)), hn::RebindMask(d, same_id));
    };
    const auto i = [&](int dx, int dy)
                       HWY_ATTR { return hn::LoadU(d, kept.inverse_depth(y + dy) + x + dx); };
    const VF gradient[2] = {
        Gradient(i(-1, 0), i(0, 0), i(1, 0), same(left, -1, 0), same(right, 1, 0)),
        Gradient(i(0, -1), i(0, 0), i(0, 1), same(up, 0, -1), same(down, 0, 1))};
    for (int c = 0; c < 2; ++c) {
      StoreInRow(d, gradient[c], kept.gradient(c), x, width);
      StreamInRow(d, gradient[c], g->gradient[c].Row(y), x, width);
    }
    if (turn2 != nullptr) {
      const VF cosines = hn::Add(hn::Max(left, right), hn::Max(up, down));
      const VF angle = hn::Max(hn::Sub(hn::Set(d, 2.0f), cosines), hn::Zero(d));
      StreamInRow(d, hn::Add(angle, angle), turn2, x, width);
    }
  }
}

/// The inputs and outputs of a row.
inline NextRow<32> NextRowOf(const PrepareGuidesInput& in, const GuidePlanes& out, int y) {
  NextRow<32> next;
  next.Add(*in.depth, y);
  next.Add(*in.normal, y);
  if (in.id != nullptr) {
    next.Add(*in.id, y);
  }
  AddStreamed(out.inverse_depth, y, &next);
  AddStreamed(out.depth, y, &next);
  AddStreamed(out.normal, y, &next);
  AddStreamed(out.packed_normal, y, &next);
  AddStreamed(out.id, y, &next);
  AddStreamed(out.gradient, y, &next);
  AddStreamed(out.turn2, y, &next);
  return next;
}

/// \param fetch   whether this function prefetches the next row
/// \param then    called as then(y, kept, next) after the guides of row y are computed
/// \return the number of pixels with bad guides in the rows y0..y1
template <typename Then>
int64_t PrepareRowsThen(const PrepareGuidesInput& in, bool fetch, int y0, int y1, GuidePlanes* out,
                        const Then& then) {
  const int height = in.depth->height();
  const KeptRows kept(in.depth->width());
  const auto beside = [&](int y) {  // another band writes and counts these rows
    y < 0 || y >= height ? kept.Empty(y) : static_cast<void>(ConvertRow<false>(in, y, kept, out));
  };
  beside(y0 - 1);
  int64_t bad = ConvertRow<true>(in, y0, kept, out);
  for (int y = y0; y < y1; ++y) {
    if (y + 1 < y1) {
      bad += ConvertRow<true>(in, y + 1, kept, out);
    } else {
      beside(y + 1);
    }
    const NextRow<32> next = NextRowOf(in, *out, y + 2);
    GradientRow(kept, y, fetch ? &next : nullptr, out);
    then(y, kept, next);
  }
  FinishStreams();
  return bad;
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
