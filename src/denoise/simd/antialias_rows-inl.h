// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Temporal antialiasing row by row: antialias, alone or fused with remodulate.
#if defined(STILLRAY_DENOISE_SIMD_ANTIALIAS_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_ANTIALIAS_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_ANTIALIAS_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_ANTIALIAS_ROWS_INL_H_
#endif

#include <algorithm>

#include "denoise/row_scratch.h"
#include "denoise/simd/confidence-inl.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/tap_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/follow_light.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

constexpr size_t kMostFetched = 112;

/// Columns clamped to the picture: pixels outside repeat the edge.
HWY_INLINE VI ClampColumns(VI x, int width) {
  const DI di;
  return hn::Min(hn::Max(x, hn::Zero(di)), hn::Set(di, width - 1));
}

HWY_INLINE void CatmullRom(VF t, VF w[4]) {
  const DF d;
  const VF t2 = hn::Mul(t, t);
  const VF t3 = hn::Mul(t2, t);
  const VF half = hn::Set(d, 0.5f);
  w[0] = hn::Sub(t2, hn::Mul(half, hn::Add(t3, t)));
  w[1] =
      hn::Add(hn::MulAdd(hn::Set(d, 1.5f), t3, hn::Mul(hn::Set(d, -2.5f), t2)), hn::Set(d, 1.0f));
  w[2] = hn::MulAdd(hn::Set(d, -1.5f), t3, hn::MulAdd(hn::Set(d, 2.0f), t2, hn::Mul(half, t)));
  w[3] = hn::Mul(half, hn::Sub(t3, t2));
}

/// See antialias_shared.h.
HWY_INLINE void CubicSpline(VF t, VF w[4]) {
  const DF d;
  const VF sixth = hn::Set(d, 1.0f / 6.0f);
  const VF half = hn::Set(d, 0.5f);
  const VF t2 = hn::Mul(t, t);
  const VF s = hn::Sub(hn::Set(d, 1.0f), t);
  w[0] = hn::Mul(sixth, hn::Mul(s, hn::Mul(s, s)));
  w[1] = hn::MulAdd(t2, hn::NegMulAdd(half, s, hn::Set(d, -0.5f)), hn::Set(d, 2.0f / 3.0f));
  w[3] = hn::Mul(sixth, hn::Mul(t2, t));
  w[2] = hn::Sub(hn::Set(d, 1.0f), hn::Add(w[0], hn::Add(w[1], w[3])));
}

/// NewPictureWeight for a vector of pixels.
HWY_INLINE VF Alpha(const AntialiasInput& in, const AntialiasParameters& p, VF longest, int x,
                    int y) {
  const DF d;
  if (in.length == nullptr) {
    return hn::Set(d, p.taa_alpha);
  }
  const VF alpha = in.confidence == nullptr
                       ? hn::Set(d, p.taa_alpha)
                       : ConfidentAlpha(p.taa_alpha, ConfidenceOf(*in.confidence, x, y));
  const VF one = hn::Set(d, 1.0f);
  const VF n = in.samples == nullptr ? one : hn::LoadU(d, in.samples->Row(y) + x);
  const MF some = hn::Gt(n, hn::Zero(d));
  const VF counted = hn::IfThenElse(hn::Gt(n, one), hn::Sqrt(n), n);
  const VF length = hn::Max(hn::Sub(longest, hn::Sub(n, counted)), counted);
  const VF share = hn::Div(counted, hn::IfThenElse(some, length, one));
  return hn::IfThenElse(some, hn::Min(hn::Max(alpha, share), one), alpha);
}

/// BlendTonemapped for a vector of pixels.
HWY_INLINE VF BlendTonemapped(VF before, VF now, VF alpha, VF scale) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF zero = hn::Zero(d);
  const VF of_before = hn::Div(hn::Sub(one, alpha), hn::MulAdd(scale, hn::Max(before, zero), one));
  const VF of_now = hn::Div(alpha, hn::MulAdd(scale, hn::Max(now, zero), one));
  return hn::Div(hn::MulAdd(of_before, before, hn::Mul(of_now, now)), hn::Add(of_before, of_now));
}

