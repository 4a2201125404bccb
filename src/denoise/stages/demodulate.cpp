// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/demodulate.h"

#include "core/colour_shared.h"
#include "core/parallel.h"
#include "denoise/simd/picture_parts.h"
#include "denoise/stages/demodulate_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/demodulate.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

struct Colour {
  VF r, g, b;
};

HWY_INLINE Colour LoadColour(const Image3& image, int x, int y) {
  const DF d;
  return {hn::LoadU(d, image[0].Row(y) + x), hn::LoadU(d, image[1].Row(y) + x),
          hn::LoadU(d, image[2].Row(y) + x)};
}

HWY_INLINE VF ChannelOf(const Colour& c, int channel) {
  return channel == 0 ? c.r : channel == 1 ? c.g : c.b;
}

HWY_INLINE MF IsFiniteColour(const Colour& c) {
  return hn::And(IsFiniteLane(c.r), hn::And(IsFiniteLane(c.g), IsFiniteLane(c.b)));
}

HWY_INLINE Colour DivideByAlbedo(const Colour& light, const Colour& albedo) {
  const VF least = hn::Set(DF(), kAlbedoFloor);
  return {hn::Div(light.r, hn::Max(albedo.r, least)), hn::Div(light.g, hn::Max(albedo.g, least)),
          hn::Div(light.b, hn::Max(albedo.b, least))};
}

HWY_INLINE VF ChannelDeviation(VF mean, VF mean_luminance, VF own, VF albedo) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF least = hn::Set(d, kAlbedoFloor);
  const MF lit = hn::Gt(mean_luminance, zero);
  const VF divisor = hn::IfThenElse(lit, mean_luminance, hn::Set(d, 1.0f));
  const VF hue = hn::IfThenElseZero(lit, hn::Div(hn::Max(mean, zero), divisor));
  return hn::Div(hn::Mul(hue, hn::Max(own, least)), hn::Max(albedo, least));
}

HWY_INLINE VF WithinVariance(const DemodulateInput& in, int x, int y, const Colour& albedo) {
  const DF d;
  const VF least = hn::Set(d, kAlbedoFloor);
  const VF signal = hn::Max(Luminance(albedo.r, albedo.g, albedo.b, false), least);
  VF sum = hn::Zero(d);
  for (int i = 0; i < in.count; ++i) {
    if (in.second_moment[i] == nullptr) {
      continue;
    }
    const VF one = hn::Set(d, 1.0f);
    const Colour own =
        in.own_albedo[i] != nullptr ? LoadColour(*in.own_albedo[i], x, y) : Colour{one, one, one};
    const Colour light = DivideByAlbedo(LoadColour(*in.radiance[i], x, y), own);
    const VF mean = Luminance(light.r, light.g, light.b, false);
    VF ratio = hn::Div(hn::Max(Luminance(own.r, own.g, own.b, false), least), signal);
    if (const int c = in.albedo.channel; c >= 0) {
      ratio = ChannelDeviation(ChannelOf(light, c), mean, ChannelOf(own, c), ChannelOf(albedo, c));
    }
    const VF moment = hn::LoadU(d, in.second_moment[i]->Row(y) + x);
    const VF variance = hn::Max(hn::NegMulAdd(mean, mean, moment), hn::Zero(d));
    sum = hn::MulAdd(variance, hn::Mul(ratio, ratio), sum);
  }
  return hn::IfThenElseZero(IsFiniteLane(sum), sum);
}

