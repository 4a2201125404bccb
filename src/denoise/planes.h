// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The planes that stages exchange. All planes of a denoiser have one size. The input planes of the
/// wavelet have a border as wide as its largest reach, filled with zeros (no surface, no samples).
#pragma once

#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "denoise/packed_normal.h"
#include "denoise/stages/reproject_shared.h"
#include "stillray/image.h"

namespace stillray {

/// Demodulated radiance: [0] luminance, [1] red, [2] blue. Filters are linear, so that this basis
/// is equivalent to (red, green, blue), and gives the luminance without a computation. Green is
/// Green709 or Green601 of the three. Not convertible to Image3, which is (red, green, blue).
using LumaImage3 = Planes<float, 3, struct LumaRedBlue>;

/// Pixels of a row that share one flag.
inline constexpr int kBlockPixels = 16;

inline int BlocksOf(int width) {
  return (width + kBlockPixels - 1) / kBlockPixels;
}

/// Guides as the filter reads them. Pixels without a usable surface have zeros in all planes;
/// edge-stopping weights towards them are zero.
struct GuidePlanes {
  Image1 inverse_depth;           ///< 1 / view z; on a plane affine in image coordinates, unlike z
  Image1 depth;                   ///< view z
  Image3 normal;                  ///< unit length, or zero; empty with packed_normal
  Plane<uint32_t> packed_normal;  ///< PackNormal of the normals with normals=octahedral, else empty
  Image2 gradient;     ///< change of inverse depth per pixel right and down, on one surface
  Image1 turn2;        ///< SquaredTurn of the normals; empty unless the filter needs it. No border.
  Plane<uint32_t> id;  ///< zero where unknown
  /// For each block of kBlockPixels: 1 if all of its pixels are surfaces; 0 if not, or unknown
  Plane<uint32_t> full;

  GuidePlanes() = default;
  GuidePlanes(int width, int height, int border, bool packs_normals = false)
      : inverse_depth(width, height, border),
        depth(width, height, border),
        normal(packs_normals ? Image3() : Image3(width, height, border)),
        packed_normal(packs_normals ? Plane<uint32_t>(width, height, border) : Plane<uint32_t>()),
        gradient(width, height, border),
        id(width, height, border),
        full(BlocksOf(width), height, 1) {}
  size_t bytes() const {
    return inverse_depth.bytes() + depth.bytes() + normal.bytes() + packed_normal.bytes() +
           gradient.bytes() + id.bytes() + turn2.bytes() + full.bytes();
  }
  bool packs_normals() const { return !packed_normal.empty(); }
};

/// The normal of a pixel: unit length, or zero without a surface.
inline vec3 NormalAt(const GuidePlanes& guides, int x, int y) {
  return guides.packs_normals()
             ? UnpackNormal(guides.packed_normal(x, y))
             : vec3(guides.normal[0](x, y), guides.normal[1](x, y), guides.normal[2](x, y));
}

/// SquaredTurn of a pixel; 0 if the filter does not use it.
inline float Turn2At(const GuidePlanes& guides, int x, int y) {
  return guides.turn2.empty() ? 0.0f : guides.turn2(x, y);
}

/// The albedos whose sum is the divisor of a signal; none: the signal is not divided.
struct AlbedoSum {
  const Image3* part[3] = {};
  int count = 0;
  int channel = -1;  ///< SignalGroup::channel of the signal
};

/// One signal of this frame before accumulation.
struct NewLight {
  LumaImage3 colour;  ///< demodulated
  Image1 samples;     ///< 0 = missing (the colour is then zero)
  Image1 within;  ///< variance of single samples within the pixel; empty at one sample per pixel

  size_t bytes() const { return colour.bytes() + samples.bytes() + within.bytes(); }
};

/// The history of one signal. Moments are those of single samples, stored as mean and variance.
struct SignalHistory {
  LumaImage3 colour;
  Image1 mean;        ///< of the luminance of samples
  Image1 variance;    ///< of the luminance of samples, >= 0
  Image1 length;      ///< accumulated samples; 0 = none yet
  Image1 weights2;    ///< sum of the squared weights of all samples in `colour`, whose variance is
                      ///< variance * weights2
  Image1 compressed;  ///< mean of compressed luminances (limit_history_shared.h), weighted as
                      ///< `colour`; empty unless limit_history runs
  /// `colour` without the last filtered image that was fed back; empty unless feedback is blended
  /// in (PSVGF section 5).
  LumaImage3 behind;
  float compressed_scale = 0;  ///< luminance that is compressed to 1/2; 0: not yet chosen