/// FollowedRow; nullptr without ratios.
inline const float* RatioRow(const AntialiasInput& in, int y, float* row) {
  if (in.ratio == nullptr) {
    return nullptr;
  }
  FollowedRow(*in.ratio, y, in.previous.width(), row);
  return row;
}

/// Values from the 3x3 neighbours of a vector of pixels.
struct Neighbourhood {
  VF low[3];  ///< the range of what is clamped: of the picture, or of its light
  VF high[3];
  VF mx, my;   ///< motion of the nearest surface in front of the centre's, or the centre's own
  VF longest;  ///< largest history length; 0 if unknown
};

/// Whether motion is zero in a whole row.
HWY_INLINE bool IsStillRow(const Image2& motion, int y) {
  const DF d;
  const VF zero = hn::Zero(d);
  const float* mx = motion[0].Row(y);
  const float* my = motion[1].Row(y);
  const int width = motion.width();
  bool still = true;
  for (int x = 0; x < width && still; x += LaneCount()) {
    const MF none = hn::And(hn::Eq(hn::LoadU(d, mx + x), zero), hn::Eq(hn::LoadU(d, my + x), zero));
    still = hn::AllTrue(d, hn::Or(none, hn::Not(InRow(x, width))));
  }
  return still;
}

/// The rows of the albedo around row y, as RowsAround.
struct TextureRows {
  const float* albedo[3][3];  ///< nullptr: the picture is clamped, not its light
  const float* light[3][3];   ///< LightOfPicture
  const float* beside[2];     ///< inverse depth of the rows kTextureClear above and below
  const float* low[3];        ///< the range of the albedo, per pixel of row y
  const float* high[3];
};

/// The rows around the pixels of row y, from the one above; clamped at the picture's edge.
struct RowsAround {
  const float* colour[3][3];
  TextureRows texture;
  const float* length[3];  ///< nullptr: unknown
  const float* inverse_depth[3];
  const float* motion[3][2];
  const float* gradient[2];  ///< of row y only
  const float* ratio;        ///< ... by which the previous picture is multiplied; nullptr: 1
};

/// \param colour_row  returns a row of the picture for a channel
template <class ColourRow>
RowsAround FindRowsAround(const Image2& motion, const GuidePlanes& guides, const Image1* length,
                          int y, const ColourRow& colour_row) {
  const int last = motion.height() - 1;
  RowsAround rows;
  for (int j = 0; j < 3; ++j) {
    const int row = std::clamp(y + j - 1, 0, last);
    for (int c = 0; c < 3; ++c) {
      rows.colour[j][c] = colour_row(c, row);
    }
    rows.length[j] = length != nullptr ? length->Row(row) : nullptr;
    rows.inverse_depth[j] = guides.inverse_depth.Row(row);
    rows.motion[j][0] = motion[0].Row(row);
    rows.motion[j][1] = motion[1].Row(row);
  }
  rows.gradient[0] = guides.gradient[0].Row(y);
  rows.gradient[1] = guides.gradient[1].Row(y);
  rows.ratio = nullptr;
  rows.texture.albedo[1][0] = nullptr;
  return rows;
}

/// Whether the light of the previous picture is clamped.
inline bool ClampsLight(const AntialiasInput& in) {
  return in.texture != nullptr && in.texture->before != nullptr;
}

/// Divides a row of the picture by the albedo.
inline void LightRow(const float* picture, const float* albedo, int width, float* light) {
  const DF d;
  const VF floor = hn::Set(d, kTextureFloor);
  for (int x = 0; x < width; x += LaneCount()) {
    const VF divisor = hn::Add(hn::LoadU(d, albedo + x), floor);
    hn::StoreU(hn::Div(hn::LoadU(d, picture + x), divisor), d, light + x);
  }
}

/// The rows of light and albedo of a band, while its rows are processed from above.
class TextureBand {
 public:
  static constexpr int kRows = 15;  ///< of the scratch memory

  /// \param first  of kRows rows of the scratch memory
  TextureBand(const AntialiasInput& in, const RowScratch& scratch, int first)
      : in_(in), scratch_(scratch), first_(first) {}