/// \param next    rows to prefetch
/// \param sparse  few pixels have a sample: radiance of vectors without samples is not read
DemodulateCounts DemodulateRow(const DemodulateInput& in, const NextRow<40>& next, bool sparse,
                               int y, NewLight* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const bool divide = in.albedo.count > 0;
  const int width = out->samples.width();
  float* const colour[3] = {out->colour[0].Row(y), out->colour[1].Row(y), out->colour[2].Row(y)};
  float* const samples = out->samples.Row(y);
  const auto store = [&](VF v, float* to, int x) HWY_ATTR { StreamInRow(d, v, to, x, width); };
  DemodulateCounts counts;
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    const MF in_row = InRow(x, width);
    if (sparse && NoSamples(*in.samples, x, y)) {
      for (int c = 0; c < 3; ++c) {
        store(zero, colour[c], x);
      }
      store(zero, samples, x);
      if (!out->within.empty()) {
        store(zero, out->within.Row(y), x);
      }
      continue;
    }
    Colour sum = {zero, zero, zero};
    MF finite = in_row;
    VF least = zero;
    for (int i = 0; i < in.count; ++i) {
      const Colour light = LoadColour(*in.radiance[i], x, y);
      finite = hn::And(finite, IsFiniteColour(light));
      least = hn::Min(least, hn::Min(light.r, hn::Min(light.g, light.b)));
      sum = {hn::Add(sum.r, hn::Max(light.r, zero)), hn::Add(sum.g, hn::Max(light.g, zero)),
             hn::Add(sum.b, hn::Max(light.b, zero))};
    }
    Colour albedo = {one, one, one};
    if (divide) {
      albedo = LoadColour(*in.albedo.part[0], x, y);
      for (int i = 1; i < in.albedo.count; ++i) {
        const Colour more = LoadColour(*in.albedo.part[i], x, y);
        albedo = {hn::Add(albedo.r, more.r), hn::Add(albedo.g, more.g), hn::Add(albedo.b, more.b)};
      }
      sum = DivideByAlbedo(sum, albedo);
      finite = hn::And(finite, IsFiniteColour(albedo));
    }
    finite = hn::And(finite, IsFiniteColour(sum));
    const MF negative = hn::Lt(least, hn::Set(d, -in.negative_limit));
    const VF given = in.samples != nullptr ? hn::LoadU(d, in.samples->Row(y) + x) : one;
    const MF sampled = hn::And(hn::Gt(given, zero), in_row);
    const MF received = hn::And(sampled, IsFiniteLane(given));
    const MF usable = hn::And(hn::AndNot(negative, finite), received);
    counts.non_finite += static_cast<int64_t>(hn::CountTrue(d, hn::AndNot(finite, sampled)));
    counts.negative +=
        static_cast<int64_t>(hn::CountTrue(d, hn::And(hn::And(finite, negative), sampled)));
    VF luminance = Luminance(sum.r, sum.g, sum.b, in.luminance_rec601);
    if (in.albedo.channel >= 0) {
      luminance = ChannelOf(sum, in.albedo.channel);
      sum = {luminance, luminance, luminance};
    }
    store(hn::IfThenElseZero(usable, luminance), colour[0], x);
    store(hn::IfThenElseZero(usable, sum.r), colour[1], x);
    store(hn::IfThenElseZero(usable, sum.b), colour[2], x);
    store(hn::IfThenElseZero(usable, given), samples, x);
    if (!out->within.empty()) {
      store(hn::IfThenElseZero(usable, WithinVariance(in, x, y, albedo)), out->within.Row(y), x);
    }
  }
  return counts;
}

bool IsSparseInput(const DemodulateInput& in, int y) {
  return in.samples != nullptr && IsSparseRow(in.samples->Row(y), in.samples->width());
}

DemodulateCounts DemodulateRows(const DemodulateInput& in, int y0, int y1, NewLight* out) {
  DemodulateCounts counts;
  for (int y = y0; y < y1; ++y) {
    const bool sparse = IsSparseInput(in, y);
    NextRow<40> next;
    if (!sparse) {
      AddRadiance(in, y + 1, &next);
    }
    AddStreamed(out->colour, y + 1, &next);
    AddStreamed(out->samples, y + 1, &next);
    counts += DemodulateRow(in, next, sparse, y, out);
  }
  FinishStreams();
  return counts;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(DemodulateRows);

DemodulateCounts Demodulate(const DemodulateInput& in, NewLight* out) {
  DemodulateTotal total;
  ParallelRows(out->samples.height(), 32, [&](int y0, int y1) {
    total.Add(HWY_DYNAMIC_DISPATCH(DemodulateRows)(in, y0, y1, out));
  });
  return total.Sum();
}

}  // namespace stillray::cpu
#endif
