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

#include "denoise/simd/clamp_light-inl.h"
#include "denoise/simd/confidence-inl.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/sample_previous-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/follow_light.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

constexpr size_t kMostFetched = 112;

/// MovingAlpha for a vector of pixels.
HWY_INLINE VF MovingAlpha(const AntialiasParameters& p, VF mx, VF my, VF agreement) {
  const DF d;
  const VF distance = hn::Max(hn::Abs(mx), hn::Abs(my));
  const VF share = hn::Min(hn::Mul(hn::Set(d, kMovingRate), distance), hn::Set(d, 1.0f));
  const VF more = hn::Set(d, std::max(p.taa_moving_alpha - p.taa_alpha, 0.0f));
  return hn::MulAdd(hn::Mul(more, share), agreement, hn::Set(d, p.taa_alpha));
}

/// The smallest AlbedoAgreement of the three channels. \param now  the albedo of this frame
HWY_INLINE VF AgreementOf(const Image3& now, const VF antialiased[3], int x, int y) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  VF agreement = one;
  for (int c = 0; c < 3; ++c) {
    const VF a = hn::LoadU(d, now[c].Row(y) + x);
    const VF largest = hn::Add(hn::Max(a, antialiased[c]), hn::Set(d, kTextureFloor));
    const VF difference = hn::Abs(hn::Sub(a, antialiased[c]));
    const VF share = hn::Div(difference, hn::Mul(hn::Set(d, kLargestDifference), largest));
    agreement = hn::Min(agreement, hn::Sub(one, share));
  }
  return hn::Max(agreement, hn::Zero(d));
}

/// NewPictureWeight for a vector of pixels. \param least  MovingAlpha
HWY_INLINE VF Alpha(const AntialiasInput& in, VF least, VF longest, int x, int y) {
  const DF d;
  if (in.length == nullptr) {
    return least;
  }
  const VF alpha =
      in.confidence == nullptr ? least : ConfidentAlpha(least, ConfidenceOf(*in.confidence, x, y));
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
  Ranges range;  ///< of the demodulated image if ClampsLight, else of the image
  VF mx, my;     ///< motion of the nearest surface in front of the centre, else that of the centre
  VF longest;    ///< largest history length; 0 if unknown
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

/// The three rows around row y, from top to bottom; clamped at the image edge.
struct RowsAround {
  const float* colour[3][3];
  TextureRows texture;
  const float* length[3];  ///< nullptr: unknown
  const float* inverse_depth[3];
  const float* motion[3][2];
  const float* gradient[2];  ///< of row y only
  const float* ratio;        ///< factor of the previous image; nullptr: 1
};

/// \param colour_row  returns a row of the image for a channel
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

/// ExtrapolatedMotion for a vector of pixels of row y. \param to_x, to_y  offset of the nearest
///     surface in front of each, 0: none. \param mx, my  its motion; result
inline void ExtrapolateMotion(const Image2& motion, const GuidePlanes& guides, VF to_x, VF to_y,
                              int x, int y, VF* mx, VF* my) {
  const DF d;
  const DI di;
  const VI dx = hn::ConvertTo(di, to_x);
  const VI dy = hn::ConvertTo(di, to_y);
  VI qx = hn::Add(ColumnNumbers(x), dx);
  VI qy = hn::Add(hn::Set(di, y), dy);
  const VF here = GatherClamped(guides.inverse_depth, qx, qy);
  const VF slope = hn::MulAdd(GatherClamped(guides.gradient[0], qx, qy), to_x,
                              hn::Mul(GatherClamped(guides.gradient[1], qx, qy), to_y));
  VF distance = hn::Zero(d);
  VF plane = here;
  VF next_x[2];
  VF next_y[2];
  for (int k = 0; k < 2; ++k) {
    qx = hn::Add(qx, dx);
    qy = hn::Add(qy, dy);
    plane = hn::Add(plane, slope);
    const VF found = GatherClamped(guides.inverse_depth, qx, qy);
    distance = hn::Max(distance, hn::Abs(hn::Sub(found, plane)));
    next_x[k] = GatherClamped(motion[0], qx, qy);
    next_y[k] = GatherClamped(motion[1], qx, qy);
  }
  const VF cx = hn::Sub(*mx, next_x[0]);
  const VF cy = hn::Sub(*my, next_y[0]);
  const VF bend_x = hn::Abs(hn::Sub(cx, hn::Sub(next_x[0], next_x[1])));
  const VF bend_y = hn::Abs(hn::Sub(cy, hn::Sub(next_y[0], next_y[1])));
  const VF most = hn::Set(d, kMostMotionChange);
  const VF most_bend = hn::Mul(hn::Set(d, kMostBend), hn::Max(hn::Abs(cx), hn::Abs(cy)));
  const MF small = hn::And(hn::Lt(hn::Abs(cx), most), hn::Lt(hn::Abs(cy), most));
  const MF straight = hn::And(hn::Le(bend_x, most_bend), hn::Le(bend_y, most_bend));
  const MF same = hn::Le(distance, hn::Mul(hn::Set(d, kInFront), here));
  const MF continues = hn::And(same, hn::And(small, straight));
  *mx = hn::Add(*mx, hn::IfThenElseZero(continues, cx));
  *my = hn::Add(*my, hn::IfThenElseZero(continues, cy));
}

/// \tparam kStill  all neighbours have zero motion
/// \tparam kInner  neighbours exist in all columns, so that plain loads suffice; else the image
///     edge is repeated
template <bool kStill, bool kInner>
HWY_INLINE Neighbourhood LookAround(const RowsAround& rows, const AntialiasInput& in,
                                    bool extrapolates, int x, int y) {
  const DF d;
  const DI di;
  const int width = in.previous.width();
  const int height = in.previous.height();
  Neighbourhood n;
  const auto& clamped = rows.texture.albedo[1][0] != nullptr ? rows.texture.light : rows.colour;
  for (int c = 0; c < 3; ++c) {
    n.range.low[c] = n.range.high[c] = hn::LoadU(d, clamped[1][c] + x);
  }
  const auto of_centre = [&](const float* row)
                             HWY_ATTR { return kStill ? hn::Zero(d) : hn::LoadU(d, row + x); };
  const VF centre = of_centre(rows.inverse_depth[1]);
  const VF gx = of_centre(rows.gradient[0]);
  const VF gy = of_centre(rows.gradient[1]);
  const VF slack = hn::MulAdd(hn::Set(d, kInFront), centre, centre);
  n.longest = hn::Zero(d);
  VF nearest = centre;
  VF to_x = hn::Zero(d);
  VF to_y = hn::Zero(d);
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
        n.range.low[c] = hn::Min(n.range.low[c], q);
        n.range.high[c] = hn::Max(n.range.high[c], q);
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
        to_x = hn::IfThenElse(nearer, ox, to_x);
        to_y = hn::IfThenElse(nearer, hn::Set(d, row_offset), to_y);
      }
    }
  }
  const MF silhouette = hn::And(hn::Gt(nearest, centre), InRow(x, width));
  if (!kStill && extrapolates && !hn::AllFalse(d, silhouette)) {
    ExtrapolateMotion(in.motion, in.guides, to_x, to_y, x, y, &n.mx, &n.my);
  }
  return n;
}

