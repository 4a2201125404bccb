// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/draw_numbers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/draw_numbers.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace stillray::render {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using DU = hn::CappedTag<uint32_t, 16>;
using VU = hn::Vec<DU>;

HWY_INLINE VU Constant(uint32_t value) {
  return hn::Set(DU(), value);
}

// Vector versions of the functions in core/random_shared.h and sampler_shared.h.

HWY_INLINE VU ReverseBits(VU x) {
  const auto swap = [](VU v, uint32_t mask, auto shift) HWY_ATTR {
    const VU m = Constant(mask);
    return hn::Or(hn::ShiftLeft<shift()>(hn::And(v, m)), hn::And(hn::ShiftRight<shift()>(v), m));
  };
  x = swap(x, 0x55555555u, std::integral_constant<int, 1>());
  x = swap(x, 0x33333333u, std::integral_constant<int, 2>());
  x = swap(x, 0x0f0f0f0fu, std::integral_constant<int, 4>());
  x = swap(x, 0x00ff00ffu, std::integral_constant<int, 8>());
  return hn::Or(hn::ShiftLeft<16>(x), hn::ShiftRight<16>(x));
}

HWY_INLINE VU HashU32(VU x) {
  x = hn::Xor(x, hn::ShiftRight<16>(x));
  x = hn::Mul(x, Constant(0x7feb352du));
  x = hn::Xor(x, hn::ShiftRight<15>(x));
  x = hn::Mul(x, Constant(0x846ca68bu));
  return hn::Xor(x, hn::ShiftRight<16>(x));
}

/// HashCombine(a, b), given HashU32(b).
HWY_INLINE VU HashCombine(VU a, VU mixed_b) {
  const VU shifted = hn::Add(hn::ShiftLeft<6>(a), hn::ShiftRight<2>(a));
  return HashU32(hn::Xor(a, hn::Add(hn::Add(mixed_b, Constant(0x9e3779b9u)), shifted)));
}

HWY_INLINE VU ScrambleReversed(VU x, VU seed) {
  x = hn::Xor(x, hn::Mul(x, Constant(0x3d20adeau)));
  x = hn::Add(x, seed);
  x = hn::Mul(x, hn::Or(hn::ShiftRight<16>(seed), Constant(1u)));
  x = hn::Xor(x, hn::Mul(x, Constant(0x05526c56u)));
  return hn::Xor(x, hn::Mul(x, Constant(0x53a22864u)));
}

/// One coordinate of the point, scrambled; `dimension` from 0.
HWY_INLINE void StoreScrambled(VU reversed, VU set_seed, uint32_t dimension, float* out) {
  const hn::RebindToSigned<DU> di;
  const hn::RebindToFloat<DU> df;
  const VU seed = HashCombine(set_seed, Constant(stillray::HashU32(dimension + 1u)));
  const VU bits = hn::ShiftRight<8>(ReverseBits(ScrambleReversed(reversed, seed)));
  const auto whole = hn::ConvertTo(df, hn::BitCast(di, bits));  // 24 bits: exact
  hn::Store(hn::Mul(whole, hn::Set(df, 1.0f / 16777216.0f)), df, out);
}

template <int kBits>
HWY_INLINE VU ShuffledIndex(VU index, VU seed) {
  const VU mask = Constant((1u << kBits) - 1u);
  return hn::And(ReverseBits(ScrambleReversed(ReverseBits(hn::And(index, mask)), seed)), mask);
}

HWY_INLINE VU BlockIndex(VU position, VU index, VU seed) {
  const VU low = ShuffledIndex<kBlockBits>(
      position, HashCombine(seed, Constant(stillray::HashU32(kShufflePositions))));
  const VU high = ShuffledIndex<kBlockSampleBits>(
      index, HashCombine(seed, Constant(stillray::HashU32(kShuffleSamples))));
  return hn::Or(low, hn::ShiftLeft<kBlockBits>(high));
}

/// Coordinates `kFirst` to `kFirst` + 3 of each point, scrambled.
template <int kFirst>
HWY_INLINE void StorePoints(VU index, VU set_seed, int i, NumberBatch* numbers) {
  const DU d;
  VU point[4] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  VU rest = index;
  for (int bit = 0; bit < kSobolBits; ++bit) {
    const VU on = hn::Sub(hn::Zero(d), hn::And(rest, Constant(1u)));
    rest = hn::ShiftRight<1>(rest);
    for (int k = 0; k < 4; ++k) {
      const uint32_t direction = kSobolDirections[kSobolDimensions * bit + kFirst + k];
      point[k] = hn::Xor(point[k], hn::And(on, Constant(direction)));
    }
  }
  for (int k = 0; k < 4; ++k) {
    StoreScrambled(point[k], set_seed, static_cast<uint32_t>(k), numbers->u[k] + i);
  }
}

/// Arrays are padded to whole vectors: lanes behind the last path are computed, but not used.
void DrawSobol(const SamplerBatch& samplers, uint32_t offset, NumberBatch* numbers) {
  const DU d;
  for (int i = 0; i < samplers.count; i += static_cast<int>(hn::Lanes(d))) {
    const VU set = hn::Add(hn::Load(d, samplers.set + i), Constant(offset));
    const VU set_seed = HashCombine(hn::Load(d, samplers.seed + i), HashU32(set));
    const VU index = ShuffledIndex<kSobolBits>(hn::Load(d, samplers.index + i), set_seed);
    StorePoints<0>(index, set_seed, i, numbers);
  }
}

void DrawBlockSobol(const SamplerBatch& samplers, uint32_t offset, NumberBatch* numbers) {
  const DU d;
  for (int i = 0; i < samplers.count; i += static_cast<int>(hn::Lanes(d))) {
    const VU set = hn::Add(hn::Load(d, samplers.set + i), Constant(offset));
    const VU seed = hn::Load(d, samplers.seed + i);
    const VU set_seed = HashCombine(hn::ShiftRight<kBlockBits>(seed), HashU32(set));
    const VU position = hn::And(seed, Constant(kBlockMask));
    const VU index = BlockIndex(position, hn::Load(d, samplers.index + i), set_seed);
    StorePoints<kBlockFirstDimension>(index, set_seed, i, numbers);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray::render
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::render {

HWY_EXPORT(DrawSobol);
HWY_EXPORT(DrawBlockSobol);

void DrawNumbers(const SamplerBatch& samplers, uint32_t offset, NumberBatch* numbers) {
  if (samplers.kind == SamplerKind::kSobol) {
    HWY_DYNAMIC_DISPATCH(DrawSobol)(samplers, offset, numbers);
    return;
  }
  if (samplers.kind == SamplerKind::kZSobol) {
    HWY_DYNAMIC_DISPATCH(DrawBlockSobol)(samplers, offset, numbers);
    return;
  }
  for (int i = 0; i < samplers.count; ++i) {
    const PathSampler sampler{samplers.kind, samplers.index[i], samplers.seed[i]};
    const vec4 u = sampler.Get(samplers.set[i] + offset);
    for (int k = 0; k < 4; ++k) {
      numbers->u[k][i] = u[k];
    }
  }
}

}  // namespace stillray::render
#endif
