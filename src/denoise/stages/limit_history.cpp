// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/limit_history.h"

#include <algorithm>
#include <atomic>
#include <initializer_list>

#include "core/check.h"
#include "core/parallel.h"
#include "core/shared.h"
#include "denoise/row_scratch.h"
#include "denoise/simd/next_row.h"
#include "denoise/stages/limit_history_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/limit_history.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/coarse_grid-inl.h"
#include "denoise/simd/fetch_taps-inl.h"
#include "denoise/simd/sparse_rows-inl.h"
#include "denoise/simd/stream_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Rows in the scratch memory with one value per pixel, for both rows of the blocks.
enum PixelRow {
  kPresent,
  kHistory,
  kNoise,
  kCompressedPresent,
  kCompressedHistory,
  kSingle,
  kCompressedNoise,
  kBoth,  ///< 1 where present and history exist
  kPixelRows
};
/// The following rows have one value per block: the weights of its pixels.
constexpr int kWeightRow = 2 * kPixelRows;
constexpr int kCompareRows = kWeightRow + 4;

/// See CompressedVariance. \param c  the compressed mean
HWY_INLINE VF SampleVariance(VF c, VF mean, VF variance, VF scale) {
  const DF d;
  const VF s = hn::Add(hn::Max(mean, hn::Zero(d)), scale);
  const VF slope = hn::Div(hn::Div(scale, s), s);
  return hn::Min(hn::Mul(hn::Mul(slope, variance), slope),
                 hn::Mul(c, hn::Sub(hn::Set(d, 1.0f), c)));
}

/// The history and taps that the next row reads.
template <size_t kMost>
void AddHistory(std::initializer_list<const Image1*> planes, const ReprojectionTaps& taps, int y,
                NextRow<kMost>* next) {
  const int row = RowOfTaps(taps, taps.x.width() / 2, y) + 2;
  for (const Image1* plane : planes) {
    next->Add(*plane, row);
  }
  AddTaps(taps, y + 1, next);
}

