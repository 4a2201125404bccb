// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Where a level of the wavelet reads and writes: planes, or rings of rows between two levels that
/// run together.
#if defined(STILLRAY_DENOISE_SIMD_LEVEL_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef STILLRAY_DENOISE_SIMD_LEVEL_ROWS_INL_H_
#undef STILLRAY_DENOISE_SIMD_LEVEL_ROWS_INL_H_
#else
#define STILLRAY_DENOISE_SIMD_LEVEL_ROWS_INL_H_
#endif

#include "denoise/simd/level_rows.h"
#include "denoise/simd/next_row.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {

/// One signal at the pixels x, x + 1, ... of a row.
struct SignalRow {
  const float* luminance;
  const float* red;
  const float* blue;
  const float* variance;
  const float* stop;
  const float* present;
  float eaw_l;  ///< log2(e) / sigma^2
};

inline SignalRow RowOf(const LevelRows& rows, int y) {
  const AtrousSignal& s = *rows.signal;
  return {rows.in[0].Row(y),
          rows.in[1].Row(y),
          rows.in[2].Row(y),
          rows.in[3].Row(y),
          s.stop != nullptr ? s.stop->Row(y) : nullptr,
          s.present->Row(y),
          kLog2E / (s.eaw_sigma_l * s.eaw_sigma_l)};
}

struct Sums {
  VF luminance, red, blue, variance, weight;
};

/// Where the filtered pixels of one signal go.
struct OutputRow {
  float* value[4];  ///< luminance, red, blue, variance
  float* kept[3];   ///< nullptr: not wanted
  float* grown;     ///< nullptr: not wanted
  bool is_ring;     ///< read again while it is in the cache
};

inline OutputRow OutputOf(const AtrousLevel& level, const LevelRows& rows, int y) {
  const AtrousSignal& s = *rows.signal;
  OutputRow out = {};
  for (int c = 0; c < 4; ++c) {
    out.value[c] = rows.out[c].Row(y);
  }
  for (int c = 0; c < 3 && y >= level.kept_begin && y < level.kept_end; ++c) {
    out.kept[c] = rows.kept[c].empty() ? nullptr : rows.kept[c].Row(y);
  }
  out.grown = s.grown != nullptr ? s.grown->Row(y) : nullptr;
  out.is_ring = rows.out[0].is_ring();
  return out;
}

HWY_INLINE void Put(const OutputRow& out, int channel, VF value, int x, int width) {
  const DF d;
  if (!out.is_ring) {
    StreamInRow(d, value, out.value[channel], x, width);
    return;
  }
  StoreInRow(d, value, out.value[channel], x, width);
  if (channel < 3 && out.kept[channel] != nullptr) {
    StreamInRow(d, value, out.kept[channel], x, width);
  }
}

/// Writes the filtered pixels of one signal.
HWY_INLINE void Finish(const SignalRow& row, const OutputRow& out, const Sums& sums, MF surface,
                       int x, int width) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const MF filled = hn::And(hn::Gt(sums.weight, hn::Set(d, kMinAtrousWeight)), surface);
  const VF scale = hn::Div(one, hn::IfThenElse(filled, sums.weight, one));
  const VF scale2 = hn::Mul(scale, scale);
  if (hn::AllTrue(d, filled) && out.grown == nullptr) {  // nearly everywhere
    Put(out, 0, hn::Mul(sums.luminance, scale), x, width);
    Put(out, 1, hn::Mul(sums.red, scale), x, width);
    Put(out, 2, hn::Mul(sums.blue, scale), x, width);
    Put(out, 3, hn::Mul(sums.variance, scale2), x, width);
    return;
  }
  const auto put = [&](int channel, VF sum, VF factor, const float* before) HWY_ATTR {
    Put(out, channel, hn::IfThenElse(filled, hn::Mul(sum, factor), hn::LoadU(d, before + x)), x,
        width);
  };
  put(0, sums.luminance, scale, row.luminance);
  put(1, sums.red, scale, row.red);
  put(2, sums.blue, scale, row.blue);
  put(3, sums.variance, scale2, row.variance);
  if (out.grown != nullptr) {
    StreamInRow(d, hn::IfThenElse(filled, one, hn::LoadU(d, row.present + x)), out.grown, x, width);
  }
}

