// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Fetches the history of a vector of pixels along their taps (stages/reproject.h).
#if defined(STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#undef STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_FETCH_TAPS_INL_H_
#endif

#include <algorithm>

#include "denoise/planes.h"
#include "denoise/simd/confidence-inl.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// Mean of the taps chosen by the search, for one pixel; with `light_only`, of those with samples.
inline float FetchSearched(const Image1& plane, const Image1& length, const ReprojectionTaps& taps,
                           bool light_only, int x, int y) {
  const uint32_t search = taps.search(x, y);
  float sum = 0;
  int count = 0;
  for (int i = 0; i < 9; ++i) {
    const int qx = taps.x(x, y) + i % 3;
    const int qy = taps.y(x, y) + i / 3;
    if ((search >> i & 1u) != 0 && (!light_only || length(qx, qy) > 0)) {
      sum += plane(qx, qy);
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<float>(count) : 0.0f;
}

/// Removes the taps without samples, and rescales the other weights so that their sum is unchanged.
HWY_INLINE void KeepTapsWithLight(const VF length[4], const VF weight[4], VF kept[4]) {
  const DF d;
  const VF zero = hn::Zero(d);
  VF sum = zero;
  VF lost = zero;
  for (int i = 0; i < 4; ++i) {
    kept[i] = hn::IfThenElseZero(hn::Gt(length[i], zero), weight[i]);
    sum = hn::Add(sum, kept[i]);
    lost = hn::Add(lost, hn::Sub(weight[i], kept[i]));
  }
  const VF one = hn::Set(d, 1.0f);
  const MF rescale = hn::And(hn::Gt(lost, zero), hn::Gt(sum, zero));
  const VF scale = hn::IfThenElse(rescale, hn::Div(one, hn::IfThenElse(rescale, sum, one)), one);
  for (int i = 0; i < 4; ++i) {
    kept[i] = hn::Mul(kept[i], scale);
  }
}

/// Memory layout of the taps of a vector of pixels.
enum class TapKind {
  kSingle,    ///< one tap each, contiguous
  kBlock2x2,  ///< 2x2 taps each, contiguous and all inside the image
  kAnywhere,
};

/// The 2x2 taps of a vector of pixels, and their weights.
struct FetchTaps {
  TapKind kind;
  int column, row;  ///< of the first lane's first tap, unless kAnywhere
  VI at_x[4];       ///< pixels of the taps, for kAnywhere
  VI at_y[4];
  VF weight[4];
  VF kept[4];     ///< weights, 0 for taps without samples
  bool searched;  ///< some pixels take the mean of the taps chosen by the search (kAnywhere)
  const ReprojectionTaps* taps;
  int x, y;
};

/// Sets the weights of pixels with confidence 0 to zero.
HWY_INLINE void DropLight(VF confidence, FetchTaps* t) {
  const MF holds = hn::Gt(confidence, hn::Zero(DF()));
  const int count = t->kind == TapKind::kSingle ? 1 : 4;
  for (int i = 0; i < count; ++i) {
    t->weight[i] = hn::IfThenElseZero(holds, t->weight[i]);
    t->kept[i] = hn::IfThenElseZero(holds, t->kept[i]);
  }
}

/// Whether the taps of a vector are known without reading the planes of taps.
HWY_INLINE bool IsIdentityOrDisoccluded(TapPattern pattern) {
  return pattern == TapPattern::kIdentity || pattern == TapPattern::kDisoccluded;
}

/// The row of a pixel's first tap.
HWY_INLINE int RowOfTaps(const ReprojectionTaps& taps, int x, int y) {
  const TapPattern pattern = taps.Pattern(x / LaneCount(), y);
  if (pattern == TapPattern::kBlock2x2) {
    return taps.Block(x / LaneCount(), y).y;
  }
  return IsIdentityOrDisoccluded(pattern) ? y : taps.y(x, y);
}

/// Adds the rows of the planes of taps that fetching row y reads.
template <size_t kMost>
HWY_INLINE void AddTaps(const ReprojectionTaps& taps, int y, NextRow<kMost>* next) {
  next->Add(taps.weight, y);
  // For a row with few scattered vectors, waiting for the loads costs less than the prefetches.
  if (y < taps.x.height() && taps.scattered[static_cast<size_t>(y)] > taps.blocks_per_row / 4) {
    next->Add(taps.x, y);
    next->Add(taps.y, y);
    next->Add(taps.search, y);
  }
}

/// Taps of vectors that are kIdentity or kDisoccluded.
HWY_INLINE FetchTaps IdentityTaps(const SignalHistory& before, const ReprojectionTaps& taps, int x,
                                  int y) {
  const DF d;
  const bool any = taps.Pattern(x / LaneCount(), y) == TapPattern::kIdentity;
  FetchTaps t;
  t.kind = TapKind::kSingle;
  t.column = x;
  t.row = y;
  t.weight[0] = hn::IfThenElseZero(InRow(x, taps.x.width()), hn::Set(d, any ? 1.0f : 0.0f));
  const MF has_light = hn::Gt(hn::LoadU(d, before.length.Row(y) + x), hn::Zero(d));
  t.kept[0] = hn::IfThenElseZero(has_light, t.weight[0]);
  t.searched = false;
  return t;
}

/// One plane at tap i.
template <TapKind kKind>
HWY_INLINE VF LoadTap(const Image1& plane, const FetchTaps& t, int i) {
  const DF d;
  if constexpr (kKind == TapKind::kAnywhere) {
    const VI stride = hn::Set(DI(), static_cast<int>(plane.stride()));
    return hn::GatherIndex(d, plane.Row(0), hn::Add(hn::Mul(t.at_y[i], stride), t.at_x[i]));
  } else {
    return hn::LoadU(d, plane.Row(t.row + (i >> 1)) + t.column + (i & 1));
  }
}

template <TapKind kKind>
HWY_INLINE void WeighLight(const SignalHistory& before, FetchTaps* t) {
  const DF d;
  VF length[4];
  for (int i = 0; i < 4; ++i) {
    length[i] = LoadTap<kKind>(before.length, *t, i);
  }
  const VF least = hn::Min(hn::Min(length[0], length[1]), hn::Min(length[2], length[3]));
  if (hn::AllTrue(d, hn::Gt(least, hn::Zero(d)))) {  // the common case
    for (int i = 0; i < 4; ++i) {
      t->kept[i] = t->weight[i];
    }
    return;
  }
  KeepTapsWithLight(length, t->weight, t->kept);
}

/// Taps of vectors that are kBlock2x2.
HWY_INLINE FetchTaps BlockTaps(const SignalHistory& before, const ReprojectionTaps& taps, int x,
                               int y) {
  const DF d;
  const TapBlock block = taps.Block(x / LaneCount(), y);
  FetchTaps t;
  t.kind = TapKind::kBlock2x2;
  t.column = block.x;
  t.row = block.y;
  for (int i = 0; i < 4; ++i) {
    t.weight[i] = hn::LoadU(d, taps.weight[i].Row(y) + x);
  }
  t.searched = false;
  WeighLight<TapKind::kBlock2x2>(before, &t);
  return t;
}

/// Taps of all other vectors, from the planes of taps.
HWY_INLINE FetchTaps ScatteredTaps(const SignalHistory& before, const ReprojectionTaps& taps, int x,
                                   int y) {
  const DF d;
  const DI di;
  const DU du;
  const int width = taps.x.width();
  const MF in_row = InRow(x, width);
  const VI bx = hn::LoadU(di, taps.x.Row(y) + x);
  const VI by = hn::LoadU(di, taps.y.Row(y) + x);
  FetchTaps t;
  MF used = hn::FirstN(d, 0);
  for (int i = 0; i < 4; ++i) {
    t.weight[i] = hn::IfThenElseZero(in_row, hn::LoadU(d, taps.weight[i].Row(y) + x));
    used = hn::Or(used, hn::Gt(t.weight[i], hn::Zero(d)));
  }
  const VU search =
      hn::IfThenElseZero(hn::RebindMask(du, in_row), hn::LoadU(du, taps.search.Row(y) + x));
  t.searched = !hn::AllTrue(du, hn::Eq(search, hn::Zero(du)));
  t.taps = &taps;
  t.x = x;
  t.y = y;
  const SideBySide block = FindSideBySide(bx, by, used);
  if (LiesInPicture(block, 0, 1, width, taps.x.height()) && !t.searched) {
    t.kind = TapKind::kBlock2x2;
    t.column = block.x;
    t.row = block.y;
    WeighLight<TapKind::kBlock2x2>(before, &t);
    return t;
  }
  t.kind = TapKind::kAnywhere;
  for (int i = 0; i < 4; ++i) {
    const auto counts = hn::RebindMask(di, hn::Gt(t.weight[i], hn::Zero(d)));
    t.at_x[i] = hn::IfThenElseZero(counts, hn::Add(bx, hn::Set(di, i & 1)));
    t.at_y[i] = hn::IfThenElseZero(counts, hn::Add(by, hn::Set(di, i >> 1)));
  }
  WeighLight<TapKind::kAnywhere>(before, &t);
  return t;
}

/// One plane of the history `before` at a vector of pixels.
/// \tparam kLightOnly  taps without samples have weight 0
template <TapKind kKind, bool kLightOnly>
HWY_INLINE VF FetchPlane(const Image1& plane, const SignalHistory& before, const FetchTaps& t) {
  const DF d;
  const auto weight = [&](int i) HWY_ATTR { return kLightOnly ? t.kept[i] : t.weight[i]; };
  VF sum = hn::Mul(weight(0), LoadTap<kKind>(plane, t, 0));
  if constexpr (kKind != TapKind::kSingle) {
    for (int i = 1; i < 4; ++i) {
      sum = hn::MulAdd(weight(i), LoadTap<kKind>(plane, t, i), sum);
    }
  }
  if (kKind == TapKind::kAnywhere && t.searched) {
    HWY_ALIGN float lanes[hn::MaxLanes(d)];
    hn::Store(sum, d, lanes);
    const int count = std::min(LaneCount(), plane.width() - t.x);
    for (int i = 0; i < count; ++i) {
      if (t.taps->search(t.x + i, t.y) != 0 && t.taps->ConfidenceAt(t.x + i, t.y) > 0) {
        lanes[i] = FetchSearched(plane, before.length, *t.taps, kLightOnly, t.x + i, t.y);
      }
    }
    sum = hn::Load(d, lanes);
  }
  return sum;
}

template <bool kWithConfidence>
struct HistoryConfidence {
  static constexpr bool kHasConfidence = false;
};

template <>
struct HistoryConfidence<true> {
  static constexpr bool kHasConfidence = true;
  VF confidence;
};

/// The history `before` at a vector of pixels. Taps without samples contribute only to the length.
/// \tparam kWithConfidence  the frame has a confidence
template <TapKind kKind, bool kWithConfidence>
struct HistoryAt : HistoryConfidence<kWithConfidence> {
  const SignalHistory& before;
  const FetchTaps& taps;

  HWY_INLINE VF Length() const {
    const VF length = FetchPlane<kKind, false>(before.length, before, taps);
    if constexpr (kWithConfidence) {  // ConfidentLength
      const VF confidence = this->confidence;
      const DF d;
      const VF one = hn::Set(d, 1.0f);
      VF effective = length;
      if (!before.weights2.empty()) {
        const VF most = hn::Div(one, hn::Max((*this)(before.weights2), hn::Set(d, 1e-6f)));
        effective = hn::Min(length, most);
      }
      const VF shortened = hn::Mul(confidence, effective);
      return hn::IfThenElse(hn::Lt(confidence, one), shortened, length);
    } else {
      return length;
    }
  }
  /// \param plane  another plane of `before`
  HWY_INLINE VF operator()(const Image1& plane) const {
    return FetchPlane<kKind, true>(plane, before, taps);
  }
};

/// Calls `use` with the history of the taps t.
template <TapKind kKind, bool kWithConfidence, typename Use>
HWY_INLINE void UseHistory(const SignalHistory& before, const ReprojectionTaps& taps,
                           const FetchTaps& t, int x, int y, const Use& use) {
  if constexpr (kWithConfidence) {
    const VF confidence = ConfidenceOf(*taps.confidence, x, y);
    FetchTaps with_light = t;
    DropLight(confidence, &with_light);
    use(HistoryAt<kKind, true>{{confidence}, before, with_light});
  } else {
    use(HistoryAt<kKind, false>{{}, before, t});
  }
}

/// Calls `use` with the history `before` at the pixels x, x + 1, ... of row y, a HistoryAt. There
/// is one call for each layout of taps, so that no plane needs a branch and weights stay in
/// registers.
///
/// \param use  always inlined
/// \tparam kWithConfidence  whether taps.confidence is given; a template argument, since code for
///     both cases in one function is slower
template <bool kWithConfidence, typename Use>
HWY_INLINE void WithHistory(const SignalHistory& before, const ReprojectionTaps& taps, int x, int y,
                            const Use& use) {
  const TapPattern pattern = taps.Pattern(x / LaneCount(), y);
  if (pattern == TapPattern::kBlock2x2) {
    const FetchTaps t = BlockTaps(before, taps, x, y);
    UseHistory<TapKind::kBlock2x2, kWithConfidence>(before, taps, t, x, y, use);
  } else if (IsIdentityOrDisoccluded(pattern)) {
    const FetchTaps t = IdentityTaps(before, taps, x, y);
    UseHistory<TapKind::kSingle, kWithConfidence>(before, taps, t, x, y, use);
  } else {
    const FetchTaps t = ScatteredTaps(before, taps, x, y);
    if (t.kind == TapKind::kBlock2x2) {
      UseHistory<TapKind::kBlock2x2, kWithConfidence>(before, taps, t, x, y, use);
    } else {
      UseHistory<TapKind::kAnywhere, kWithConfidence>(before, taps, t, x, y, use);
    }
  }
}

/// Prefetches the taps of a scattered vector some vectors ahead: in rows with few scattered
/// vectors, no other prefetch is early enough.
HWY_INLINE void FetchScattered(const ReprojectionTaps& taps, int x, int y) {
  constexpr int kAhead = 6;  // vectors
  const int ahead = x + kAhead * LaneCount();
  if (ahead >= taps.x.width()) {
    return;
  }
  const TapPattern pattern = taps.Pattern(ahead / LaneCount(), y);
  if (pattern == TapPattern::kGather || pattern == TapPattern::kIdentityOrNone) {
    __builtin_prefetch(taps.x.Row(y) + ahead);
    __builtin_prefetch(taps.y.Row(y) + ahead);
    __builtin_prefetch(taps.search.Row(y) + ahead);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
