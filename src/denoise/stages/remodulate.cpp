// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/remodulate.h"

#include <atomic>

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/simd/picture_parts.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/remodulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// The factor of a channel of a signal.
HWY_INLINE VF AlbedoFactor(const AlbedoSum& albedo, int c, int x, int y) {
  const DF d;
  VF factor = hn::Set(d, 1.0f);
  if (albedo.count > 0) {
    factor = hn::LoadU(d, (*albedo.part[0])[c].Row(y) + x);
    for (int i = 1; i < albedo.count; ++i) {
      factor = hn::Add(factor, hn::LoadU(d, (*albedo.part[i])[c].Row(y) + x));
    }
    factor = hn::IfThenElse(IsFiniteLane(factor), hn::Max(factor, hn::Set(d, kAlbedoFloor)),
                            hn::Set(d, 1.0f));
  }
  return factor;
}

/// Adds the radiance of a signal.
HWY_INLINE void AddRadiance(const SignalLight& signal, bool rec601, int x, int y, VF sum[3]) {
  const DF d;
  const LumaImage3& light = *signal.light;
  const AlbedoSum& albedo = signal.albedo;
  const int channel = albedo.channel;
  if (channel >= 0) {
    const VF value = hn::LoadU(d, light[0].Row(y) + x);
    for (int c = 0; c < 3;
         ++c) {  // a constant index, since a variable one would keep sums in memory
      sum[c] = c == channel ? hn::MulAdd(value, AlbedoFactor(albedo, c, x, y), sum[c]) : sum[c];
    }
    return;
  }
  const VF r = hn::LoadU(d, light[1].Row(y) + x);
  const VF b = hn::LoadU(d, light[2].Row(y) + x);
  const VF rgb[3] = {r, Green(hn::LoadU(d, light[0].Row(y) + x), r, b, rec601), b};
  for (int c = 0; c < 3; ++c) {
    sum[c] = hn::MulAdd(rgb[c], AlbedoFactor(albedo, c, x, y), sum[c]);
  }
}

/// \tparam kAtOnce  the output is read immediately, and should stay in the caches
/// \param next      rows to prefetch
/// \param to        [out] the row of the image
template <bool kAtOnce>
HWY_INLINE int64_t RowInto(const PictureParts& parts, const NextRow<64>& next, int width, int y,
                           float* const to[3]) {
  const DF d;
  int64_t bad = 0;
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    VF sum[3];
    for (int c = 0; c < 3; ++c) {
      sum[c] = parts.remodulate.add ? hn::LoadU(d, to[c] + x) : hn::Zero(d);
    }
    for (const SignalLight& signal : parts.signals) {
      AddRadiance(signal, parts.remodulate.luminance_rec601, x, y, sum);
    }
    for (const Image3* image : parts.unfiltered) {
      VF in[3];
      MF finite = InRow(x, width);
      for (int c = 0; c < 3; ++c) {
        in[c] = hn::LoadU(d, (*image)[c].Row(y) + x);
        finite = hn::And(finite, IsFiniteLane(in[c]));
      }
      for (int c = 0; c < 3; ++c) {
        sum[c] = hn::Add(sum[c], hn::IfThenElseZero(finite, in[c]));
      }
      bad += static_cast<int64_t>(hn::CountTrue(d, hn::AndNot(finite, InRow(x, width))));
    }
    for (int c = 0; c < 3; ++c) {
      const VF most = hn::Set(d, kMostPicture);
      const VF v = hn::Min(hn::Max(sum[c], hn::Neg(most)), most);
      kAtOnce ? StoreInRow(d, v, to[c], x, width) : StreamInRow(d, v, to[c], x, width);
    }
  }
  return bad;
}

int64_t WholeRows(const PictureParts& parts, int y0, int y1, Image3* picture) {
  int64_t bad = 0;
  for (int y = y0; y < y1; ++y) {
    NextRow<64> next;
    AddPictureParts(parts, y + 1, &next);
    AddStreamed(*picture, y + 1, &next);
    float* const to[3] = {(*picture)[0].Row(y), (*picture)[1].Row(y), (*picture)[2].Row(y)};
    bad += RowInto<false>(parts, next, picture->width(), y, to);
  }
  FinishStreams();
  return bad;
}

int64_t RowAtOnce(const PictureParts& parts, int width, int y, float* const to[3]) {
  return RowInto<true>(parts, {}, width, y, to);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(WholeRows);
HWY_EXPORT(RowAtOnce);

int64_t Remodulate(std::span<const SignalLight> signals, std::span<const Image3* const> unfiltered,
                   const RemodulateParameters& p, Image3* picture) {
  const PictureParts parts = {signals, unfiltered, p};
  std::atomic<int64_t> bad = 0;
  ParallelRows(picture->height(), 32, [&](int y0, int y1) {
    bad += HWY_DYNAMIC_DISPATCH(WholeRows)(parts, y0, y1, picture);
  });
  return bad;
}

int64_t RemodulateRow(const PictureParts& parts, int width, int y, float* const to[3]) {
  return HWY_DYNAMIC_DISPATCH(RowAtOnce)(parts, width, y, to);
}

}  // namespace stillray::cpu
#endif
