// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/view_range.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace stillray::view {
namespace {

constexpr double kShareBelow = 0.99;  // excludes outliers such as fireflies from the range
constexpr float kLeastTop = 1.0f / 4096;

}  // namespace

float ViewRange::At(float value) const {
  return logarithmic ? std::log2(1 + value) / std::log2(1 + top) : value / top;
}

float FittedTop(std::vector<float>* values) {
  std::erase_if(*values, [](float value) { return !std::isfinite(value); });
  if (values->empty()) {
    return kLeastTop;
  }
  const auto place = static_cast<ptrdiff_t>(kShareBelow * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), values->begin() + place, values->end());
  const float high = (*values)[static_cast<size_t>(place)];
  return high > kLeastTop ? std::exp2(std::ceil(std::log2(high))) : kLeastTop;
}

}  // namespace stillray::view
