// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/keep_mirrors.h"

#include "core/parallel.h"
#include "denoise/stages/keep_mirrors_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/keep_mirrors.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Marks mirrors, and stores the luminance of their samples in a plane with a border, for access by
/// neighbours.
void FindMirrorRows(const KeepMirrorsInput& in, float mirror_roughness, int y0, int y1,
                    FilterPlanes* measured, Image1* valid) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF limit = hn::Set(d, mirror_roughness);
  const int width = in.light->samples.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const VF roughness = hn::LoadU(d, in.roughness->Row(y) + x);
      const MF surface = hn::And(hn::Gt(hn::LoadU(d, in.guides->inverse_depth.Row(y) + x), zero),
                                 hn::Gt(hn::LoadU(d, in.light->samples.Row(y) + x), zero));
      const MF mirror =
          hn::And(surface, hn::And(hn::Ge(roughness, zero), hn::Le(roughness, limit)));
      StoreInRow(d, hn::IfThenElseZero(mirror, hn::Set(d, 1.0f)), valid->Row(y), x, width);
      StoreInRow(d, hn::LoadU(d, in.light->colour[0].Row(y) + x), measured->colour[2].Row(y), x,
                 width);
    }
  }
}

/// See NoiseOfNearest.
HWY_INLINE VF NoiseAt(const Image1& luminance, const Image1& valid, int x, int y, VF scale) {
  const DF d;
  const VF none = hn::Set(d, kNoNeighbour);
  const VF own = hn::LoadU(d, luminance.Row(y) + x);
  VF first = none;
  VF second = none;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) {
        continue;
      }
      const VF difference = hn::Sub(own, hn::LoadU(d, luminance.Row(y + dy) + x + dx));
      const MF there = hn::Gt(hn::LoadU(d, valid.Row(y + dy) + x + dx), hn::Zero(d));
      const VF square = hn::IfThenElse(there, hn::Mul(difference, difference), none);
      second = hn::Min(second, hn::Max(first, square));
      first = hn::Min(first, square);
    }
  }
  const VF noise = hn::Mul(scale, hn::Mul(hn::Set(d, 0.5f), hn::Add(first, second)));
  return hn::IfThenElseZero(hn::Lt(second, none), noise);
}

HWY_INLINE VF NoiseScale(const Image2* motion, int x, int y) {
  const DF d;
  const VF moving = hn::Set(d, kNearestNoise);
  if (motion == nullptr) {
    return moving;
  }
  const VF most = hn::Set(d, kStillMotion);
  const MF still = hn::And(hn::Lt(hn::Abs(hn::LoadU(d, (*motion)[0].Row(y) + x)), most),
                           hn::Lt(hn::Abs(hn::LoadU(d, (*motion)[1].Row(y) + x)), most));
  return hn::IfThenElse(still, hn::Set(d, kStillNoise * kNearestNoise), moving);
}

void MeasureMirrorRows(const KeepMirrorsInput& in, const Image1& valid, int y0, int y1,
                       FilterPlanes* measured) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = valid.width();
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF mirror = hn::Gt(hn::LoadU(d, valid.Row(y) + x), zero);
      VF square = zero;
      VF noise = zero;
      if (!hn::AllFalse(d, mirror)) {
        const VF difference = hn::Sub(hn::LoadU(d, in.light->colour[0].Row(y) + x),
                                      hn::LoadU(d, (*in.filtered)[0].Row(y) + x));
        square = hn::IfThenElseZero(mirror, hn::Mul(difference, difference));
        noise = hn::IfThenElseZero(
            mirror, NoiseAt(measured->colour[2], valid, x, y, NoiseScale(in.motion, x, y)));
      }
      StoreInRow(d, square, measured->colour[0].Row(y), x, width);
      StoreInRow(d, noise, measured->colour[1].Row(y), x, width);
      StoreInRow(d, zero, measured->variance.Row(y), x, width);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(FindMirrorRows);
HWY_EXPORT(MeasureMirrorRows);

void MeasureMirrors(const KeepMirrorsInput& in, const KeepMirrorsParameters& p,
                    FilterPlanes* measured, Image1* valid) {
  ParallelRows(valid->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FindMirrorRows)(in, p.mirror_roughness, y0, y1, measured, valid);
  });
  ParallelRows(valid->height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(MeasureMirrorRows)(in, *valid, y0, y1, measured);
  });
}

}  // namespace stillray::cpu
#endif
