// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/colour_shared.h"
#include "denoise/stages/tonemap.h"
#include "denoise/stages/tonemap_shared.h"

namespace stillray::reference {

void Tonemap(const Image3& colour, const TonemapParameters& p, uint8_t* out) {
  for (int y = 0; y < colour.height(); ++y) {
    for (int x = 0; x < colour.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        const float exposed = colour[c](x, y) * p.exposure_scale;
        const float light = exposed > 0 ? min(exposed, kBrightestLight) : 0.0f;  // NaN is black
        const float display = SrgbEncode(ToneCurve(light, p.tonemap));
        const float noise = p.dither > 0 ? p.dither * DitherNoise(static_cast<uint32_t>(x),
                                                                  static_cast<uint32_t>(y),
                                                                  static_cast<uint32_t>(c), p.frame)
                                         : 0.0f;
        *out++ = static_cast<uint8_t>(DisplayStep(display, noise));
      }
    }
  }
}

}  // namespace stillray::reference
