// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/suppress_fireflies.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/stages/suppress_fireflies_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/suppress_fireflies.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Luminance of pixels with samples, -1 elsewhere.
void PresentLuminanceRows(const LumaImage3& in, const Image1& samples, int y0, int y1,
                          Image1* out) {
  const DF d;
  const int width = in.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF present = hn::Gt(hn::LoadU(d, samples.Row(y) + x), hn::Zero(d));
      StoreInRow(d, hn::IfThenElse(present, hn::LoadU(d, in[0].Row(y) + x), hn::Set(d, -1.0f)),
                 out->Row(y), x, width);
    }
  }
}

/// \param luminance  with a border of -1
void ClampFireflyRows(const LumaImage3& in, const Image1& luminance, int y0, int y1,
                      LumaImage3* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = in.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      VF brightest = hn::Set(d, -1.0f);
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (dx != 0 || dy != 0) {
            brightest = hn::Max(brightest, hn::LoadU(d, luminance.Row(y + dy) + x + dx));
          }
        }
      }
      const VF own = hn::LoadU(d, in[0].Row(y) + x);
      const MF clamp = hn::And(hn::Ge(brightest, zero), hn::Gt(own, brightest));
      const VF scale =
          hn::IfThenElse(clamp, hn::Div(brightest, hn::IfThenElse(clamp, own, one)), one);
      for (int c = 0; c < 3; ++c) {
        StoreInRow(d, hn::Mul(hn::LoadU(d, in[c].Row(y) + x), scale), (*out)[c].Row(y), x, width);
      }
    }
  }
}

/// See CompressScale and ExpandScale.
HWY_INLINE VF CurveScale(bool expand, VF l) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF two = hn::Set(d, 2.0f);
  const VF knee = hn::Set(d, kKnee);
  if (expand) {
    const VF part = hn::Max(hn::Div(l, knee), one);
    const VF left = hn::Max(hn::Sub(two, part), hn::Set(d, 1e-3f));
    return hn::Div(one, hn::Mul(part, left));
  }
  const VF part = hn::Div(knee, hn::Max(l, knee));
  return hn::Mul(part, hn::Sub(two, part));
}

void ScaleRows(bool expand, int y0, int y1, LumaImage3* colour) {
  const DF d;
  const int width = colour->width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF scale = CurveScale(expand, hn::LoadU(d, (*colour)[0].Row(y) + x));
      for (int c = 0; c < 3; ++c) {
        StoreInRow(d, hn::Mul(hn::LoadU(d, (*colour)[c].Row(y) + x), scale), (*colour)[c].Row(y), x,
                   width);
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

HWY_EXPORT(PresentLuminanceRows);
HWY_EXPORT(ClampFireflyRows);
HWY_EXPORT(ScaleRows);

void ClampFireflies(const LumaImage3& in, const Image1& samples, Image1* work, LumaImage3* out) {
  Image1& luminance = *work;
  if (luminance.width() != in.width() || luminance.height() != in.height()) {
    luminance = Image1(in.width(), in.height(), 1);
    for (int y = -1; y <= in.height(); ++y) {
      std::fill_n(luminance.Row(y) - 1, in.width() + 2, -1.0f);
    }
  }
  ParallelRows(in.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(PresentLuminanceRows)(in, samples, y0, y1, &luminance);
  });
  ParallelRows(in.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ClampFireflyRows)(in, luminance, y0, y1, out);
  });
}

void CompressLight(LumaImage3* colour) {
  ParallelRows(colour->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ScaleRows)(false, y0, y1, colour);
  });
}

void ExpandLight(LumaImage3* colour) {
  ParallelRows(colour->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(ScaleRows)(true, y0, y1, colour);
  });
}

}  // namespace stillray::cpu
#endif
