// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Rows of unpacked normals. A neighbourhood reads every normal up to 49 times: unpacking each row
/// once, into rows that stay in the cache, costs 1 to 5 % of the wavelet's time; unpacking at every
/// tap would cost 50 %. Plain and packed normals share the loop over the taps.
#pragma once

#include <cstddef>

#include "denoise/planes.h"
#include "denoise/row_scratch.h"

namespace stillray {

/// Normals of a row of pixels; the distance to other rows is constant.
struct NormalRows {
  const float* x;
  const float* y;
  const float* z;
};
struct NormalRowsTo {
  float* x;
  float* y;
  float* z;
};

inline NormalRows NormalRowsOf(const GuidePlanes& guides, int y) {
  return {guides.normal[0].Row(y), guides.normal[1].Row(y), guides.normal[2].Row(y)};
}

/// The unpacked rows around one row, `step` apart. At most one object may exist per thread.
class NormalWindow {
 public:
  /// Distance in memory of the normals of rows that are `step` apart in the image, for
  /// MakeTapPairs.
  static ptrdiff_t RowDistance(const GuidePlanes& guides, int step, int radius) {
    return guides.packs_normals() ? Storage::StrideOf(guides.id.width(), step * radius)
                                  : guides.inverse_depth.stride() * step;
  }

  /// \param radius  rows read above and below, and columns left and right, in steps
  NormalWindow(const GuidePlanes& guides, int step, int radius)
      : guides_(guides),
        step_(step),
        radius_(radius),
        rows_(guides.id.width(), guides.packs_normals() ? 3 * Slots() : 0, step * radius) {}

  /// \param unpack  called as unpack(packed, begin, end, to) for the pixels begin..end of a row
  /// \return the normals of row y; the rows around it are unpacked too
  template <typename Unpack>
  NormalRows MoveTo(int y, const Unpack& unpack) {
    const int around = 2 * radius_ + 1;
    const bool follows = filled_ > 0 && y == y_ + step_ && filled_ < Slots();
    if (follows) {
      Fill(filled_++, y + radius_ * step_, unpack);
    } else if (filled_ == 0 || y != y_) {
      for (filled_ = 0; filled_ < around; ++filled_) {
        Fill(filled_, y + (filled_ - radius_) * step_, unpack);
      }
    }
    y_ = y;
    const int centre = filled_ - 1 - radius_;
    return {rows_.Row(centre), rows_.Row(Slots() + centre), rows_.Row(2 * Slots() + centre)};
  }

 private:
  using Storage = ThreadRows<class NormalWindowRows>;
  static constexpr int kRowsAtOnce = 8;  ///< of the bands that threads process

  int Slots() const { return 2 * radius_ + kRowsAtOnce; }

  template <typename Unpack>
  void Fill(int slot, int y, const Unpack& unpack) const {
    const int reach = step_ * radius_;
    unpack(guides_.packed_normal.Row(y), -reach, guides_.id.width() + reach,
           NormalRowsTo{rows_.Row(slot), rows_.Row(Slots() + slot), rows_.Row(2 * Slots() + slot)});
  }

  const GuidePlanes& guides_;
  int step_;
  int radius_;
  Storage rows_;
  int filled_ = 0;  ///< slots; the last 2 radius + 1 are those around row y_
  int y_ = 0;
};

}  // namespace stillray
