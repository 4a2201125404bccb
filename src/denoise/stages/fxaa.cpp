// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/fxaa.h"

#include <algorithm>
#include <cstring>

#include "core/parallel.h"
#include "denoise/row_scratch.h"
#include "denoise/stages/fxaa_pixel.h"
#include "denoise/stages/fxaa_shared.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "denoise/stages/fxaa.cpp"

#include <hwy/foreach_target.h>  // IWYU pragma: keep

#include <hwy/highway.h>

#include "denoise/simd/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace stillray {
namespace HWY_NAMESPACE {
namespace {

/// Radius of the pixels that the filter reads.
constexpr int kReachAround = kFxaaReach + 1;

/// Luminance of some rows of the image and their surroundings, with repeated edges.
class LumaRows {
 public:
  LumaRows(const Image3& colour, int y0, int y1)
      : width_(colour.width()),
        height_(colour.height()),
        first_(std::max(y0 - kReachAround, 0)),
        last_(std::min(y1 + kReachAround, height_) - 1),
        scratch_(width_, last_ - first_ + 1) {
    for (int y = first_; y <= last_; ++y) {
      Fill(colour, y);
    }
  }
  int width() const { return width_; }
  int height() const { return height_; }
  const float* Row(int y) const { return scratch_.Row(std::clamp(y, first_, last_) - first_); }
  float operator()(int x, int y) const { return Row(y)[x]; }

 private:
  void Fill(const Image3& colour, int y) {
    const DF d;
    const VF zero = hn::Zero(d);
    float* to = scratch_.Row(y - first_);
    for (int x = 0; x < width_; x += LaneCount()) {
      // Summed in the order of Luminance709, so that edges equal those of the reference.
      const VF red = hn::Mul(hn::Set(d, 0.2126f), hn::LoadU(d, colour[0].Row(y) + x));
      const VF green = hn::Mul(hn::Set(d, 0.7152f), hn::LoadU(d, colour[1].Row(y) + x));
      const VF blue = hn::Mul(hn::Set(d, 0.0722f), hn::LoadU(d, colour[2].Row(y) + x));
      const VF sum = hn::Add(hn::Add(red, green), blue);
      hn::StoreU(hn::IfThenElse(hn::Lt(sum, zero), zero, sum), d, to + x);
    }
    std::fill_n(to - kReachAround, kReachAround, to[0]);
    std::fill_n(to + width_, kReachAround + LaneCount(), to[width_ - 1]);
  }

