// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/restore_energy.h"

#include <algorithm>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/stages/restore_energy_shared.h"
#include "denoise/stages/select_guides_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/restore_energy.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/coarse_grid-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Rows in the scratch memory of the block means: the weights of a block's pixels, and zeros in
/// place of a row below the image.
enum MeanRow { kPixelWeights, kNoRow = 4, kMeanRows };

/// The plane's values at a row of blocks, whose lower pixel row may be outside the image.
HWY_INLINE BlockValues LoadLight(const Image1& plane, int by, const RowScratch& scratch, int bx) {
  const bool has_lower = 2 * by + 1 < plane.height();
  return LoadBlocks(plane.Row(2 * by), has_lower ? plane.Row(2 * by + 1) : scratch.Row(kNoRow), bx);
}

void MeasureBlocks(const EnergySignal& signal, int by, const RowScratch& scratch) {
  const DF d;
  const VF zero = hn::Zero(d);
  const VF one = hn::Set(d, 1.0f);
  const int width = signal.length->width();
  const int blocks = CoarseSize(width);
  ComparedPlanes& out = *signal.out;
  for (int bx = 0; bx < blocks; bx += LaneCount()) {
    const BlockValues length = LoadLight(*signal.length, by, scratch, bx);
    const BlockValues accumulated = LoadLight(*signal.accumulated, by, scratch, bx);
    const BlockValues filtered = LoadLight(*signal.filtered, by, scratch, bx);
    VF before = zero;
    VF after = zero;
    VF sum = zero;
    for (int k = 0; k < 4; ++k) {
      // With an odd width, the last block has one column.
      const VF x = hn::MulAdd(hn::Iota(d, static_cast<float>(bx)), hn::Set(d, 2.0f),
                              hn::Set(d, static_cast<float>(k & 1)));
      const MF known =
          hn::And(hn::Lt(x, hn::Set(d, static_cast<float>(width))), hn::Gt(length.pixel[k], zero));
      const VF weight =
          hn::IfThenElseZero(known, hn::LoadU(d, scratch.Row(kPixelWeights + k) + bx));
      before = hn::MulAdd(weight, hn::IfThenElseZero(known, accumulated.pixel[k]), before);
      after = hn::MulAdd(weight, hn::IfThenElseZero(known, filtered.pixel[k]), after);
      sum = hn::Add(sum, weight);
    }
    const MF valid = hn::Gt(sum, hn::Set(d, kLeastComparedWeight));
    const VF scale = hn::IfThenElseZero(valid, hn::Div(one, hn::IfThenElse(valid, sum, one)));
    before = hn::Mul(before, scale);
    after = hn::Mul(after, scale);
    const VF difference = hn::Sub(before, after);
    StoreInRow(d, hn::IfThenElseZero(valid, one), out.valid.Row(by), bx, blocks);
    StoreInRow(d, before, out.light.colour[0].Row(by), bx, blocks);
    StoreInRow(d, after, out.light.colour[1].Row(by), bx, blocks);
    StoreInRow(d, hn::Mul(difference, difference), out.light.variance.Row(by), bx, blocks);
  }
}

void MeasureRows(std::span<const EnergySignal> signals, const GuidePlanes& guides, int begin,
                 int end, GuidePlanes* coarse) {
  const TinyIsZero tiny_is_zero;
  const int width = guides.id.width();
  const RowScratch scratch(width + 2, kMeanRows);
  std::fill_n(scratch.Row(kNoRow), width + 2, 0.0f);
  for (int by = begin; by < end; ++by) {
    CoarseRow(guides, by, scratch, kPixelWeights, coarse);
    for (const EnergySignal& signal : signals) {
      MeasureBlocks(signal, by, scratch);
    }
  }
}

/// Rows in the scratch memory of the pixels: the weights of the blocks around them, and the ratio.
enum RestoreRow { kBlockWeights, kRatioRow = 8, kRestoreRows };

void RestoreRows(std::span<const RestoredSignal> signals, const GuidePlanes& coarse,
                 const GuidePlanes& guides, int y0, int y1) {
  const DF d;
  const TinyIsZero tiny_is_zero;
  const int width = guides.id.width();
  const RowScratch scratch(width + 2, kRestoreRows);
  for (int y = y0; y < y1; ++y) {
    WeighBlocks(coarse, guides, y, scratch, kBlockWeights);
    for (const RestoredSignal& signal : signals) {
      const ComparedPlanes& compared = *signal.compared;
      InterpolateBlocks<1>(compared.valid, {&compared.ratio}, {1.0f}, y, scratch, kBlockWeights,
                           kRatioRow);
      for (int x = 0; x < width; x += LaneCount()) {
        VF ratio = hn::LoadU(d, scratch.Row(kRatioRow) + x);
        if (signal.roughness != nullptr) {
          const VF roughness = hn::LoadU(d, signal.roughness->Row(y) + x);
          const MF of_image = hn::Eq(roughness, hn::Set(d, kRoughnessOfImage));
          ratio = hn::IfThenElse(of_image, ratio, hn::Set(d, 1.0f));
        }
        if (hn::AllTrue(d, hn::Eq(ratio, hn::Set(d, 1.0f)))) {
          continue;  // the ratio is 1 in large parts of an image
        }
        for (int c = 0; c < 3; ++c) {
          float* row = (*signal.light)[c].Row(y);
          StoreInRow(d, hn::Mul(ratio, hn::LoadU(d, row + x)), row, x, width);
        }
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray {

void FindEnergyRatio(const FilterPlanes& averaged, ComparedPlanes* planes) {
  ParallelRows(planes->ratio.height(), 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < planes->ratio.width(); ++x) {
        planes->ratio(x, y) = planes->valid(x, y) > 0
                                  ? EnergyRatio(averaged.colour[0](x, y), averaged.colour[1](x, y),
                                                averaged.variance(x, y))
                                  : 1.0f;
      }
    }
  });
}

namespace cpu {

HWY_EXPORT(MeasureRows);
HWY_EXPORT(RestoreRows);

void MeasureEnergy(std::span<const EnergySignal> signals, const GuidePlanes& guides,
                   GuidePlanes* coarse) {
  ParallelRows(coarse->id.height(), 16, [&](int begin, int end) {
    HWY_DYNAMIC_DISPATCH(MeasureRows)(signals, guides, begin, end, coarse);
  });
}

void RestoreEnergy(std::span<const RestoredSignal> signals, const GuidePlanes& coarse,
                   const GuidePlanes& guides) {
  ParallelRows(guides.id.height(), 32, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(RestoreRows)(signals, coarse, guides, y0, y1);
  });
}

}  // namespace cpu
}  // namespace stillray
#endif