/// Fills the rows of per-pixel values of one signal.
/// \tparam kWithConfidence  whether ReprojectionTaps::confidence is given
/// \return whether any pixel has both present and history
template <bool kWithConfidence>
bool ComparePixels(const NewLight& light, const SignalHistory& before, const ReprojectionTaps& taps,
                   int y, const Image1& roughness, const RowScratch& scratch, int first_row) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = light.samples.width();
  float* both_row = scratch.Row(first_row + kBoth);
  if (y >= light.samples.height()) {
    std::fill_n(both_row, width + 2, 0.0f);
    return false;
  }
  const VF scale = hn::Set(d, before.compressed_scale);
  const bool sparse = IsSparseRow(light.samples.Row(y), width);
  NextRow<24> next;
  next.Add(light.samples, y + 1);
  next.Add(light.colour[0], y + 1);
  if (!sparse) {
    AddHistory(
        {&before.length, &before.mean, &before.variance, &before.compressed, &before.weights2},
        taps, y, &next);
  }
  bool any = false;
  for (int x = 0; x < width; x += LaneCount()) {
    next.Fetch(x);
    if (sparse && NoSamples(light.samples, x, y)) {
      hn::StoreU(zero, d, both_row + x);
      continue;
    }
    VF length, mean, variance, then, weights2;
    WithHistory<kWithConfidence>(
        before, taps, x, y, [&](const auto& old_of) HWY_ATTR __attribute__((always_inline)) {
          length = old_of.Length();
          mean = old_of(before.mean);
          variance = old_of(before.variance);
          then = old_of(before.compressed);
          weights2 = old_of(before.weights2);
        });
    const VF n = hn::LoadU(d, light.samples.Row(y) + x);
    const VF l = hn::LoadU(d, light.colour[0].Row(y) + x);
    const MF both = hn::And(InRow(x, width), hn::And(hn::Gt(n, zero), hn::Gt(length, zero)));
    const VF per_n = hn::Div(one, hn::Max(n, one));
    const VF spread = hn::Add(per_n, weights2);
    const VF least = hn::Max(hn::Sub(one, weights2), hn::Set(d, 0.25f));
    const VF difference = hn::Sub(l, mean);
    const VF by_moments = hn::IfThenElseZero(hn::Ge(length, hn::Set(d, kLengthWithVariance)),
                                             hn::Mul(hn::Div(variance, least), spread));
    const VF frames = hn::Mul(length, per_n);
    const VF caution = hn::Sqrt(hn::Max(hn::Mul(frames, hn::Set(d, 1.0f / kSteadyFrames)), one));
    const VF noise = hn::Mul(caution, hn::Max(by_moments, hn::Mul(difference, difference)));
    const VF single = SampleVariance(then, mean, variance, scale);
    const VF positive = hn::Max(l, zero);
    const VF compressed = hn::Div(positive, hn::Add(positive, scale));
    const VF change = hn::Sub(compressed, then);
    const VF shortness =  // Shortness
        hn::Min(hn::Max(hn::Sub(hn::Set(d, kLengthWithVariance), length), zero), one);
    VF share = hn::MulAdd(shortness, hn::Set(d, kShareOfShortChange - kShareOfChange),
                          hn::Set(d, kShareOfChange));  // ShareOfChange
    if (!roughness.empty()) {
      const VF r = hn::LoadU(d, roughness.Row(y) + x);
      share = hn::IfThenElse(hn::Ge(r, hn::Set(d, kRoughnessOfImage)), one, share);
    }
    const VF compressed_noise =  // CompressedNoise
        hn::Max(hn::Mul(single, spread), hn::Mul(hn::Mul(share, change), change));
    const VF by_change = hn::Mul(hn::Mul(shortness, hn::Set(d, kSingleOfShortChange)),
                                 hn::Div(hn::Mul(change, change), spread));
    const VF single_of_change = hn::Max(single, by_change);  // SingleVariance
    const auto store = [&](PixelRow row, VF value) HWY_ATTR __attribute__((always_inline)) {
      hn::StoreU(hn::IfThenElseZero(both, value), d, scratch.Row(first_row + row) + x);
    };
    store(kPresent, l);
    store(kHistory, mean);
    store(kNoise, noise);
    store(kCompressedPresent, compressed);
    store(kCompressedHistory, then);
    store(kSingle, single_of_change);
    store(kCompressedNoise, compressed_noise);
    store(kBoth, one);
    any = any || !hn::AllFalse(d, both);
  }
  both_row[width] = 0;  // with an odd width, the last blocks have one column
  return any;
}

/// Averages the pixels of a row of blocks.
void AverageBlocks(const RowScratch& scratch, int by, int blocks, ComparedPlanes* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const auto load = [&](PixelRow row, int bx) HWY_ATTR __attribute__((always_inline)) {
    return LoadBlocks(scratch.Row(row), scratch.Row(kPixelRows + row), bx);
  };
  for (int bx = 0; bx < blocks; bx += LaneCount()) {
    const BlockValues both = load(kBoth, bx);
    VF weight[4];
    MF known[4];
    VF sum = zero;
    for (int k = 0; k < 4; ++k) {
      known[k] = hn::Gt(both.pixel[k], zero);
      weight[k] = hn::IfThenElseZero(known[k], hn::LoadU(d, scratch.Row(kWeightRow + k) + bx));
      sum = hn::Add(sum, weight[k]);
    }
    const MF valid = hn::Gt(sum, hn::Set(d, kLeastComparedWeight));
    const VF scale = hn::IfThenElseZero(valid, hn::Div(one, hn::IfThenElse(valid, sum, one)));
    const VF scale2 = hn::Mul(scale, scale);
    // Rows without samples are not written; their content is masked.
    const auto mean = [&](PixelRow row) HWY_ATTR __attribute__((always_inline)) {
      const BlockValues v = load(row, bx);
      VF total = zero;
      for (int k = 0; k < 4; ++k) {
        total = hn::MulAdd(weight[k], hn::IfThenElseZero(known[k], v.pixel[k]), total);
      }
      return hn::Mul(total, scale);
    };
    const auto noise = [&](PixelRow row) HWY_ATTR __attribute__((always_inline)) {
      const BlockValues v = load(row, bx);
      VF total = zero;
      for (int k = 0; k < 4; ++k) {
        total = hn::MulAdd(hn::Mul(weight[k], weight[k]), hn::IfThenElseZero(known[k], v.pixel[k]),
                           total);
      }
      return hn::Mul(total, scale2);
    };
    const auto store = [&](VF value, Image1 * plane) HWY_ATTR __attribute__((always_inline)) {
      StoreInRow(d, value, plane->Row(by), bx, blocks);
    };
    store(hn::IfThenElseZero(valid, one), &out->valid);
    store(mean(kPresent), &out->light.colour[0]);
    store(mean(kHistory), &out->light.colour[1]);
    store(noise(kNoise), &out->light.variance);
    store(mean(kCompressedPresent), &out->compressed.colour[0]);
    store(mean(kCompressedHistory), &out->compressed.colour[1]);
    store(mean(kSingle), &out->compressed.colour[2]);
    store(noise(kCompressedNoise), &out->compressed.variance);
  }
}

