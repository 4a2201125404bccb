// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Sample sequences: padded sets of four dimensions, decorrelated by hashing.
//  - Z-order Sobol': blocks of 8x8 pixels share a sequence, which stratifies the samples averaged
//    by a filter across pixels, after Ahmed and Wonka (2020), "Screen-Space Blue-Noise Diffusion
//    of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels". The
//    low bits of a point's index are the pixel's position in Morton order, the high ones the number
//    of the sample. Hence any aligned 2^k x 2^k or 2^k x 2^(k+1) pixels of a frame have successive
//    points, and a pixel's samples over time form an elementary interval of the sequence's first
//    dimension, stratified in the other dimensions (Gruenschloss, Raab, Keller 2012, "Enumerating
//    Quasi-Monte Carlo Point Sequences in Elementary Intervals").
//  - Sobol': the first four dimensions with the direction numbers of Joe and Kuo (2008), shuffled
//    and Owen-scrambled per pixel and set after Burley (2020), "Practical Hash-based Owen
//    Scrambling". Within a set, dimensions 0 and 1 form a (0,2)-sequence: use them for the most
//    important pair.
//  - Halton: cycles of 16 points, as in SVGF (section 3), rotated per pixel and cycle (Cranley
//    and Patterson 1976).
#ifndef STILLRAY_RENDER_SAMPLER_SHARED_H
#define STILLRAY_RENDER_SAMPLER_SHARED_H

#ifdef __cplusplus
#include "render/shared.h"
#endif
#include "core/random_shared.h"

STILLRAY_RENDER_BEGIN

// log2 of the length of one Sobol' sequence; higher sample numbers change the seed.
const int kSobolBits = 16;

// Direction numbers of dimensions 0..5 for bit 0 of the index, then for bit 1, ... Bit-reversed
// (least significant bit first), so that the scramble needs no bit reversal.
const int kSobolDimensions = 6;
const uint kSobolDirections[96] = {
    0x00000001u, 0x00000001u, 0x00000001u, 0x00000001u, 0x00000001u, 0x00000001u,  //
    0x00000002u, 0x00000003u, 0x00000003u, 0x00000003u, 0x00000002u, 0x00000002u,  //
    0x00000004u, 0x00000005u, 0x00000006u, 0x00000004u, 0x00000004u, 0x00000006u,  //
    0x00000008u, 0x0000000fu, 0x00000009u, 0x0000000au, 0x0000000du, 0x0000000cu,  //
    0x00000010u, 0x00000011u, 0x00000017u, 0x0000001fu, 0x0000001fu, 0x00000013u,  //
    0x00000020u, 0x00000033u, 0x0000003au, 0x0000002eu, 0x0000003bu, 0x00000024u,  //
    0x00000040u, 0x00000055u, 0x00000071u, 0x00000045u, 0x0000005eu, 0x0000006au,  //
    0x00000080u, 0x000000ffu, 0x000000a3u, 0x000000c9u, 0x000000b9u, 0x000000dfu,  //
    0x00000100u, 0x00000101u, 0x00000116u, 0x0000011bu, 0x0000015au, 0x00000107u,  //
    0x00000200u, 0x00000303u, 0x00000339u, 0x000002a4u, 0x000003f4u, 0x0000020eu,  //
    0x00000400u, 0x00000505u, 0x00000677u, 0x0000079au, 0x00000685u, 0x00000615u,  //
    0x00000800u, 0x00000f0fu, 0x000009aau, 0x00000b67u, 0x00000d0fu, 0x00000c28u,  //
    0x00001000u, 0x00001111u, 0x00001601u, 0x0000101eu, 0x0000115bu, 0x00001379u,  //
    0x00002000u, 0x00003333u, 0x00003903u, 0x0000302du, 0x000023f6u, 0x000024fbu,  //
    0x00004000u, 0x00005555u, 0x00007706u, 0x00004041u, 0x00004681u, 0x00006b6du,  //
    0x00008000u, 0x0000ffffu, 0x0000aa09u, 0x0000a0c3u, 0x0000dd02u, 0x0000ddd1u,  //
};

SHARED_FN uint ReverseBits(uint x) {
  x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
  x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
  x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
  return (x << 16) | (x >> 16);
}

