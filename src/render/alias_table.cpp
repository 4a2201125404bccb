// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/alias_table.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace stillray::render {

void FillAliasTable(const float* weights, size_t count, AliasEntry* table) {
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += weights[i];
  }
  if (!(sum > 0)) {
    for (size_t i = 0; i < count; ++i) {
      table[i] = {1.0f, 0u, 0.0f, table[i].item};
    }
    return;
  }
  std::vector<double> height(count);  // height of each column, with mean 1
  std::vector<uint32_t> low;
  std::vector<uint32_t> high;
  for (size_t i = 0; i < count; ++i) {
    const double probability = weights[i] / sum;
    height[i] = probability * static_cast<double>(count);
    table[i] = {1.0f, static_cast<uint32_t>(i), static_cast<float>(probability), table[i].item};
    (height[i] < 1 ? low : high).push_back(static_cast<uint32_t>(i));
  }
  while (!low.empty() && !high.empty()) {
    const uint32_t small = low.back();
    const uint32_t large = high.back();
    low.pop_back();
    table[small].keep = static_cast<float>(height[small]);
    table[small].other = large;
    height[large] -= 1 - height[small];
    if (height[large] < 1) {
      high.pop_back();
      low.push_back(large);
    }
  }
  // The remaining columns have height 1 up to rounding, except for entries with weight zero.
  for (const uint32_t i : low) {
    if (weights[i] == 0) {
      table[i].keep = 0.0f;
      table[i].other = static_cast<uint32_t>(std::max_element(weights, weights + count) - weights);
    }
  }
}

}  // namespace stillray::render