/// Clears a row of blocks without samples.
void ClearBlocks(int by, int blocks, ComparedPlanes* out) {
  for (Image1* plane :
       {&out->valid, &out->light.colour[0], &out->light.colour[1], &out->light.variance,
        &out->compressed.colour[0], &out->compressed.colour[1], &out->compressed.colour[2],
        &out->compressed.variance}) {
    std::fill_n(plane->Row(by), blocks, 0.0f);
  }
}

void CompareRows(std::span<const ComparedSignal> signals, const ReprojectionTaps& taps,
                 const GuidePlanes& guides, const Image1& roughness, int begin, int end,
                 GuidePlanes* coarse) {
  const TinyIsZero tiny_is_zero;
  const int width = guides.id.width();
  const int blocks = CoarseSize(width);
  const RowScratch scratch(width + 2, kCompareRows);
  const auto compare_pixels =
      taps.confidence != nullptr ? ComparePixels<true> : ComparePixels<false>;
  for (int by = begin; by < end; ++by) {
    CoarseRow(guides, by, scratch, kWeightRow, coarse);
    for (const ComparedSignal& signal : signals) {
      bool any = false;
      for (int row = 0; row < 2; ++row) {
        any = compare_pixels(*signal.light, *signal.before, taps, 2 * by + row, roughness, scratch,
                             row * kPixelRows) ||
              any;
      }
      if (any) {
        AverageBlocks(scratch, by, blocks, signal.out);
      } else {
        ClearBlocks(by, blocks, signal.out);
      }
    }
  }
}

/// HistoryRatio. \param ratio_noise  RatioNoise
HWY_INLINE VF RatioOf(VF present, VF before, VF noise, float ratio_noise) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const VF least = hn::Set(d, 1e-20f);
  const VF change = hn::Sub(present, before);
  const VF unexplained = hn::Div(hn::Mul(hn::Set(d, ratio_noise), noise),
                                 hn::Max(hn::Mul(change, change), hn::Set(d, 1e-30f)));
  const VF significance = hn::Max(hn::Sub(one, unexplained), hn::Zero(d));
  const VF ratio = hn::Add(one, hn::Div(hn::Mul(significance, change), hn::Max(before, least)));
  const VF bounded = hn::Min(hn::Max(ratio, hn::Set(d, 1.0f / kMostRatio)), hn::Set(d, kMostRatio));
  return hn::IfThenElse(hn::Gt(before, least), bounded, one);
}

/// LogChange.
HWY_INLINE VF ChangeOf(VF present, VF before) {
  const DF d;
  const VF least = hn::Set(d, 1e-20f);
  const MF both = hn::And(hn::Gt(present, least), hn::Gt(before, least));
  const VF one = hn::Set(d, 1.0f);
  const VF quotient =
      hn::Div(hn::IfThenElse(both, present, one), hn::IfThenElse(both, before, one));
  const VF change = hn::Mul(hn::Set(d, 1.0f / kLog2E), Log2(quotient));
  return hn::Min(hn::Max(change, hn::Set(d, -kMostChange)), hn::Set(d, kMostChange));
}

