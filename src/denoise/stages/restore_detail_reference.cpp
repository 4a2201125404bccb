// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/restore_detail.h"

namespace stillray::reference {

void BeginDetail(const DetailInput& in, const SignalHistory& residual, const GuidePlanes& guides,
                 const RestoreDetailParameters& p, FilterPlanes* mean, Image1* valid) {
  for (int y = 0; y < valid->height(); ++y) {
    for (int x = 0; x < valid->width(); ++x) {
      const float length = residual.length(x, y);
      const bool known = guides.inverse_depth(x, y) > 0 && length > 0;
      (*valid)(x, y) = known ? 1.0f : 0.0f;
      for (int c = 0; c < 3; ++c) {
        mean->colour[c](x, y) = residual.colour[c](x, y);
      }
      mean->variance(x, y) = known ? ResidualVariance((*in.variance)(x, y), in.light->samples(x, y),
                                                      length, p.alpha_min)
                                   : 0.0f;
    }
  }
}

void MeasureDetail(const DetailInput& in, const FilterPlanes& mean, const Image1& valid,
                   FilterPlanes* measured) {
  for (int y = 0; y < valid.height(); ++y) {
    for (int x = 0; x < valid.width(); ++x) {
      float product = 0;
      float square = 0;
      if (valid(x, y) > 0 && in.light->samples(x, y) > 0) {
        const float filtered = (*in.filtered)[0](x, y);
        const float scale = DetailScale(filtered, (*in.variance)(x, y));
        const float m = ScaledDetail(mean.colour[0](x, y), scale);
        product = m * ScaledDetail(in.light->colour[0](x, y) - filtered, scale);
        square = m * m;
      }
      measured->colour[0](x, y) = product;
      measured->colour[1](x, y) = square;
      measured->variance(x, y) = 0;
    }
  }
}

void RestoreDetail(const FilterPlanes& sums, const FilterPlanes& mean, const Image1& variance,
                   const Image1& valid, LumaImage3* filtered) {
  for (int y = 0; y < valid.height(); ++y) {
    for (int x = 0; x < valid.width(); ++x) {
      if (!(valid(x, y) > 0)) {
        continue;
      }
      const float scale = DetailScale((*filtered)[0](x, y), variance(x, y));
      const float noise = mean.variance(x, y) / (scale * scale);
      const float share = DetailShare(sums.colour[0](x, y), sums.colour[1](x, y), noise);
      for (int c = 0; c < 3; ++c) {
        float& light = (*filtered)[c](x, y);
        light = max(light + share * mean.colour[c](x, y), 0.0f);
      }
    }
  }
}

void AccumulateResidual(const DetailInput& in, const RestoreDetailParameters& p,
                        SignalHistory* residual) {
  for (int y = 0; y < residual->length.height(); ++y) {
    for (int x = 0; x < residual->length.width(); ++x) {
      const float samples = in.light->samples(x, y);
      if (!(samples > 0)) {
        continue;
      }
      float& length = residual->length(x, y);
      length = min(length + samples, kMostResidualSamples);
      const float alpha = ResidualAlpha(samples, length, p.alpha_min);
      for (int c = 0; c < 3; ++c) {
        float& mean = residual->colour[c](x, y);
        mean += alpha * (in.light->colour[c](x, y) - (*in.filtered)[c](x, y) - mean);
      }
    }
  }
}

}  // namespace stillray::reference