/// Destination of a row of the image.
struct OutRow {
  float* row[3];
  float* copy[3];    ///< nullptr: none
  float* albedo[3];  ///< nullptr: none
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
  const Neighbourhood n = LookAround<kStill, kInner>(rows, in, p.extrapolate_motion != 0, x, y);
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
  const bool subcell = p.resampling == kSubcell;
  VF before[3];
  sample({in.previous, in.spline, subcell}, before);
  if (rows.ratio != nullptr) {
    const VF ratio = hn::LoadU(d, rows.ratio + x);
    for (int c = 0; c < 3; ++c) {
      before[c] = hn::Mul(before[c], ratio);
    }
  }
  const bool clamps_light = rows.texture.albedo[1][0] != nullptr;
  VF albedo[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  if (clamps_light) {
    sample({*in.texture->before, in.texture->spline, subcell}, albedo);
    const Ranges albedos = RangesAround<kInner>(rows.texture.albedo, x, width);
    ClampAlbedo<kInner>(rows.texture, in, albedos, at, x, y, albedo);
    ClampLight(n.range, RangesAround<kInner>(rows.colour, x, width), albedos, albedo, before);
  }
  VF least = hn::Set(d, p.taa_alpha);
  if constexpr (!kStill) {
    const VF agreement =
        clamps_light ? AgreementOf(in.texture->albedo.sum, albedo, x, y) : hn::Set(d, 1.0f);
    least = MovingAlpha(p, n.mx, n.my, agreement);
  }
  const VF alpha = Alpha(in, least, n.longest, x, y);
  for (int c = 0; c < 3; ++c) {
    const VF now = hn::LoadU(d, rows.colour[1][c] + x);
    const VF kept =
        clamps_light ? before[c] : hn::Min(hn::Max(before[c], n.range.low[c]), n.range.high[c]);
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
  /// Whether motion is zero in the rows around row y, which increases by one at every call.
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