void MeasureChangeRows(const FilterPlanes& averaged, int begin, int end, ComparedPlanes* planes) {
  const DF d;
  const int width = planes->valid.width();
  for (int y = begin; y < end; ++y) {
    for (int x = 0; x < width; x += LaneCount()) {
      const MF valid = hn::Gt(hn::LoadU(d, planes->valid.Row(y) + x), hn::Zero(d));
      const VF change =
          hn::IfThenElseZero(valid, ChangeOf(hn::LoadU(d, averaged.colour[0].Row(y) + x),
                                             hn::LoadU(d, averaged.colour[1].Row(y) + x)));
      StoreInRow(d, change, planes->light.colour[0].Row(y), x, width);
      StoreInRow(d, hn::Mul(change, change), planes->light.colour[1].Row(y), x, width);
      StoreInRow(d, hn::IfThenElseZero(valid, hn::Set(d, 1.0f)), planes->light.variance.Row(y), x,
                 width);
    }
  }
}

/// ChangeVariance.
HWY_INLINE VF VarianceOfNoise(VF noise, VF history) {
  const DF d;
  const VF deviation =
      hn::Min(hn::Div(hn::Sqrt(hn::Max(noise, hn::Zero(d))), hn::Max(history, hn::Set(d, 1e-20f))),
              hn::Set(d, kMostChange));
  return hn::Mul(deviation, deviation);
}

/// WideRatio.
HWY_INLINE VF WideRatioOf(VF mean, VF square, VF variance, VF weights2) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const VF known = hn::Div(one, hn::Max(weights2, hn::Set(d, 1e-3f)));
  const VF mean2 = hn::Mul(mean, mean);
  const VF scatter = hn::Mul(hn::Set(d, kWideScatter), hn::Max(hn::Sub(square, mean2), zero));
  const VF expected = hn::Mul(hn::Set(d, kWideNoise), variance);
  const VF of_mean = hn::Div(hn::Max(scatter, expected), hn::Max(known, one));
  const VF noise =
      hn::MulAdd(hn::Set(d, kWideOverlap), of_mean, hn::Set(d, kWideLeast * kWideLeast));
  const VF share = hn::Max(hn::Sub(one, hn::Div(noise, hn::Max(mean2, hn::Set(d, 1e-12f)))), zero);
  const VF ratio = Exp2(hn::Mul(hn::Set(d, kLog2E), hn::Mul(mean, share)));
  return hn::IfThenElse(hn::Ge(known, hn::Set(d, kWideKnown)), ratio, one);
}

/// ScaledCompressed.
HWY_INLINE VF Scaled(VF c, VF ratio) {
  const DF d;
  const VF scaled = hn::Mul(c, ratio);
  const VF sum = hn::Sub(hn::Add(scaled, hn::Set(d, 1.0f)), c);
  return hn::Div(scaled, hn::Max(sum, hn::Set(d, 1e-30f)));
}

/// BlockSlope.
HWY_INLINE VF SlopeOf(VF before, VF here, VF after) {
  const DF d;
  const VF a = hn::Sub(here, before);
  const VF b = hn::Sub(after, here);
  const VF smaller = hn::IfThenElse(hn::Lt(hn::Abs(a), hn::Abs(b)), a, b);
  return hn::IfThenElseZero(hn::Gt(hn::Mul(a, b), hn::Zero(d)), smaller);
}

struct Slopes {
  VF x, y;
};

/// Slopes of the compressed history at the blocks x, x + 1, ...; zero along an axis if a neighbour
/// has no history or is outside the image.
HWY_INLINE Slopes SlopesAt(const ComparedPlanes& planes, int x, int y) {
  const DF d;
  const Image1& history = planes.compressed.colour[1];
  const VF here = hn::LoadU(d, history.Row(y) + x);
  const auto at = [&](int nx, int ny) HWY_ATTR __attribute__((always_inline)) {
    const MF valid = hn::Gt(hn::LoadU(d, planes.valid.Row(ny) + nx), hn::Zero(d));
    return hn::IfThenElse(valid, hn::LoadU(d, history.Row(ny) + nx), here);
  };
  return {SlopeOf(at(x - 1, y), here, at(x + 1, y)), SlopeOf(at(x, y - 1), here, at(x, y + 1))};
}