  /// Call it for each row of the picture before it is around a row that is processed.
  void AddRow(int y, const float* const picture[3]) {
    for (int c = 0; c < 3; ++c) {
      LightRow(picture[c], in_.texture->albedo.sum[c].Row(y), in_.previous.width(), Light(c, y));
    }
  }

  TextureRows Around(int y) {
    const int last = in_.previous.height() - 1;
    const SummedAlbedo& albedo = in_.texture->albedo;
    TextureRows rows;
    for (int j = 0; j < 3; ++j) {
      const int row = std::clamp(y + j - 1, 0, last);
      for (int c = 0; c < 3; ++c) {
        rows.albedo[j][c] = albedo.sum[c].Row(row);
        rows.light[j][c] = Light(c, row);
      }
    }
    rows.beside[0] = in_.guides.inverse_depth.Row(std::max(y - kTextureClear, 0));
    rows.beside[1] = in_.guides.inverse_depth.Row(std::min(y + kTextureClear, last));
    const bool new_block = y / kAlbedoBlock != block_;
    block_ = y / kAlbedoBlock;
    for (int c = 0; c < 3; ++c) {
      float* const low = scratch_.Row(first_ + 9 + c);
      float* const high = scratch_.Row(first_ + 12 + c);
      if (new_block) {
        RepeatBlocks(albedo.low[c], low);
        RepeatBlocks(albedo.high[c], high);
      }
      rows.low[c] = low;
      rows.high[c] = high;
    }
    return rows;
  }

 private:
  float* Light(int c, int y) const { return scratch_.Row(first_ + y % 3 * 3 + c); }
  void RepeatBlocks(const Image1& blocks, float* row) const {
    const float* from = blocks.Row(block_);
    const int width = in_.previous.width();
    for (int bx = 0; bx < blocks.width(); ++bx) {
      const int x = bx * kAlbedoBlock;
      std::fill_n(row + x, std::min(kAlbedoBlock, width - x), from[bx]);
    }
  }

  const AntialiasInput& in_;
  const RowScratch& scratch_;
  int first_;
  int block_ = -1;
};

/// \tparam kStill  none of the neighbours moves, whichever is nearest
/// \tparam kInner  neighbours exist in all columns, so that plain loads suffice; else the picture's
/// edge is repeated
template <bool kStill, bool kInner>
HWY_INLINE Neighbourhood LookAround(const RowsAround& rows, int x, int y, int width, int height) {
  const DF d;
  const DI di;
  Neighbourhood n;
  const auto& clamped = rows.texture.albedo[1][0] != nullptr ? rows.texture.light : rows.colour;
  for (int c = 0; c < 3; ++c) {
    n.low[c] = n.high[c] = hn::LoadU(d, clamped[1][c] + x);
  }
  const auto of_centre = [&](const float* row)
                             HWY_ATTR { return kStill ? hn::Zero(d) : hn::LoadU(d, row + x); };
  const VF centre = of_centre(rows.inverse_depth[1]);
  const VF gx = of_centre(rows.gradient[0]);
  const VF gy = of_centre(rows.gradient[1]);
  const VF slack = hn::MulAdd(hn::Set(d, kInFront), centre, centre);
  n.longest = hn::Zero(d);
  VF nearest = centre;
  n.mx = of_centre(rows.motion[1][0]);
  n.my = of_centre(rows.motion[1][1]);
  for (int j = 0; j < 3; ++j) {
    const float row_offset = static_cast<float>(std::clamp(y + j - 1, 0, height - 1) - y);
    for (int dx = -1; dx <= 1; ++dx) {
      VI at = hn::Zero(di);
      VF ox = hn::Set(d, static_cast<float>(dx));
      if constexpr (!kInner) {
        const VI columns = ColumnNumbers(x);
        at = ClampColumns(hn::Add(columns, hn::Set(di, dx)), width);
        ox = hn::ConvertTo(d, hn::Sub(at, columns));
      }
      const auto load = [&](const float* row) HWY_ATTR {
        return kInner ? hn::LoadU(d, row + x + dx) : hn::GatherIndex(d, row, at);
      };
      for (int c = 0; c < 3; ++c) {
        const VF q = load(clamped[j][c]);
        n.low[c] = hn::Min(n.low[c], q);
        n.high[c] = hn::Max(n.high[c], q);
      }
      if (rows.length[j] != nullptr) {
        n.longest = hn::Max(n.longest, load(rows.length[j]));
      }
      if constexpr (kStill) {
        continue;
      }
      const VF i = load(rows.inverse_depth[j]);
      const VF plane = hn::MulAdd(gx, ox, hn::MulAdd(gy, hn::Set(d, row_offset), slack));
      const MF nearer = hn::And(hn::Gt(i, nearest), hn::Gt(i, plane));
      if (!hn::AllFalse(d, nearer)) {
        nearest = hn::IfThenElse(nearer, i, nearest);
        n.mx = hn::IfThenElse(nearer, load(rows.motion[j][0]), n.mx);
        n.my = hn::IfThenElse(nearer, load(rows.motion[j][1]), n.my);
      }
    }
  }
  return n;
}

