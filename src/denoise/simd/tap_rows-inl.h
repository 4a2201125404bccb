// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Taps of a vector of pixels in another frame. Under smooth motion the taps are contiguous: loads
// then replace gathers, which take several times as long.
#if defined(STILLRAY_DENOISE_SIMD_TAP_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_TAP_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_TAP_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_TAP_ROWS_INL_H_
#endif

#include <algorithm>

#include "denoise/simd/vector_math-inl.h"
#include "stillray/image.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// A block of taps with one common offset from the pixels x, x + 1, ... of a vector.
struct SideBySide {
  bool found = false;
  int x = 0;  ///< of the first lane's first tap
  int y = 0;
};

/// Whether the first taps of the lanes in `used` are contiguous, at any position.
HWY_INLINE SideBySide FindSideBySide(VI first_x, VI first_y, MF used) {
  const DI di;
  const auto lanes = hn::RebindMask(di, used);
  const intptr_t some = hn::FindFirstTrue(di, lanes);
  SideBySide block;
  if (some < 0) {
    return block;
  }
  const VI start = hn::Sub(first_x, ColumnNumbers(0));
  const VI at = hn::Set(di, hn::ExtractLane(start, static_cast<size_t>(some)));
  const VI row = hn::Set(di, hn::ExtractLane(first_y, static_cast<size_t>(some)));
  const auto same = hn::And(hn::Eq(start, at), hn::Eq(first_y, row));
  block.x = hn::GetLane(at);
  block.y = hn::GetLane(row);
  block.found = hn::AllTrue(di, hn::Or(same, hn::Not(lanes)));
  return block;
}

/// Whether a block was found whose taps, extended by `before` and `after` pixels, all lie in the
/// image: no lane then needs clamping or tests.
HWY_INLINE bool LiesInPicture(const SideBySide& block, int before, int after, int width,
                              int height) {
  return block.found && block.x >= before && block.x + LaneCount() - 1 + after < width &&
         block.y >= before && block.y + after < height;
}

/// As FindSideBySide, but only where rows of `width` pixels without a border can be read: taps
/// first_x + lane .. first_x + lane + columns - 1. Unused lanes may read beyond the row, up to one
/// vector.
HWY_INLINE SideBySide FindSideBySide(VI first_x, VI first_y, MF used, int columns, int width) {
  SideBySide block = FindSideBySide(first_x, first_y, used);
  block.found = block.found && block.x >= 0 && block.x + columns - 1 <= width;
  return block;
}

/// Taps at one offset within their block: contiguous loads, else gathers.
struct TapLoad {
  bool side_by_side;
  int row;  ///< of the first lane
  int column;
  VI x;  ///< per lane; must be inside the image
  VI y;

  template <class D, typename T>
  HWY_INLINE hn::Vec<D> operator()(D d, const Plane<T>& plane) const {
    if (side_by_side) {
      return hn::LoadU(d, plane.Row(row) + column);
    }
    const VI stride = hn::Set(DI(), static_cast<int>(plane.stride()));
    return hn::GatherIndex(d, plane.Row(0), hn::Add(hn::Mul(y, stride), x));
  }
};

/// The taps in row `dy` and column `dx` of the block. Rows outside the image are read at its edge;
/// callers give them weight 0.
/// \param x, y  pixels for gathers: the taps, or any pixels inside the image where taps are outside
HWY_INLINE TapLoad TapAt(const SideBySide& block, int dx, int dy, int height, VI x, VI y) {
  return {block.found, std::clamp(block.y + dy, 0, height - 1), block.x + dx, x, y};
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
