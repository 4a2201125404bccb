// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace stillray {

/// The middle value in ascending order, the upper one of two; 0 if there is no value. Values must
/// not be NaN.
template <typename T>
T Median(std::vector<T> values) {
  if (values.empty()) {
    return T(0);
  }
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace stillray