/// Position of a vector of pixels in the previous picture: the pixel to the upper left, and the
/// fractional offset.
struct PreviousPlace {
  VI x, y;
  VF u, v;
};

/// The filter over 4x4 taps.
/// \param load  takes a column and a row, -1..2, and a channel
template <typename Load>
HWY_INLINE void SampleTaps(bool spline, const PreviousPlace& place, const Load& load,
                           VF before[3]) {
  const DF d;
  VF wx[4];
  VF wy[4];
  if (spline) {
    CubicSpline(place.u, wx);
    CubicSpline(place.v, wy);
  } else {
    CatmullRom(place.u, wx);
    CatmullRom(place.v, wy);
  }
  for (int c = 0; c < 3; ++c) {
    before[c] = hn::Zero(d);
  }
  for (int j = 0; j < 4; ++j) {
    for (int c = 0; c < 3; ++c) {
      VF sum = hn::Mul(wx[0], load(-1, j - 1, c));
      for (int i = 1; i < 4; ++i) {
        sum = hn::MulAdd(wx[i], load(i - 1, j - 1, c), sum);
      }
      before[c] = hn::MulAdd(wy[j], sum, before[c]);
    }
  }
}

/// A value of a vector of pixels, which may lie beyond the picture, whose edge is repeated.
HWY_INLINE VF GatherClamped(const Image1& plane, VI x, VI y) {
  const DF d;
  const DI di;
  const VI stride = hn::Set(di, static_cast<int>(plane.stride()));
  const VI column = ClampColumns(x, plane.width());
  const VI row = ClampColumns(y, plane.height());
  return hn::GatherIndex(d, plane.Row(0), hn::Add(hn::Mul(row, stride), column));
}

/// An image of the last frame, and its spline coefficients or nullptr.
struct PreviousImage {
  const Image3& image;
  const Image3* spline;
};

/// Where a vector of pixels was in the last frame.
struct PreviousPixels {
  PreviousPlace place;
  MF whole;          ///< at the centre of a pixel
  SideBySide block;  ///< of the places
};

/// \param inside  other lanes are not read
HWY_INLINE PreviousPixels FindPixels(VF px, VF py, MF inside) {
  const DF d;
  const DI di;
  const VF zero = hn::Zero(d);
  const VF sx = hn::IfThenElseZero(inside, px);
  const VF sy = hn::IfThenElseZero(inside, py);
  const VF fx = hn::Floor(sx);
  const VF fy = hn::Floor(sy);
  PreviousPixels at;
  at.place = {hn::ConvertTo(di, fx), hn::ConvertTo(di, fy), hn::Sub(sx, fx), hn::Sub(sy, fy)};
  at.whole = hn::And(hn::Eq(at.place.u, zero), hn::Eq(at.place.v, zero));
  at.block = FindSideBySide(at.place.x, at.place.y, inside);
  return at;
}

/// SamplePrevious for taps that are not adjacent, or beyond the picture.
HWY_NOINLINE inline void GatherPrevious(const PreviousImage& from, const PreviousPixels& at,
                                        VF before[3]) {
  const DI di;
  const Image3& taps = from.spline != nullptr ? *from.spline : from.image;
  SampleTaps(
      from.spline != nullptr, at.place,
      [&](int i, int j, int c) HWY_ATTR {
        return GatherClamped(taps[c], hn::Add(at.place.x, hn::Set(di, i)),
                             hn::Add(at.place.y, hn::Set(di, j)));
      },
      before);
  for (int c = 0; c < 3; ++c) {
    before[c] =
        hn::IfThenElse(at.whole, GatherClamped(from.image[c], at.place.x, at.place.y), before[c]);
  }
}

