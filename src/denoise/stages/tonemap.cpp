// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/tonemap.h"

#include "core/parallel.h"
#include "denoise/stages/tonemap_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/tonemap.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

HWY_INLINE VF HableCurve(VF x) {
  const DF d;
  const VF top =
      hn::MulAdd(x, hn::MulAdd(hn::Set(d, 0.15f), x, hn::Set(d, 0.05f)), hn::Set(d, 0.004f));
  const VF bottom =
      hn::MulAdd(x, hn::MulAdd(hn::Set(d, 0.15f), x, hn::Set(d, 0.5f)), hn::Set(d, 0.06f));
  return hn::Sub(hn::Div(top, bottom), hn::Set(d, 0.02f / 0.3f));
}

HWY_INLINE VF ToneCurve(VF x, int curve) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  VF y = x;
  if (curve == 1) {
    y = hn::Div(x, hn::Add(one, x));
  } else if (curve == 2) {
    y = hn::Div(HableCurve(hn::Add(x, x)), HableCurve(hn::Set(d, 11.2f)));
  } else if (curve == 3) {
    const VF s = hn::Mul(hn::Set(d, 0.6f), x);
    const VF top = hn::Mul(s, hn::MulAdd(hn::Set(d, 2.51f), s, hn::Set(d, 0.03f)));
    y = hn::Div(
        top, hn::MulAdd(s, hn::MulAdd(hn::Set(d, 2.43f), s, hn::Set(d, 0.59f)), hn::Set(d, 0.14f)));
  }
  return hn::Min(hn::Max(y, hn::Zero(d)), one);
}

HWY_INLINE VF SrgbEncode(VF x) {
  const DF d;
  const VF root = Exp2(hn::Mul(Log2(hn::Max(x, hn::Set(d, 0.003f))), hn::Set(d, 1.0f / 2.4f)));
  const VF curve = hn::MulAdd(hn::Set(d, 1.055f), root, hn::Set(d, -0.055f));
  return hn::IfThenElse(hn::Le(x, hn::Set(d, 0.0031308f)), hn::Mul(hn::Set(d, 12.92f), x), curve);
}

void TonemapRows(const Image3& colour, const TonemapParameters& p, int y0, int y1, uint8_t* out) {
  const DF d;
  const int width = colour.width();
  HWY_ALIGN float values[3][HWY_MAX_BYTES / sizeof(float)];
  for (int y = y0; y < y1; ++y) {
    uint8_t* row = out + static_cast<size_t>(y) * static_cast<size_t>(width) * 3;
    for (int x = 0; x < width; x += LaneCount()) {
      for (int c = 0; c < 3; ++c) {
        const VF exposed =
            hn::Mul(hn::LoadU(d, colour[c].Row(y) + x), hn::Set(d, p.exposure_scale));
        const VF positive =
            hn::IfThenElseZero(hn::Gt(exposed, hn::Zero(d)), exposed);  // NaN is black
        const VF light = hn::Min(positive, hn::Set(d, kBrightestLight));
        hn::Store(SrgbEncode(ToneCurve(light, p.tonemap)), d, values[c]);
      }
      for (int i = 0; i < LaneCount() && x + i < width; ++i) {
        for (int c = 0; c < 3; ++c) {
          const float noise =
              p.dither > 0 ? p.dither * stillray::DitherNoise(static_cast<uint32_t>(x + i),
                                                              static_cast<uint32_t>(y),
                                                              static_cast<uint32_t>(c), p.frame)
                           : 0.0f;
          row[(x + i) * 3 + c] = static_cast<uint8_t>(stillray::DisplayStep(values[c][i], noise));
        }
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

HWY_EXPORT(TonemapRows);

void Tonemap(const Image3& colour, const TonemapParameters& p, uint8_t* out) {
  ParallelRows(colour.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(TonemapRows)(colour, p, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