  /// Border of the planes that the 7x7 variance estimate reads; filled with zeros, so that lengths
  /// are 0.
  static constexpr int kBorder = 3;

  SignalHistory() = default;
  /// \param with_compressed  allocate `compressed`, for limit_history
  /// \param with_behind      allocate `behind`
  /// \param border           of the colour planes, which the wavelet's first level may read in
  ///     place
  SignalHistory(int width, int height, bool with_compressed = false, bool with_behind = false,
                int border = 0)
      : colour(width, height, border),
        mean(width, height, kBorder),
        variance(width, height, kBorder),
        length(width, height, kBorder),
        weights2(width, height),
        compressed(with_compressed ? Image1(width, height) : Image1()),
        behind(with_behind ? LumaImage3(width, height, border) : LumaImage3()) {}
  size_t bytes() const {
    return colour.bytes() + behind.bytes() + mean.bytes() + variance.bytes() + length.bytes() +
           weights2.bytes() + compressed.bytes();
  }
};

/// The filtered signal between wavelet levels, and its variance.
struct FilterPlanes {
  LumaImage3 colour;
  Image1 variance;

  FilterPlanes() = default;
  FilterPlanes(int width, int height, int border)
      : colour(width, height, border), variance(width, height, border) {}
  size_t bytes() const { return colour.bytes() + variance.bytes(); }
};

/// The taps of a SIMD vector of pixels.
enum class TapPattern : uint8_t {
  kGather,          ///< some taps are at other pixels
  kBlock2x2,        ///< kGather, and the 2x2 taps of all pixels are contiguous and inside the image
  kIdentityOrNone,  ///< the tap of each pixel is the pixel itself, or there is none
  kIdentity,        ///< the tap of every pixel is the pixel itself, with a weight of 1
  kDisoccluded,     ///< no pixel has a tap
};

inline bool IsGather(TapPattern pattern) {
  return pattern == TapPattern::kGather || pattern == TapPattern::kBlock2x2;
}

/// Position of the taps of a SIMD vector that is kBlock2x2: the first tap of its first pixel.
struct TapBlock {
  int32_t x;
  int32_t y;
};

/// Taps of each pixel in its history (see stages/reproject.h). For vectors marked kIdentity or
/// kDisoccluded the planes are not written; for kBlock2x2, only the weights are.
struct ReprojectionTaps {
  Plane<int32_t> x;         ///< left column of the 2x2 taps in the previous frame
  Plane<int32_t> y;         ///< upper row
  Planes<float, 4> weight;  ///< of (x,y) (x+1,y) (x,y+1) (x+1,y+1); they sum to 1, or are all 0
  Plane<uint32_t> search;   ///< bits 0..8: taps of the 3x3 block at (x+1, y+1) to average instead

  /// For the vectors of each row, with capacity for vectors of one pixel.
  std::vector<TapPattern> patterns;
  /// number of vectors per row for which IsGather is true; -1: unknown
  std::vector<int32_t> gathers;
  std::vector<int32_t> scattered;  ///< number of those vectors that are not kBlock2x2
  std::vector<TapBlock> blocks;    ///< of the vectors of each row
  int patterns_per_row = 0;
  int blocks_per_row = 0;
  /// Frame::confidence, as given by the caller; nullptr: 1 everywhere. Valid during the current
  /// frame.
  const Image1* confidence = nullptr;
  /// Guides::previous_normal, for HistoryNormal; nullptr: this frame's normals are compared. Valid
  /// during the current frame.
  const Image3* previous_normal = nullptr;
  int lanes = 1;  ///< pixels of a vector