HWY_INLINE void SamplePrevious(const PreviousImage& from, const PreviousPixels& at, VF before[3]) {
  const DF d;
  const SideBySide& block = at.block;
  if (!LiesInPicture(block, 1, 2, from.image.width(), from.image.height())) {
    GatherPrevious(from, at, before);
    return;
  }
  if (hn::AllTrue(d, at.whole)) {  // nothing moved
    for (int c = 0; c < 3; ++c) {
      before[c] = hn::LoadU(d, from.image[c].Row(block.y) + block.x);
    }
    return;
  }
  const Image3& taps = from.spline != nullptr ? *from.spline : from.image;
  const ptrdiff_t stride = taps[0].stride();
  const float* first[3];
  for (int c = 0; c < 3; ++c) {
    first[c] = taps[c].Row(block.y) + block.x;
  }
  SampleTaps(
      from.spline != nullptr, at.place,
      [&](int i, int j, int c) HWY_ATTR { return hn::LoadU(d, first[c] + j * stride + i); },
      before);
  if (!hn::AllFalse(d, at.whole)) {
    for (int c = 0; c < 3; ++c) {
      const VF kept = hn::LoadU(d, from.image[c].Row(block.y) + block.x);
      before[c] = hn::IfThenElse(at.whole, kept, before[c]);
    }
  }
}

/// IsYoung for the pixels x, x + 1, ... of row y.
HWY_INLINE MF YoungPixels(const AntialiasInput& in, int x, int y) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF n = in.samples == nullptr ? one : hn::LoadU(d, in.samples->Row(y) + x);
  const VF most = hn::Mul(hn::Set(d, kYoungFrames), hn::Max(n, one));
  return hn::Not(hn::Gt(hn::LoadU(d, in.length->Row(y) + x), most));
}

/// Whether another surface is within kTextureClear pixels along an axis.
template <bool kInner>
HWY_INLINE MF BesideSurface(const RowsAround& rows, int x, int y, int width, int height) {
  static_assert(kTextureClear == 2, "the rows are those at hand");
  const DF d;
  const DI di;
  const VF here = hn::LoadU(d, rows.inverse_depth[1] + x);
  const VF gx = hn::LoadU(d, rows.gradient[0] + x);
  const VF gy = hn::LoadU(d, rows.gradient[1] + x);
  const VF most = hn::Mul(hn::Set(d, kInFront), here);
  const auto differs = [&](VF found, VF expected) HWY_ATTR __attribute__((always_inline)) {
    return hn::Gt(hn::Abs(hn::Sub(found, expected)), most);
  };
  const auto beyond = [&](const float* row, int offset) HWY_ATTR __attribute__((always_inline)) {
    const int steps = std::clamp(y + offset, 0, height - 1) - y;
    const VF plane = hn::MulAdd(gy, hn::Set(d, static_cast<float>(steps)), here);
    return differs(hn::LoadU(d, row + x), plane);
  };
  const auto aside = [&](int offset) HWY_ATTR __attribute__((always_inline)) {
    const float* row = rows.inverse_depth[1];
    VF steps = hn::Set(d, static_cast<float>(offset));
    VF found;
    if constexpr (kInner) {
      found = hn::LoadU(d, row + x + offset);
    } else {
      const VI columns = ColumnNumbers(x);
      const VI at = ClampColumns(hn::Add(columns, hn::Set(di, offset)), width);
      steps = hn::ConvertTo(d, hn::Sub(at, columns));
      found = hn::GatherIndex(d, row, at);
    }
    return differs(found, hn::MulAdd(gx, steps, here));
  };
  const MF vertically =
      hn::Or(hn::Or(beyond(rows.inverse_depth[0], -1), beyond(rows.inverse_depth[2], 1)),
             hn::Or(beyond(rows.texture.beside[0], -2), beyond(rows.texture.beside[1], 2)));
  const MF sideways = hn::Or(hn::Or(aside(-1), aside(1)), hn::Or(aside(-2), aside(2)));
  return hn::Or(vertically, sideways);
}