// Owen scrambling of a fraction whose bits are reversed (most significant first at bit 0): every
// step makes a bit depend on lower bits only. Laine and Karras (2011), "Stratified sampling for
// stochastic transparency", with the better-mixing constants published by N. Vegdahl (2021).
SHARED_FN uint ScrambleReversed(uint x, uint seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

// Coordinates `first` to `first` + 3 of point `index` (< 2^kSobolBits), as bit-reversed 32-bit
// fractions.
SHARED_FN uvec4 SobolReversed(uint index, int first) {
  uvec4 point = uvec4(0u);
  for (int bit = 0; bit < kSobolBits; ++bit) {
    uint mask = 0u - ((index >> bit) & 1u);
    int d = kSobolDimensions * bit + first;
    point.x ^= mask & kSobolDirections[d];
    point.y ^= mask & kSobolDirections[d + 1];
    point.z ^= mask & kSobolDirections[d + 2];
    point.w ^= mask & kSobolDirections[d + 3];
  }
  return point;
}

// Converts the top 24 bits to [0, 1) exactly.
SHARED_FN float FractionToFloat(uint bits) {
  return float(bits >> 8) * (1.0f / 16777216.0f);
}

// Permutes the index, of `bits` bits, by the seed. Aligned blocks of 2^k indices map to aligned
// blocks.
SHARED_FN uint ShuffledIndex(uint index, uint seed, int bits) {
  uint mask = (1u << bits) - 1u;
  return ReverseBits(ScrambleReversed(ReverseBits(index & mask), seed)) & mask;
}

// Owen-scrambles the coordinates of a point of SobolReversed.
SHARED_FN vec4 ScramblePoint(uvec4 point, uint seed) {
  return vec4(FractionToFloat(ReverseBits(ScrambleReversed(point.x, HashCombine(seed, 1u)))),
              FractionToFloat(ReverseBits(ScrambleReversed(point.y, HashCombine(seed, 2u)))),
              FractionToFloat(ReverseBits(ScrambleReversed(point.z, HashCombine(seed, 3u)))),
              FractionToFloat(ReverseBits(ScrambleReversed(point.w, HashCombine(seed, 4u)))));
}

// Point `index` of the sequence, shuffled and scrambled by `seed`.
SHARED_FN vec4 SobolSample(uint index, uint seed) {
  return ScramblePoint(SobolReversed(ShuffledIndex(index, seed, kSobolBits), 0), seed);
}

// Z-order Sobol': number of bits of a pixel's coordinate in its block, of its position and of the
// sample index.
const int kBlockSideBits = 3;
const int kBlockBits = 2 * kBlockSideBits;
const int kBlockSampleBits = kSobolBits - kBlockBits;
const uint kBlockMask = (1u << kBlockBits) - 1u;
// Hash keys for shuffling positions and samples with the seed of a set; ScramblePoint uses 1 to 4.
const uint kShufflePositions = 5u;
const uint kShuffleSamples = 6u;
// First of the four dimensions in use. Dimension 0 of the sequence distributes the points over the
// pixels; these four of the later dimensions have the least error in static and moving views
// (docs/scenes.md).
const int kBlockFirstDimension = 2;

// Morton code of a pixel within its block.
SHARED_FN uint BlockPosition(uint x, uint y) {
  uint position = 0u;
  for (int bit = 0; bit < kBlockSideBits; ++bit) {
    position |= (((x >> bit) & 1u) | (((y >> bit) & 1u) << 1)) << (2 * bit);
  }
  return position;
}

// Sequence index of sample `index` (< 2^kBlockSampleBits) at this position of a block. Position and
// sample index are shuffled separately, so that all points of a position stay in one elementary
// interval.
SHARED_FN uint BlockIndex(uint position, uint index, uint seed) {
  return ShuffledIndex(position, HashCombine(seed, kShufflePositions), kBlockBits) |
         (ShuffledIndex(index, HashCombine(seed, kShuffleSamples), kBlockSampleBits) << kBlockBits);
}

// Sample `index` of the pixel at this position of the block whose sequence has this seed.
SHARED_FN vec4 BlockSobolSample(uint position, uint index, uint seed) {
  return ScramblePoint(SobolReversed(BlockIndex(position, index, seed), kBlockFirstDimension),
                       seed);
}

// Radical inverse: the digits of `index` in `base`, mirrored at the radix point, in [0, 1).
SHARED_FN float RadicalInverse(uint index, uint base) {
  float inverse_base = 1.0f / float(base);
  float digit_weight = inverse_base;
  float value = 0.0f;
  while (index > 0u) {
    uint next = index / base;
    value += float(index - next * base) * digit_weight;
    digit_weight *= inverse_base;
    index = next;
  }
  return min(value, 0.99999994f);
}

const uint kHaltonPeriod = 16u;

// Point index % 16 of the Halton sequence (bases 2, 3, 5, 7; numbered from 1), rotated by `seed`.
// `order` shuffles the cycle so that two sets of dimensions have different points.
SHARED_FN vec4 HaltonSample(uint index, uint seed, uint order) {
  uint i = ((index ^ order) & (kHaltonPeriod - 1u)) + 1u;
  vec4 point = vec4(RadicalInverse(i, 2u), RadicalInverse(i, 3u), RadicalInverse(i, 5u),
                    RadicalInverse(i, 7u));
  vec4 shift = vec4(FractionToFloat(HashCombine(seed, 1u)), FractionToFloat(HashCombine(seed, 2u)),
                    FractionToFloat(HashCombine(seed, 3u)), FractionToFloat(HashCombine(seed, 4u)));
  return min(fract(point + shift), vec4(0.99999994f));
}

// Values of SamplerKind.
const uint kSamplerSobol = 0u;
const uint kSamplerHalton16 = 1u;
const uint kSamplerZSobol = 2u;

// Sets of four dimensions used by a path: one for the primary ray, two per ray, then one for the
// point on the lens and one per ray in a scattering medium.
const uint kPrimaryDimensions = 0u;
const uint kLensDimensions = 0x10000u;
SHARED_FN uint ScatterDimensions(int surface) {
  return 1u + 2u * uint(surface);
}
SHARED_FN uint LightDimensions(int surface) {
  return 2u + 2u * uint(surface);
}
SHARED_FN uint MediumDimensions(int step) {
  return 0x20000u + uint(step);
}

// The seed of a pixel or block. `stream_seed` is common to all pixels: HashCombine of the two
// halves of the renderer's seed and the stream. `window`: number of the sequence of 2^kSobolBits or
// 2^kBlockSampleBits samples, or of the cycle of kHaltonPeriod; window 0 does not change the seed.
SHARED_FN uint PixelSeed(uint stream_seed, uint x, uint y, uint window_low, uint window_high) {
  uint h = HashCombine(HashCombine(stream_seed, x), y);
  if ((window_low | window_high) != 0u) {
    h = HashCombine(HashCombine(h, window_low), window_high);
  }
  return h;
}

// The seed of a pixel's sequence: PixelSeed of the pixel, or PixelSeed of its block with the
// pixel's position in the lowest bits.
SHARED_FN uint SamplerSeed(uint kind, uint stream_seed, uint x, uint y, uint window_low,
                           uint window_high) {
  if (kind != kSamplerZSobol) {
    return PixelSeed(stream_seed, x, y, window_low, window_high);
  }
  uint block =
      PixelSeed(stream_seed, x >> kBlockSideBits, y >> kBlockSideBits, window_low, window_high);
  return (block & ~kBlockMask) | BlockPosition(x, y);
}

// The position and block parts of SamplerSeed.
SHARED_FN uint PositionOfSeed(uint seed) {
  return seed & kBlockMask;
}
SHARED_FN uint BlockOfSeed(uint seed) {
  return seed >> kBlockBits;
}

// Four numbers in [0, 1) for sample `index` of the sequence of `seed`.
// \param set  kPrimaryDimensions, kLensDimensions, ScatterDimensions() or LightDimensions()
SHARED_FN vec4 PathNumbers(uint kind, uint index, uint seed, uint set) {
  if (kind == kSamplerZSobol) {
    return BlockSobolSample(PositionOfSeed(seed), index, HashCombine(BlockOfSeed(seed), set));
  }
  uint set_seed = HashCombine(seed, set);
  return kind == kSamplerSobol ? SobolSample(index, set_seed)
                               : HaltonSample(index, set_seed, HashU32(set));
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_SAMPLER_SHARED_H