using NextGuides = NextRow<2 + 5 * 4>;
using NextSignal = NextRow<6 + 5 * 6>;

/// What the next row will read of the guides that this one does not; or, with `all_taps`, all that
/// it will.
inline NextGuides NextGuidesOf(const AtrousLevel& level, bool all_taps, int y) {
  const AtrousParameters& p = *level.parameters;
  const GuidePlanes& g = *level.guides;
  NextGuides next;
  if (!level.leads) {
    return next;
  }
  next.Add(g.gradient, y + level.advance);
  for (int tap = all_taps ? -p.radius : p.radius; tap <= p.radius; ++tap) {
    const int row = y + level.advance + p.step * tap;
    next.Add(g.normal, row);
    next.Add(p.edges.plane ? g.inverse_depth : g.depth, row);
  }
  return next;
}

/// ... and what it will read and write of one signal.
inline NextSignal NextSignalOf(const AtrousLevel& level, const LevelRows& rows, bool all_taps,
                               int y) {
  const AtrousParameters& p = *level.parameters;
  const AtrousSignal& signal = *rows.signal;
  const int own = y + level.advance;  // the pixels themselves
  const bool geometry = p.weights == AtrousWeights::kGeometry;
  const int channels = geometry ? 2 : 3;
  NextSignal next;
  for (int c = 0; c < 3 && signal.kept != nullptr && !rows.kept[c].empty(); ++c) {
    AddStreamed((*signal.kept)[c], own, &next);
  }
  if (!rows.out[0].is_ring()) {
    for (int c = 0; c < channels; ++c) {
      AddStreamed(signal.out->colour[c], own, &next);
    }
    AddStreamed(signal.out->variance, own, &next);
    if (signal.grown != nullptr) {
      AddStreamed(*signal.grown, own, &next);
    }
  }
  if (rows.in[0].is_ring()) {
    return next;
  }
  if (!geometry && signal.stop == nullptr) {
    if (level.advance > 1) {
      next.Add(*signal.variance, own - 1);
      next.Add(*signal.variance, own + 1);
    }
  } else if (!geometry && p.noise_ratio <= 1) {
    next.Add(*signal.stop, own);
  }
  for (int tap = all_taps ? -p.radius : p.radius; tap <= p.radius; ++tap) {
    const int row = own + p.step * tap;
    for (int c = 0; c < channels; ++c) {
      next.Add((*signal.colour)[c], row);
    }
    next.Add(*signal.variance, row);
    if (!geometry && p.noise_ratio > 1) {
      next.Add(*signal.stop, row);
    }
    if (geometry || !signal.complete) {
      next.Add(*signal.present, row);
    }
  }
  return next;
}

/// From a pixel to its taps, the two of a pair one after the other.
struct TapDistances {
  ptrdiff_t to[2 * TapPairs::kMost];
};

inline TapDistances DistancesOf(const AtrousLevel& level, const PlaneRows<const float>& rows,
                                int y) {
  const TapPairs& taps = level.taps;
  TapDistances distances;
  if (!rows.is_ring()) {
    for (int i = 0; i < taps.count; ++i) {
      distances.to[2 * i] = taps.pair[i].distance;
      distances.to[2 * i + 1] = -taps.pair[i].distance;
    }
    return distances;
  }
  const int radius = level.parameters->radius;
  const int step = level.parameters->step;
  constexpr int kMostRadius = 2;
  ptrdiff_t to_row[2 * kMostRadius + 1];
  for (int j = -radius; j <= radius; ++j) {
    // Rows outside the picture are not there. Their taps count nothing, wherever they are.
    const int row = y + j * step;
    const bool inside = row >= 0 && row < level.guides->id.height();
    to_row[radius + j] = inside ? rows.Row(row) - rows.Row(y) : 0;
  }
  for (int i = 0; i < taps.count; ++i) {
    const auto dx = static_cast<ptrdiff_t>(taps.pair[i].dx);
    const int j = static_cast<int>(taps.pair[i].dy) / step;
    distances.to[2 * i] = to_row[radius + j] + dx;
    distances.to[2 * i + 1] = to_row[radius - j] - dx;
  }
  return distances;
}

}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#endif  // include guard