/// A range of each channel.
struct Ranges {
  VF low[3];
  VF high[3];
};

/// Of 3x3 pixels. \param rows  [row][channel]
template <bool kInner>
HWY_INLINE Ranges RangesAround(const float* const (&rows)[3][3], int x, int width) {
  const DF d;
  const DI di;
  Ranges range;
  for (int c = 0; c < 3; ++c) {
    range.low[c] = range.high[c] = hn::LoadU(d, rows[1][c] + x);
    for (int j = 0; j < 3; ++j) {
      for (int dx = -1; dx <= 1; ++dx) {
        const VI at = ClampColumns(hn::Add(ColumnNumbers(x), hn::Set(di, dx)), width);
        const VF q =
            kInner ? hn::LoadU(d, rows[j][c] + x + dx) : hn::GatherIndex(d, rows[j][c], at);
        range.low[c] = hn::Min(range.low[c], q);
        range.high[c] = hn::Max(range.high[c], q);
      }
    }
  }
  return range;
}

/// WasBesideSurface of a vector of pixels. \param load  takes the offset from them
template <typename Load>
HWY_INLINE MF WereBesideSurface(const Load& load) {
  const DF d;
  const VF here = load(0, 0);
  const VF twice = hn::Add(here, here);
  VF most = hn::Zero(d);
  for (int k = 1; k <= kTextureClear; ++k) {
    const VF row = hn::Add(load(-k, 0), load(k, 0));
    const VF column = hn::Add(load(0, -k), load(0, k));
    most = hn::Max(most, hn::Max(hn::Abs(hn::Sub(row, twice)), hn::Abs(hn::Sub(column, twice))));
  }
  return hn::Gt(most, hn::Mul(hn::Set(d, kTextureStep), here));
}

/// The same of the pixels of the last frame that are nearest to places.
HWY_INLINE MF WereBesideSurface(const Image1& inverse_depth, const PreviousPixels& at) {
  const DF d;
  const DI di;
  const VF half = hn::Set(d, 0.5f);
  const PreviousPlace& place = at.place;
  const MF right = hn::Ge(place.u, half);
  const MF below = hn::Ge(place.v, half);
  const bool alike = (hn::AllTrue(d, right) || hn::AllFalse(d, right)) &&
                     (hn::AllTrue(d, below) || hn::AllFalse(d, below));
  if (alike && LiesInPicture(at.block, kTextureClear, kTextureClear + 1, inverse_depth.width(),
                             inverse_depth.height())) {
    const int x = at.block.x + (hn::AllTrue(d, right) ? 1 : 0);
    const int y = at.block.y + (hn::AllTrue(d, below) ? 1 : 0);
    const float* first = inverse_depth.Row(y) + x;
    const ptrdiff_t stride = inverse_depth.stride();
    return WereBesideSurface([&](int i, int j) HWY_ATTR __attribute__((always_inline)) {
      return hn::LoadU(d, first + j * stride + i);
    });
  }
  const VI one = hn::Set(di, 1);
  const VI x = hn::Add(place.x, hn::IfThenElseZero(hn::RebindMask(di, right), one));
  const VI y = hn::Add(place.y, hn::IfThenElseZero(hn::RebindMask(di, below), one));
  return WereBesideSurface([&](int i, int j) HWY_ATTR __attribute__((always_inline)) {
    return GatherClamped(inverse_depth, hn::Add(x, hn::Set(di, i)), hn::Add(y, hn::Set(di, j)));
  });
}