void CorrectHistoryRows(const FilterPlanes& averaged, const LimitHistoryParameters& p, int begin,
                        int end, ComparedPlanes* planes) {
  const DF d;
  const TinyIsZero tiny_is_zero;
  const VF one = hn::Set(d, 1.0f);
  const FilterPlanes& compressed = planes->compressed;
  const bool corrects = p.correct_history != 0;
  const float ratio_noise = RatioNoise(planes->moving);
  const bool jittered = p.jitter_x != 0 || p.jitter_y != 0;
  const int width = planes->ratio.width();
  for (int y = begin; y < end; ++y) {
    const auto load = [&](const Image1& plane, int x)
                          HWY_ATTR { return hn::LoadU(d, plane.Row(y) + x); };
    const auto store = [&](VF value, Image1* plane, int x)
                           HWY_ATTR { StoreInRow(d, value, plane->Row(y), x, width); };
    for (int x = 0; x < width; x += LaneCount()) {
      const MF valid = hn::Gt(load(planes->valid, x), hn::Zero(d));
      VF ratio = one;
      if (corrects) {
        const FilterPlanes& changes = planes->wide;
        const VF before = load(averaged.colour[1], x);
        const VF expected = load(averaged.variance, x);
        const VF wide = WideRatioOf(load(changes.colour[0], x), load(changes.colour[1], x),
                                    VarianceOfNoise(expected, before), load(changes.variance, x));
        const VF left =
            RatioOf(load(averaged.colour[0], x), hn::Mul(before, wide), expected, ratio_noise);
        ratio = hn::IfThenElse(valid, hn::Mul(wide, left), one);
      }
      VF difference =
          hn::Sub(load(compressed.colour[0], x), Scaled(load(compressed.colour[1], x), ratio));
      VF noise = load(compressed.variance, x);
      if (jittered) {
        const Slopes g = SlopesAt(*planes, x, y);
        const VF shift = hn::Mul(
            hn::Set(d, 0.5f),  // JitterShift
            hn::Add(hn::Mul(g.x, hn::Set(d, p.jitter_x)), hn::Mul(g.y, hn::Set(d, p.jitter_y))));
        const VF left =  // JitterNoise
            hn::Mul(hn::Set(d, kJitterNoise), hn::Add(hn::Mul(g.x, g.x), hn::Mul(g.y, g.y)));
        difference = hn::Sub(difference, hn::IfThenElseZero(valid, shift));
        noise = hn::Add(noise, hn::IfThenElseZero(valid, left));
      }
      store(ratio, &planes->ratio, x);
      store(difference, &planes->light.colour[0], x);
      store(load(compressed.colour[2], x), &planes->light.colour[1], x);
      store(noise, &planes->light.variance, x);
    }
  }
}

/// Rows in the scratch memory: the four weights of the even and of the odd pixels of a row, and the
/// results.
enum LimitRow { kBlockWeights, kRatioRow = 8, kBiasRow, kLimitRows };

void LimitHistoryRows(std::span<const LimitedSignal> signals, const GuidePlanes& coarse,
                      const GuidePlanes& guides, int y0, int y1) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  const TinyIsZero tiny_is_zero;
  const int width = guides.id.width();
  const RowScratch scratch(width + 2, kLimitRows);
  for (int y = y0; y < y1; ++y) {
    WeighBlocks(coarse, guides, y, scratch, kBlockWeights);
    for (const LimitedSignal& signal : signals) {
      const ComparedPlanes& compared = *signal.compared;
      InterpolateBlocks<2>(compared.valid, {&compared.ratio, &compared.bias}, {1.0f, 0.0f}, y,
                           scratch, kBlockWeights, kRatioRow);
      for (int x = 0; x < width; x += LaneCount()) {
        const VF n = hn::LoadU(d, signal.samples->Row(y) + x);
        const MF sampled = hn::Gt(n, hn::Zero(d));
        const VF ratio = hn::LoadU(d, scratch.Row(kRatioRow) + x);
        const VF bias =  // BiasOfFrame
            hn::Min(hn::Mul(hn::LoadU(d, scratch.Row(kBiasRow) + x), hn::Max(n, one)),
                    hn::Set(d, kMostBias));
        StreamInRow(d, hn::IfThenElse(sampled, ratio, one), signal.ratio->Row(y), x, width);
        StreamInRow(d, hn::IfThenElseZero(sampled, bias), signal.bias->Row(y), x, width);
      }
    }
  }
  FinishStreams();
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {

void RescaleHistory(float scale, SignalHistory* history) {
  ParallelRows(history->compressed.height(), 32, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* c = history->compressed.Row(y);
      for (int x = 0; x < history->compressed.width(); ++x) {
        c[x] = RescaleCompressed(c[x], history->compressed_scale, scale);
      }
    }
  });
  history->compressed_scale = scale;
}