  ReprojectionTaps() = default;
  ReprojectionTaps(int width, int height)
      : x(width, height),
        y(width, height),
        weight(width, height),
        search(width, height),
        patterns_per_row(width) {
    const auto rows = static_cast<size_t>(height);
    patterns.resize(rows * static_cast<size_t>(patterns_per_row), TapPattern::kGather);
    gathers.resize(rows, -1);
    scattered.resize(rows, width);
  }
  /// Sets the vector size in pixels.
  void SetLanes(int pixels) {
    lanes = pixels;
    blocks_per_row = (x.width() + lanes - 1) / lanes;
    blocks.resize(static_cast<size_t>(blocks_per_row) * static_cast<size_t>(x.height()));
  }
  /// Pattern of the vector of a pixel; kGather if vectors are not marked, in which case the planes
  /// are valid.
  TapPattern PatternOf(int px, int py) const {
    return gathers[static_cast<size_t>(py)] < 0 ? TapPattern::kGather : Pattern(px / lanes, py);
  }
  /// Whether a pixel has a history.
  bool HasHistory(int px, int py) const {
    const TapPattern pattern = PatternOf(px, py);
    if (pattern == TapPattern::kIdentity || pattern == TapPattern::kDisoccluded) {
      return pattern == TapPattern::kIdentity;
    }
    return (pattern != TapPattern::kBlock2x2 && search(px, py) != 0) ||
           weight[0](px, py) + weight[1](px, py) + weight[2](px, py) + weight[3](px, py) > 0;
  }
  /// HistoryNormal of a pixel with this normal.
  vec3 NormalBefore(vec3 now, int px, int py) const {
    return previous_normal != nullptr
               ? HistoryNormal(now, {(*previous_normal)[0](px, py), (*previous_normal)[1](px, py),
                                     (*previous_normal)[2](px, py)})
               : now;
  }
  /// UsedConfidence of a pixel.
  float ConfidenceAt(int px, int py) const {
    return confidence != nullptr
               ? UsedConfidence((*confidence)(px, py), std::isnan((*confidence)(px, py)))
               : 1.0f;
  }
  /// Number of SIMD vectors for which IsGather; -1: unknown.
  int64_t GatherCount() const {
    int64_t sum = 0;
    for (const int32_t of_row : gathers) {
      if (of_row < 0) {
        return -1;
      }
      sum += of_row;
    }
    return sum;
  }
  /// \param vector  index of the vector in its row
  TapPattern& Pattern(int vector, int row) {
    return patterns[static_cast<size_t>(row) * static_cast<size_t>(patterns_per_row) +
                    static_cast<size_t>(vector)];
  }
  TapPattern Pattern(int vector, int row) const {
    return const_cast<ReprojectionTaps*>(this)->Pattern(vector, row);
  }
  /// \param vector  index of the vector in its row
  TapBlock& Block(int vector, int row) {
    return blocks[static_cast<size_t>(row) * static_cast<size_t>(blocks_per_row) +
                  static_cast<size_t>(vector)];
  }
  TapBlock Block(int vector, int row) const {
    return const_cast<ReprojectionTaps*>(this)->Block(vector, row);
  }
  size_t bytes() const {
    return x.bytes() + y.bytes() + weight.bytes() + search.bytes() + patterns.size() +
           (gathers.size() + scattered.size()) * sizeof(int32_t) + blocks.size() * sizeof(TapBlock);
  }
};

/// Planes of one signal's history, in the order of StagedHistory.
enum HistorySlot : int {
  kColourSlot = 0,
  kBehindSlot = 3,
  kMeanSlot = 6,
  kVarianceSlot,
  kLengthSlot,
  kWeights2Slot,
  kCompressedSlot,
  kHistorySlots
};

/// History of vectors that cannot be written yet, because other vectors still read the old values.
struct StagedHistory {
  std::vector<float> values;   ///< per vector: kHistorySlots times its lanes
  std::vector<int32_t> first;  ///< of each row: number of vectors before it

  StagedHistory() = default;
  /// Capacity for one pixel in eight.
  StagedHistory(int width, int height)
      : values(static_cast<size_t>(width) * static_cast<size_t>(height) / 8 * kHistorySlots),
        first(static_cast<size_t>(height)) {}
  /// Whether the capacity suffices for this number of vectors.
  bool HasRoom(size_t vectors, int lanes) const {
    return vectors * kHistorySlots * static_cast<size_t>(lanes) <= values.size();
  }
  /// \param vectors  number of staged vectors of each row
  void MakePlaces(const std::vector<int32_t>& vectors) {
    std::exclusive_scan(vectors.begin(), vectors.end(), first.begin(), 0);
  }
  float* Row(int y, int lanes) {
    return values.data() + static_cast<size_t>(first[static_cast<size_t>(y)]) * kHistorySlots *
                               static_cast<size_t>(lanes);
  }
  size_t bytes() const { return (values.size() + first.size()) * sizeof(float); }
};

}  // namespace stillray