/// Clamps the previous albedo to what may be this surface's.
/// \param around  the range of the albedo
template <bool kInner>
HWY_INLINE void ClampAlbedo(const RowsAround& rows, const AntialiasInput& in, const Ranges& around,
                            const PreviousPixels& at, int x, int y, VF albedo[3]) {
  const DF d;
  const MF beside = BesideSurface<kInner>(rows, x, y, in.previous.width(), in.previous.height());
  MF clamps = hn::Or(hn::Or(YoungPixels(in, x, y), beside),
                     WereBesideSurface(*in.texture->depth_before, at));
  const Image1& beside_image = in.texture->albedo.beside_image;
  if (!beside_image.empty()) {
    clamps = hn::Or(clamps, hn::Gt(hn::LoadU(d, beside_image.Row(y) + x), hn::Zero(d)));
  }
  for (int c = 0; c < 3; ++c) {
    const VF inside = hn::Min(hn::Max(albedo[c], hn::LoadU(d, rows.texture.low[c] + x)),
                              hn::LoadU(d, rows.texture.high[c] + x));
    const VF own = hn::Min(hn::Max(inside, around.low[c]), around.high[c]);
    albedo[c] = hn::IfThenElse(clamps, own, inside);
  }
}

/// Clamps the light of the previous picture by the previous albedo.
/// \param light, picture, albedos  ranges
HWY_INLINE void ClampLight(const Neighbourhood& light, const Ranges& picture, const Ranges& albedos,
                           const VF albedo[3], VF before[3]) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF floor = hn::Set(d, kTextureFloor);
  for (int c = 0; c < 3; ++c) {
    const VF own = hn::Add(albedo[c], floor);
    const VF clamped =
        hn::Min(hn::Max(before[c], hn::Mul(light.low[c], own)), hn::Mul(light.high[c], own));
    // One division for both quotients.
    const VF lowest = hn::Add(albedos.low[c], floor);
    const VF highest = hn::Add(albedos.high[c], floor);
    const VF per_both = hn::Div(own, hn::Mul(lowest, highest));
    const MF textured = hn::Gt(albedos.high[c], hn::Set(d, kNoTexture));
    const VF lower = hn::Mul(per_both, highest);
    const VF higher = hn::IfThenElse(textured, hn::Mul(per_both, lowest), one);
    const VF low = hn::Mul(picture.low[c], hn::Min(lower, one));     // WidenedLow
    const VF high = hn::Mul(picture.high[c], hn::Max(higher, one));  // WidenedHigh
    before[c] = hn::Min(hn::Max(clamped, low), high);
  }
}

/// Destination of a row of the picture.
struct OutRow {
  float* row[3];
  float* copy[3];    ///< nullptr: none
  float* albedo[3];  ///< likewise
};

inline OutRow OutRowOf(const AntialiasInput& in, int y, Image3* out) {
  OutRow to;
  for (int c = 0; c < 3; ++c) {
    to.row[c] = (*out)[c].Row(y);
    to.copy[c] = in.copy != nullptr ? (*in.copy)[c].Row(y) : nullptr;
    to.albedo[c] = in.texture != nullptr ? (*in.texture->out)[c].Row(y) : nullptr;
  }
  return to;
}

