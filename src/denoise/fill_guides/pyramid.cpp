// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/fill_guides/pyramid.h"

#include <utility>

#include "denoise/fill_guides/fill_guides_shared.h"
#include "denoise/row_scratch.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/fill_guides/pyramid.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/fill_guides/pyramid_rows-inl.h"
#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

void DownsampleMaskLevels(PyramidMask* mask) {
  const RowScratch scratch(mask->known.front().width(), 1);
  for (size_t i = 0; i + 1 < mask->known.size(); ++i) {
    const Image1& below = mask->known[i];
    Image1& above = mask->known[i + 1];
    for (int y = 0; y < above.height(); ++y) {
      DownsampleMaskRow(ChildrenOf(below, y), below.width(), above.width(), scratch.Row(0),
                        above.Row(y), mask->inverse[i + 1].Row(y));
    }
  }
}

void FillPlaneLevels(const PyramidMask& mask, std::vector<Image1>* value) {
  const RowScratch scratch(value->front().width(), 2);
  for (size_t i = 0; i + 1 < value->size(); ++i) {
    const Image1& below = (*value)[i];
    Image1& above = (*value)[i + 1];
    for (int y = 0; y < above.height(); ++y) {
      DownsampleRow(ChildrenOf(below, y), ChildrenOf(mask.known[i], y), below.width(),
                    mask.inverse[i + 1].Row(y), above.width(), scratch.Row(0), above.Row(y));
    }
  }
  const DF d;
  const UpsampleAcross across;
  for (size_t i = value->size() - 1; i-- > 0;) {
    Image1& level = (*value)[i];
    for (int y = 0; y < level.height(); ++y) {
      float* filled = scratch.Row(0);
      UpsampleRow((*value)[i + 1], y, scratch.Row(1), across, filled);
      const float* known = mask.known[i].Row(y);
      float* to = level.Row(y);
      for (int x = 0; x < level.width(); x += LaneCount()) {
        const MF keep = hn::Gt(hn::LoadU(d, known + x), hn::Zero(d));
        hn::StoreU(hn::IfThenElse(keep, hn::LoadU(d, to + x), hn::LoadU(d, filled + x)), d, to + x);
      }
    }
  }
}

void FillIdLevels(const PyramidMask& mask, std::vector<Plane<uint32_t>>* value) {
  for (size_t i = 0; i + 1 < value->size(); ++i) {
    const Plane<uint32_t>& below = (*value)[i];
    Plane<uint32_t>& above = (*value)[i + 1];
    for (int y = 0; y < above.height(); ++y) {
      DownsampleIdRow(ChildrenOf(below, y), ChildrenOf(mask.known[i], y), below.width(),
                      above.width(), above.Row(y));
    }
  }
  for (size_t i = value->size() - 1; i-- > 0;) {
    Plane<uint32_t>& level = (*value)[i];
    for (int y = 0; y < level.height(); ++y) {
      const uint32_t* above = (*value)[i + 1].Row(y / kPyramidFactor);
      const float* known = mask.known[i].Row(y);
      uint32_t* to = level.Row(y);
      for (int x = 0; x < level.width(); ++x) {
        to[x] = known[x] > 0 ? to[x] : above[x / kPyramidFactor];
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

template <typename T>
void MakePlanes(int width, int height, std::vector<Plane<T>>* levels) {
  size_t i = 0;
  do {
    width = CellsOf(width);
    height = CellsOf(height);
    if (levels->size() <= i) {
      levels->emplace_back();
    }
    Plane<T>& level = (*levels)[i++];
    if (level.width() != width || level.height() != height) {
      level = Plane<T>(width, height);
    }
  } while (width > 1 || height > 1);
  levels->resize(i);
}

template <typename T>
size_t BytesOf(const std::vector<Plane<T>>& levels) {
  size_t sum = 0;
  for (const Plane<T>& level : levels) {
    sum += level.bytes();
  }
  return sum;
}

}  // namespace

size_t PyramidMask::bytes() const {
  return BytesOf(known) + BytesOf(inverse);
}

size_t Pyramid::bytes() const {
  return BytesOf(value);
}

size_t IdPyramid::bytes() const {
  return BytesOf(value);
}

namespace cpu {

HWY_EXPORT(DownsampleMaskLevels);
HWY_EXPORT(FillPlaneLevels);
HWY_EXPORT(FillIdLevels);

void ResizePyramid(int width, int height, PyramidMask* mask) {
  MakePlanes(width, height, &mask->known);
  MakePlanes(width, height, &mask->inverse);
}

void ResizePyramid(int width, int height, Pyramid* levels) {
  MakePlanes(width, height, &levels->value);
}

void ResizePyramid(int width, int height, IdPyramid* levels) {
  MakePlanes(width, height, &levels->value);
}

void DownsampleMask(PyramidMask* mask) {
  HWY_DYNAMIC_DISPATCH(DownsampleMaskLevels)(mask);
}

void FillPyramid(const PyramidMask& mask, Pyramid* levels) {
  HWY_DYNAMIC_DISPATCH(FillPlaneLevels)(mask, &levels->value);
}

void FillPyramid(const PyramidMask& mask, IdPyramid* levels) {
  HWY_DYNAMIC_DISPATCH(FillIdLevels)(mask, &levels->value);
}

}  // namespace cpu
}  // namespace stillray
#endif