  int width_;
  int height_;
  int first_;
  int last_;
  RowScratch scratch_;
};

/// FindFxaaStep of a vector of pixels.
struct Steps {
  VF share;    ///< 0 where there is no edge
  MF along_x;  ///< the edge runs along the row
  MF minus;    ///< the other side is above, or to the left
};

/// Distance along the edge to the end of its step, on one side.
struct EdgeEnd {
  VF reach;
  VF difference;  ///< difference from the middle of the step at the end; 0 if no end is found
};

/// Finds the end of a step on one side; only the lanes `used` are valid.
/// \param sign  -1 or 1: the side
HWY_INLINE EdgeEnd FindEnd(const LumaRows& luma, int x, int y, int sign, const Steps& steps,
                           VF middle, VF least, MF used) {
  const DF d;
  const VF half = hn::Set(d, 0.5f);
  EdgeEnd end = {hn::Set(d, static_cast<float>(kFxaaReach)), hn::Zero(d)};
  for (int i = 1; i <= kFxaaReach && !hn::AllFalse(d, used); ++i) {
    const int shift = sign * i;
    const float* across = luma.Row(y + shift) + x;
    const VF here =
        hn::IfThenElse(steps.along_x, hn::LoadU(d, luma.Row(y) + x + shift), hn::LoadU(d, across));
    const VF above = hn::IfThenElse(steps.along_x, hn::LoadU(d, luma.Row(y - 1) + x + shift),
                                    hn::LoadU(d, across - 1));
    const VF below = hn::IfThenElse(steps.along_x, hn::LoadU(d, luma.Row(y + 1) + x + shift),
                                    hn::LoadU(d, across + 1));
    const VF there = hn::IfThenElse(steps.minus, above, below);
    const VF difference = hn::Sub(hn::Mul(half, hn::Add(here, there)), middle);
    const MF found = hn::And(used, hn::Ge(hn::Abs(difference), least));
    end.reach = hn::IfThenElse(found, hn::Set(d, static_cast<float>(i)), end.reach);
    end.difference = hn::IfThenElse(found, difference, end.difference);
    used = hn::AndNot(found, used);
  }
  return end;
}

HWY_INLINE VF SecondDifference(VF before, VF own, VF after) {
  const DF d;
  return hn::Abs(hn::Sub(hn::Add(before, after), hn::Mul(hn::Set(d, 2.0f), own)));
}

/// \param wanted  lanes whose strength is not 0
HWY_INLINE Steps FindSteps(const LumaRows& luma, int x, int y, MF wanted) {
  const DF d;
  const VF zero = hn::Zero(d);
  const float* row_m = luma.Row(y) + x;
  const float* row_n = luma.Row(y - 1) + x;
  const float* row_s = luma.Row(y + 1) + x;
  const VF m = hn::LoadU(d, row_m);
  const VF n = hn::LoadU(d, row_n);
  const VF s = hn::LoadU(d, row_s);
  const VF w = hn::LoadU(d, row_m - 1);
  const VF e = hn::LoadU(d, row_m + 1);
  VF lowest = m;
  VF highest = m;
  for (const VF v : {n, s, w, e}) {
    lowest = hn::IfThenElse(hn::Lt(v, lowest), v, lowest);  // as std::min treats NaN
    highest = hn::IfThenElse(hn::Lt(highest, v), v, highest);
  }
  const MF edge = hn::And(
      wanted, hn::Gt(hn::Sub(highest, lowest), hn::Mul(highest, hn::Set(d, kFxaaContrast))));
  Steps steps = {zero, edge, edge};
  if (hn::AllFalse(d, edge)) {
    return steps;
  }
  const VF nw = hn::LoadU(d, row_n - 1);
  const VF ne = hn::LoadU(d, row_n + 1);
  const VF sw = hn::LoadU(d, row_s - 1);
  const VF se = hn::LoadU(d, row_s + 1);
  const VF two = hn::Set(d, 2.0f);
  const VF rows =
      hn::Add(hn::Add(hn::Mul(SecondDifference(n, m, s), two), SecondDifference(nw, w, sw)),
              SecondDifference(ne, e, se));
  const VF columns =
      hn::Add(hn::Add(hn::Mul(SecondDifference(w, m, e), two), SecondDifference(nw, n, ne)),
              SecondDifference(sw, s, se));
  steps.along_x = hn::Ge(rows, columns);
  const VF before = hn::IfThenElse(steps.along_x, n, w);
  const VF after = hn::IfThenElse(steps.along_x, s, e);
  steps.minus = hn::Ge(hn::Abs(hn::Sub(before, m)), hn::Abs(hn::Sub(after, m)));
  const VF other = hn::IfThenElse(steps.minus, before, after);
  const VF middle = hn::Mul(hn::Set(d, 0.5f), hn::Add(other, m));
  const VF least = hn::Mul(hn::Set(d, 0.25f), hn::Abs(hn::Sub(other, m)));
  const EdgeEnd back = FindEnd(luma, x, y, -1, steps, middle, least, edge);
  const EdgeEnd ahead = FindEnd(luma, x, y, 1, steps, middle, least, edge);
  const MF is_back = hn::Le(back.reach, ahead.reach);
  const VF half = hn::Set(d, 0.5f);
  const VF near = hn::Sub(hn::IfThenElse(is_back, back.reach, ahead.reach), half);
  const VF far = hn::Sub(hn::IfThenElse(is_back, ahead.reach, back.reach), half);
  const VF difference = hn::IfThenElse(is_back, back.difference, ahead.difference);
  const MF leans =
      hn::Or(hn::Eq(difference, zero), hn::Xor(hn::Gt(difference, zero), hn::Gt(other, m)));
  const VF share = hn::Max(hn::Sub(half, hn::Div(near, hn::Add(near, far))), zero);
  steps.share = hn::IfThenElseZero(hn::AndNot(leans, edge), share);
  return steps;
}

/// FxaaStrength.
HWY_INLINE VF Strength(const Image1* length, int x, int y) {
  const DF d;
  const VF one = hn::Set(d, 1.0f);
  if (length == nullptr) {
    return one;
  }
  const VF young = hn::Sub(hn::Set(d, 4.0f), hn::LoadU(d, length->Row(y) + x));
  return hn::Min(hn::Max(hn::Div(young, hn::Set(d, 3.0f)), hn::Zero(d)), one);
}

void FxaaRow(const Image3& colour, const LumaRows& luma, const Image1* length, int y, Image3* out) {
  const DF d;
  const VF zero = hn::Zero(d);
  const int width = colour.width();
  const int above = std::max(y - 1, 0);
  const int below = std::min(y + 1, colour.height() - 1);
  // Without the first and the last column, whose neighbours are repeated.
  const int lanes = LaneCount();
  const int end = 1 + std::max(width - 2, 0) / lanes * lanes;
  for (int x = 1; x < end; x += lanes) {
    const VF strength = Strength(length, x, y);
    const MF wanted = hn::Gt(strength, zero);
    const Steps steps = FindSteps(luma, x, y, wanted);
    const VF weight = hn::Mul(strength, steps.share);
    const MF changes = hn::Gt(steps.share, zero);
    const bool any = !hn::AllFalse(d, changes);
    for (int c = 0; c < 3; ++c) {
      const float* row = colour[c].Row(y) + x;
      VF own = hn::LoadU(d, row);
      if (any) {
        const VF minus = hn::IfThenElse(steps.along_x, hn::LoadU(d, colour[c].Row(above) + x),
                                        hn::LoadU(d, row - 1));
        const VF plus = hn::IfThenElse(steps.along_x, hn::LoadU(d, colour[c].Row(below) + x),
                                       hn::LoadU(d, row + 1));
        const VF other = hn::IfThenElse(steps.minus, minus, plus);
        own = hn::IfThenElse(changes, hn::Add(own, hn::Mul(weight, hn::Sub(other, own))), own);
      }
      hn::StoreU(own, d, (*out)[c].Row(y) + x);
    }
  }
  FxaaPixel(colour, luma, length, 0, y, out);
  for (int x = end; x < width; ++x) {
    FxaaPixel(colour, luma, length, x, y, out);
  }
}

/// Whether FxaaStrength is positive anywhere in the row.
bool AnyYoung(const Image1* length, int y) {
  if (length == nullptr) {
    return true;
  }
  const DF d;
  for (int x = 0; x < length->width(); x += LaneCount()) {
    const MF young = hn::Lt(hn::LoadU(d, length->Row(y) + x), hn::Set(d, 4.0f));
    if (!hn::AllFalse(d, hn::And(young, InRow(x, length->width())))) {
      return true;
    }
  }
  return false;
}

void FxaaRows(const Image3& colour, const Image1* length, int y0, int y1, Image3* out) {
  bool young = false;
  for (int y = y0; y < y1 && !young; ++y) {
    young = AnyYoung(length, y);
  }
  if (!young) {
    for (int y = y0; y < y1; ++y) {
      for (int c = 0; c < 3; ++c) {
        std::copy_n(colour[c].Row(y), colour.width(), (*out)[c].Row(y));
      }
    }
    return;
  }
  const LumaRows luma(colour, y0, y1);
  for (int y = y0; y < y1; ++y) {
    FxaaRow(colour, luma, length, y, out);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stillray
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stillray::cpu {

HWY_EXPORT(FxaaRows);

void Fxaa(const Image3& colour, const Image1* length, Image3* out) {
  // Luminance is recomputed for the rows around a band, so bands are as wide as the cache allows.
  constexpr int kBand = 40;
  ParallelRows(colour.height(), kBand, [&](int y0, int y1) {
    HWY_DYNAMIC_DISPATCH(FxaaRows)(colour, length, y0, y1, out);
  });
}

}  // namespace stillray::cpu
#endif