namespace {

/// Raises `bias` to the RelativeBias of a row of blocks after one of the levels, where that is
/// larger.
void RaiseBias(const FilterPlanes& level, float dead, int y, float* bias) {
  const float* difference = level.colour[0].Row(y);
  const float* variance = level.colour[1].Row(y);
  const float* noise = level.variance.Row(y);
  for (int x = 0; x < level.variance.width(); ++x) {
    bias[x] = std::max(bias[x], RelativeBias(difference[x], noise[x], variance[x], dead));
  }
}

}  // namespace

float FindMovingLight(const FilterPlanes& averaged, bool is_diffuse, const ComparedPlanes& planes) {
  const int width = planes.valid.width();
  std::atomic<int64_t> changed = 0;
  std::atomic<int64_t> known = 0;
  ParallelRows(planes.valid.height(), 32, [&](int y0, int y1) {
    int changed_here = 0;
    int known_here = 0;
    for (int y = y0; y < y1; ++y) {
      const float* valid = planes.valid.Row(y);
      const float* present = averaged.colour[0].Row(y);
      const float* history = averaged.colour[1].Row(y);
      const float* noise = averaged.variance.Row(y);
      for (int x = 0; x < width; ++x) {
        const bool counts = valid[x] > 0;
        const bool differs = HasChanged(present[x], history[x], noise[x]);
        known_here += counts ? 1 : 0;
        changed_here += counts && differs ? 1 : 0;
      }
    }
    changed += changed_here;
    known += known_here;
  });
  return MovingLight(static_cast<float>(changed), static_cast<float>(known), is_diffuse);
}

void MeasureBias(const FilterPlanes& blurred, const FilterPlanes* fine,
                 const LimitHistoryParameters& p, ComparedPlanes* planes) {
  const float dead = DeadZone(p.limit_dead, planes->moving);
  ParallelRows(planes->bias.height(), 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      float* bias = planes->bias.Row(y);
      std::fill_n(bias, planes->bias.width(), 0.0f);
      RaiseBias(blurred, dead, y, bias);
      if (fine != nullptr) {
        RaiseBias(*fine, kFineDead * dead, y, bias);
      }
      const float* valid = planes->valid.Row(y);
      for (int x = 0; x < planes->bias.width(); ++x) {
        bias[x] = valid[x] > 0 ? bias[x] : 0.0f;
      }
    }
  });
}

namespace cpu {

HWY_EXPORT(CompareRows);
HWY_EXPORT(MeasureChangeRows);
HWY_EXPORT(CorrectHistoryRows);
HWY_EXPORT(LimitHistoryRows);

void CompareWithHistory(std::span<const ComparedSignal> signals, const ReprojectionTaps& taps,
                        const GuidePlanes& guides, const Image1& roughness, GuidePlanes* coarse) {
  ParallelRows(CoarseSize(guides.id.height()), 16, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(CompareRows)(signals, taps, guides, roughness, begin, end, coarse);
  });
}

void MeasureChange(const FilterPlanes& averaged, ComparedPlanes* planes) {
  ParallelRows(planes->valid.height(), 16, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(MeasureChangeRows)(averaged, begin, end, planes);
  });
}

void CorrectHistory(const FilterPlanes& averaged, const LimitHistoryParameters& p,
                    ComparedPlanes* planes) {
  ParallelRows(planes->ratio.height(), 16, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(CorrectHistoryRows)(averaged, p, begin, end, planes);
  });
}

void LimitHistory(std::span<const LimitedSignal> signals, const GuidePlanes& coarse,
                  const GuidePlanes& guides) {
  ParallelRows(guides.id.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(LimitHistoryRows)(signals, coarse, guides, y0, y1);
  });
}

}  // namespace cpu
}  // namespace stillray
#endif
