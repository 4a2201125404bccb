// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/sum_albedo.h"

#include <algorithm>
#include <limits>

#include "core/parallel.h"
#include "denoise/row_scratch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/sum_albedo.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Sums one channel of a row.
/// \param low, high  [in,out] the range of each column
void SumRow(std::span<const Image3* const> albedos, int c, int y, Image1* sum, float* low,
            float* high) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = sum->width();
  for (int x = 0; x < width; x += LaneCount()) {
    VF total = zero;
    for (const Image3* albedo : albedos) {
      const VF value = hn::LoadU(d, (*albedo)[c].Row(y) + x);
      // Infinity and NaN minus themselves are NaN, and fail the comparison.
      const MF finite = hn::Eq(hn::Sub(value, value), zero);
      total = hn::Add(total, hn::Max(hn::IfThenElseZero(finite, value), zero));
    }
    StoreInRow(d, total, sum->Row(y), x, width);
    hn::StoreU(hn::Min(hn::LoadU(d, low + x), total), d, low + x);
    hn::StoreU(hn::Max(hn::LoadU(d, high + x), total), d, high + x);
  }
}

/// Sums the rows of the blocks y0..y1.
void SumBlockRows(std::span<const Image3* const> albedos, int y0, int y1, SummedAlbedo* out) {
  const int width = out->sum.width();
  const RowScratch scratch(width, 2);
  float* const low = scratch.Row(0);
  float* const high = scratch.Row(1);
  for (int by = y0; by < y1; ++by) {
    for (int c = 0; c < 3; ++c) {
      const int padded = width + LaneCount();
      std::fill_n(low, padded, std::numeric_limits<float>::max());
      std::fill_n(high, padded, 0.0f);
      const int end = std::min((by + 1) * kAlbedoBlock, out->sum.height());
      for (int y = by * kAlbedoBlock; y < end; ++y) {
        SumRow(albedos, c, y, &out->sum[c], low, high);
      }
      for (int bx = 0; bx < out->low.width(); ++bx) {
        const int x = bx * kAlbedoBlock;
        const int count = std::min(kAlbedoBlock, width - x);
        out->block_low[c](bx, by) = *std::min_element(low + x, low + x + count);
        out->block_high[c](bx, by) = *std::max_element(high + x, high + x + count);
      }
    }
  }
}

/// The ranges over 3x3 blocks, for the rows y0..y1 of blocks.
void SpreadRows(int y0, int y1, SummedAlbedo* out) {
  const DF d;
  const int blocks = out->low.width();
  for (int c = 0; c < 3; ++c) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < blocks; x += LaneCount()) {
        VF low = hn::LoadU(d, out->block_low[c].Row(y) + x);
        VF high = hn::LoadU(d, out->block_high[c].Row(y) + x);
        for (int j = -1; j <= 1; ++j) {
          for (int i = -1; i <= 1; ++i) {
            low = hn::Min(low, hn::LoadU(d, out->block_low[c].Row(y + j) + x + i));
            high = hn::Max(high, hn::LoadU(d, out->block_high[c].Row(y + j) + x + i));
          }
        }
        StoreInRow(d, low, out->low[c].Row(y), x, blocks);
        StoreInRow(d, high, out->high[c].Row(y), x, blocks);
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
namespace {

/// Fills a plane, with its border, with the lower end of an empty range.
void FillWithFarthest(Image1* plane) {
  for (int y = -1; y <= plane->height(); ++y) {
    std::fill_n(plane->Row(y) - 1, plane->width() + 2, std::numeric_limits<float>::max());
  }
}

/// The ranges of the virtual images' depths in the rows y0..y1 of blocks.
void FindImageRanges(const Image1& images, int y0, int y1, SummedAlbedo* out) {
  for (int by = y0; by < y1; ++by) {
    const int end = std::min((by + 1) * kAlbedoBlock, images.height());
    for (int bx = 0; bx < out->low.width(); ++bx) {
      const int x0 = bx * kAlbedoBlock;
      const int x1 = std::min(x0 + kAlbedoBlock, images.width());
      float nearest = std::numeric_limits<float>::max();
      float farthest = 0;
      for (int y = by * kAlbedoBlock; y < end; ++y) {
        const float* row = images.Row(y);
        for (int x = x0; x < x1; ++x) {
          nearest = std::min(nearest, row[x]);
          farthest = std::max(farthest, row[x]);
        }
      }
      out->block_nearest(bx, by) = nearest;
      out->block_farthest(bx, by) = farthest;
    }
  }
}

/// Marks the pixels of a block for which IsBesideImage is true.
void MarkBlock(const Image1& images, int bx, int by, SummedAlbedo* out) {
  float nearest = std::numeric_limits<float>::max();
  float farthest = 0;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      nearest = std::min(nearest, out->block_nearest(bx + i, by + j));
      farthest = std::max(farthest, out->block_farthest(bx + i, by + j));
    }
  }
  const int y1 = std::min((by + 1) * kAlbedoBlock, images.height());
  const int x1 = std::min((bx + 1) * kAlbedoBlock, images.width());
  for (int y = by * kAlbedoBlock; y < y1; ++y) {
    const float* row = images.Row(y);
    float* beside = out->beside_image.Row(y);
    for (int x = bx * kAlbedoBlock; x < x1; ++x) {
      beside[x] = IsBesideImage(row[x], nearest, farthest) ? 1.0f : 0.0f;
    }
  }
}

void MarkImages(const Image1& images, SummedAlbedo* out) {
  const int width = images.width();
  const int height = images.height();
  if (out->beside_image.empty()) {
    out->beside_image = Image1(width, height);
    out->block_nearest = Image1(AlbedoBlocks(width), AlbedoBlocks(height), 1);
    out->block_farthest = Image1(AlbedoBlocks(width), AlbedoBlocks(height), 1);
    FillWithFarthest(&out->block_nearest);
  }
  ParallelRows(out->low.height(), 4, [&](int y0, int y1) { FindImageRanges(images, y0, y1, out); });
  ParallelRows(out->low.height(), 4, [&](int y0, int y1) {
    for (int by = y0; by < y1; ++by) {
      for (int bx = 0; bx < out->low.width(); ++bx) {
        MarkBlock(images, bx, by, out);
      }
    }
  });
}

}  // namespace

SummedAlbedo::SummedAlbedo(int width, int height)
    : sum(width, height),
      low(AlbedoBlocks(width), AlbedoBlocks(height)),
      high(AlbedoBlocks(width), AlbedoBlocks(height)),
      block_low(AlbedoBlocks(width), AlbedoBlocks(height), 1),
      block_high(AlbedoBlocks(width), AlbedoBlocks(height), 1) {
  // The border keeps these values; the zeros of `block_high` are the upper end of an empty range.
  for (int c = 0; c < 3; ++c) {
    FillWithFarthest(&block_low[c]);
  }
}

namespace cpu {

HWY_EXPORT(SumBlockRows);
HWY_EXPORT(SpreadRows);

void SumAlbedo(std::span<const Image3* const> albedos, const Image1* images, SummedAlbedo* out) {
  if (images != nullptr) {
    MarkImages(*images, out);
  } else {
    out->beside_image = Image1();
  }
  ParallelRows(out->low.height(), 4, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(SumBlockRows)(albedos, y0, y1, out);
  });
  ParallelRows(out->low.height(), 16, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(SpreadRows)(y0, y1, out);
  });
}

}  // namespace cpu
}  // namespace stillray
#endif
