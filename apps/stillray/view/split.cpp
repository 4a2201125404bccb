// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/split.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace stillray::view {
namespace {

constexpr float kLeast = 0.01f;  // of the width, that each pane keeps
constexpr uint8_t kLine = 230;

}  // namespace

std::vector<float> PaneEnds(const std::vector<float>& dividers, int count) {
  std::vector<float> ends;
  float previous = 0;
  for (int i = 0; i + 1 < count; ++i) {
    const auto place = static_cast<size_t>(i);
    const float even = static_cast<float>(i + 1) / static_cast<float>(count);
    const float wanted = place < dividers.size() ? dividers[place] : even;
    const float last = 1 - kLeast * static_cast<float>(count - 1 - i);
    previous = std::clamp(wanted, previous + kLeast, last);
    ends.push_back(previous);
  }
  ends.push_back(1);
  return ends;
}

Rgb8Image ComposePanes(const std::vector<Rgb8Image>& pictures, const std::vector<float>& dividers) {
  Rgb8Image composed = pictures[0];
  const std::vector<float> ends = PaneEnds(dividers, static_cast<int>(pictures.size()));
  const auto row_bytes = static_cast<size_t>(composed.width) * 3;
  for (size_t i = 0; i + 1 < pictures.size(); ++i) {
    const int from =
        std::min(static_cast<int>(std::lround(ends[i] * static_cast<float>(composed.width))),
                 composed.width - 1);
    const auto offset = static_cast<size_t>(from) * 3;
    for (int y = 0; y < composed.height; ++y) {
      const size_t row = static_cast<size_t>(y) * row_bytes;
      std::memcpy(composed.pixels.data() + row + offset,
                  pictures[i + 1].pixels.data() + row + offset, row_bytes - offset);
      std::memset(composed.pixels.data() + row + offset, kLine, 3);
    }
  }
  return composed;
}

}  // namespace stillray::view
