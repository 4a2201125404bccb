// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// taa_clamp=light of antialias: the demodulated previous image is clamped to the range of the
// demodulated current image, and its albedo to the range of the albedo.
#if defined(STILLRAY_DENOISE_SIMD_CLAMP_LIGHT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_CLAMP_LIGHT_INL_H_
#undef STILLRAY_DENOISE_SIMD_CLAMP_LIGHT_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_CLAMP_LIGHT_INL_H_
#endif

#include <algorithm>

#include "denoise/row_scratch.h"
#include "denoise/simd/sample_previous-inl.h"
#include "denoise/simd/vector_math-inl.h"
#include "denoise/stages/antialias.h"
#include "denoise/stages/antialias_shared.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// The rows around row y that the clamp reads; clamped at the image edge.
struct TextureRows {
  const float* albedo[3][3];                          ///< nullptr: the image itself is clamped
  const float* light[3][3];                           ///< LightOfPicture
  const float* inverse_depth[2 * kTextureClear + 1];  ///< from the one kTextureClear above
  const float* gradient[2];                           ///< of row y only
  const float* low[3];  ///< the range of the albedo, per pixel of row y
  const float* high[3];
};

/// Whether the previous image is clamped in demodulated form.
inline bool ClampsLight(const AntialiasInput& in) {
  return in.texture != nullptr && in.texture->before != nullptr;
}

/// Divides a row of the image by the albedo.
inline void LightRow(const float* picture, const float* albedo, int width, float* light) {
  const DF d;
  const VF floor = hn::Set(d, kTextureFloor);
  for (int x = 0; x < width; x += LaneCount()) {
    const VF divisor = hn::Add(hn::LoadU(d, albedo + x), floor);
    hn::StoreU(hn::Div(hn::LoadU(d, picture + x), divisor), d, light + x);
  }
}

/// The demodulated rows and albedo rows of a band, which is processed from top to bottom.
class TextureBand {
 public:
  static constexpr int kRows = 15;  ///< of the scratch memory

  /// \param first  of kRows rows of the scratch memory
  TextureBand(const AntialiasInput& in, const RowScratch& scratch, int first)
      : in_(in), scratch_(scratch), first_(first) {}

  /// Must be called for each row of the image before a row whose neighbourhood contains it is
  /// processed.
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
    for (int j = -kTextureClear; j <= kTextureClear; ++j) {
      const int row = std::clamp(y + j, 0, last);
      rows.inverse_depth[kTextureClear + j] = in_.guides.inverse_depth.Row(row);
    }
    rows.gradient[0] = in_.guides.gradient[0].Row(y);
    rows.gradient[1] = in_.guides.gradient[1].Row(y);
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
HWY_INLINE MF BesideSurface(const TextureRows& rows, int x, int y, int width, int height) {
  static_assert(kTextureClear == 2, "as many as the offsets below");
  const DF d;
  const DI di;
  const float* const own_row = rows.inverse_depth[kTextureClear];
  const VF here = hn::LoadU(d, own_row + x);
  const VF gx = hn::LoadU(d, rows.gradient[0] + x);
  const VF gy = hn::LoadU(d, rows.gradient[1] + x);
  const VF most = hn::Mul(hn::Set(d, kInFront), here);
  const auto differs = [&](VF found, VF expected) HWY_ATTR __attribute__((always_inline)) {
    return hn::Gt(hn::Abs(hn::Sub(found, expected)), most);
  };
  const auto beyond = [&](int offset) HWY_ATTR __attribute__((always_inline)) {
    const float* row = rows.inverse_depth[kTextureClear + offset];
    const int steps = std::clamp(y + offset, 0, height - 1) - y;
    const VF plane = hn::MulAdd(gy, hn::Set(d, static_cast<float>(steps)), here);
    return differs(hn::LoadU(d, row + x), plane);
  };
  const auto aside = [&](int offset) HWY_ATTR __attribute__((always_inline)) {
    VF steps = hn::Set(d, static_cast<float>(offset));
    VF found;
    if constexpr (kInner) {
      found = hn::LoadU(d, own_row + x + offset);
    } else {
      const VI columns = ColumnNumbers(x);
      const VI at = ClampColumns(hn::Add(columns, hn::Set(di, offset)), width);
      steps = hn::ConvertTo(d, hn::Sub(at, columns));
      found = hn::GatherIndex(d, own_row, at);
    }
    return differs(found, hn::MulAdd(gx, steps, here));
  };
  const MF vertically = hn::Or(hn::Or(beyond(-1), beyond(1)), hn::Or(beyond(-2), beyond(2)));
  const MF sideways = hn::Or(hn::Or(aside(-1), aside(1)), hn::Or(aside(-2), aside(2)));
  return hn::Or(vertically, sideways);
}

/// A range of each channel.
struct Ranges {
  VF low[3];
  VF high[3];
};

/// The ranges over 3x3 pixels.
/// \param rows  [row][channel]
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

/// WasBesideSurface for a vector of pixels.
/// \param load  takes the offset from the pixels
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

/// WereBesideSurface for the pixels of the last frame that are nearest to the positions `at`.
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

/// Clamps the previous albedo to the range of values that this surface may have.
/// \param around  the range of the albedo
template <bool kInner>
HWY_INLINE void ClampAlbedo(const TextureRows& rows, const AntialiasInput& in, const Ranges& around,
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
    const VF inside =
        hn::Min(hn::Max(albedo[c], hn::LoadU(d, rows.low[c] + x)), hn::LoadU(d, rows.high[c] + x));
    const VF own = hn::Min(hn::Max(inside, around.low[c]), around.high[c]);
    albedo[c] = hn::IfThenElse(clamps, own, inside);
  }
}

/// Clamps the demodulated previous image and multiplies it by the previous albedo.
/// \param light, picture, albedos  ranges over 3x3 pixels of this frame: demodulated image, image,
///     albedo
HWY_INLINE void ClampLight(const Ranges& light, const Ranges& picture, const Ranges& albedos,
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

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