/// Blends the pixels x, x + 1, ... of row y.
template <bool kStill, bool kInner>
HWY_INLINE void AntialiasVector(const RowsAround& rows, const AntialiasInput& in,
                                const AntialiasParameters& p, int x, int y, const OutRow& out) {
  const DF d;
  const int width = in.previous.width();
  const int height = in.previous.height();
  const Neighbourhood n = LookAround<kStill, kInner>(rows, x, y, width, height);
  const VF px = hn::Add(ColumnsFrom(x), n.mx);
  const VF py = hn::Add(hn::Set(d, static_cast<float>(y)), n.my);
  const VF edge = hn::Set(d, -0.5f);
  const MF in_x =
      hn::And(hn::Gt(px, edge), hn::Lt(px, hn::Set(d, static_cast<float>(width) - 0.5f)));
  const MF in_y =
      hn::And(hn::Gt(py, edge), hn::Lt(py, hn::Set(d, static_cast<float>(height) - 0.5f)));
  const MF inside = hn::And(hn::And(in_x, in_y), InRow(x, width));
  const PreviousPixels at = FindPixels(px, py, inside);
  const auto sample = [&](const PreviousImage& from, VF to[3]) HWY_ATTR
      __attribute__((always_inline)) {
    if constexpr (kStill) {
      for (int c = 0; c < 3; ++c) {
        to[c] = hn::LoadU(d, from.image[c].Row(y) + x);
      }
    } else {
      SamplePrevious(from, at, to);
    }
  };
  VF before[3];
  sample({in.previous, in.spline}, before);
  if (rows.ratio != nullptr) {
    const VF ratio = hn::LoadU(d, rows.ratio + x);
    for (int c = 0; c < 3; ++c) {
      before[c] = hn::Mul(before[c], ratio);
    }
  }
  const VF alpha = Alpha(in, p, n.longest, x, y);
  const bool clamps_light = rows.texture.albedo[1][0] != nullptr;
  VF albedo[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  if (clamps_light) {
    sample({*in.texture->before, in.texture->spline}, albedo);
    const Ranges albedos = RangesAround<kInner>(rows.texture.albedo, x, width);
    ClampAlbedo<kInner>(rows, in, albedos, at, x, y, albedo);
    ClampLight(n, RangesAround<kInner>(rows.colour, x, width), albedos, albedo, before);
  }
  for (int c = 0; c < 3; ++c) {
    const VF now = hn::LoadU(d, rows.colour[1][c] + x);
    const VF kept = clamps_light ? before[c] : hn::Min(hn::Max(before[c], n.low[c]), n.high[c]);
    const VF blend = p.tone_scale > 0 ? BlendTonemapped(kept, now, alpha, hn::Set(d, p.tone_scale))
                                      : hn::MulAdd(alpha, hn::Sub(now, kept), kept);
    const VF result = hn::IfThenElse(inside, blend, now);
    StreamInRow(d, result, out.row[c], x, width);
    if (out.copy[c] != nullptr) {
      StreamInRow(d, result, out.copy[c], x, width);
    }
  }
  for (int c = 0; out.albedo[0] != nullptr && c < 3; ++c) {
    const VF now = hn::LoadU(d, in.texture->albedo.sum[c].Row(y) + x);
    VF result = now;
    if (clamps_light) {
      result = hn::IfThenElse(inside, hn::MulAdd(alpha, hn::Sub(now, albedo[c]), albedo[c]), now);
    }
    StreamInRow(d, result, out.albedo[c], x, width);
  }
}

/// \param next  other rows to prefetch
template <bool kStill>
void AntialiasRow(const RowsAround& rows, NextRow<kMostFetched> next, const AntialiasInput& in,
                  const AntialiasParameters& p, int y, Image3* out) {
  const int width = in.previous.width();
  const OutRow to = OutRowOf(in, y, out);
  next.Add(!kStill && in.spline != nullptr ? *in.spline : in.previous, y + 3);
  if (!kStill) {
    next.Add(in.motion, y + 2);
    next.Add(in.guides.inverse_depth, y + 2);
    next.Add(in.guides.gradient, y + 1);
  }
  if (in.length != nullptr) {
    next.Add(*in.length, y + 2);
  }
  AddStreamed(*out, y + 1, &next);
  if (in.copy != nullptr) {
    AddStreamed(*in.copy, y + 1, &next);
  }
  if (in.texture != nullptr) {
    next.Add(in.texture->albedo.sum, y + 2);
    AddStreamed(*in.texture->out, y + 1, &next);
  }
  if (ClampsLight(in)) {
    const AntialiasTexture& texture = *in.texture;
    next.Add(!kStill && texture.spline != nullptr ? *texture.spline : *texture.before, y + 3);
  }
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    if (x >= kTextureClear && x + LaneCount() + kTextureClear <= width) {
      AntialiasVector<kStill, true>(rows, in, p, x, y, to);
    } else {
      AntialiasVector<kStill, false>(rows, in, p, x, y, to);
    }
  }
}

/// Whether motion is zero in each of three consecutive rows.
class StillRows {
 public:
  StillRows(const Image2& motion, int y) : motion_(motion) {
    still_[1] = IsStillRow(motion, std::max(y - 1, 0));
    still_[2] = IsStillRow(motion, y);
  }
  /// The rows around row y, which increases by one at every call.
  bool Around(int y) {
    still_[0] = still_[1];
    still_[1] = still_[2];
    still_[2] = IsStillRow(motion_, std::min(y + 1, motion_.height() - 1));
    return still_[0] && still_[1] && still_[2];
  }

 private:
  const Image2& motion_;
  bool still_[3] = {};
};

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
