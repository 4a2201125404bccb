// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/keep_mirrors.h"

#include "denoise/stages/keep_mirrors_shared.h"

namespace stillray::reference {
namespace {

bool IsMirrorAt(const KeepMirrorsInput& in, const KeepMirrorsParameters& p, int x, int y) {
  const Image1& samples = in.light->samples;
  return x >= 0 && y >= 0 && x < samples.width() && y < samples.height() &&
         IsMirror(in.guides->inverse_depth(x, y), samples(x, y), (*in.roughness)(x, y),
                  p.mirror_roughness);
}

float NoiseScale(const KeepMirrorsInput& in, int x, int y) {
  const bool still = in.motion != nullptr && abs((*in.motion)[0](x, y)) < kStillMotion &&
                     abs((*in.motion)[1](x, y)) < kStillMotion;
  return still ? kStillNoise * kNearestNoise : kNearestNoise;
}

float NoiseAt(const KeepMirrorsInput& in, const KeepMirrorsParameters& p, int x, int y) {
  const Image1& luminance = in.light->colour[0];
  float first = kNoNeighbour;
  float second = kNoNeighbour;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if ((dx != 0 || dy != 0) && IsMirrorAt(in, p, x + dx, y + dy)) {
        const float d = luminance(x, y) - luminance(x + dx, y + dy);
        second = min(second, max(first, d * d));
        first = min(first, d * d);
      }
    }
  }
  return NoiseOfNearest(first, second, NoiseScale(in, x, y));
}

}  // namespace

void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& p,
                    FilterPlanes* measured, Image1* valid) {
  for (int y = 0; y < in.light->samples.height(); ++y) {
    for (int x = 0; x < in.light->samples.width(); ++x) {
      (*valid)(x, y) = IsMirrorAt(in, p, x, y) ? 1.0f : 0.0f;
      if ((*valid)(x, y) > 0) {
        const float d = in.light->colour[0](x, y) - (*in.filtered)[0](x, y);
        measured->colour[0](x, y) = d * d;
        measured->colour[1](x, y) = NoiseAt(in, p, x, y);
        measured->variance(x, y) = 0;
      }
    }
  }
}

}  // namespace stillray::reference
