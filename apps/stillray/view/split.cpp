// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/split.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "view/taps.h"

namespace stillray::view {
namespace {

constexpr float kLeast = 0.01f;  // minimum fraction of the width for each pane
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

Rgb8Image EnlargedTo(int width, int height, bool sharp, Rgb8Image picture) {
  if (picture.width >= width && picture.height >= height) {
    return picture;
  }
  Rgb8Image large = {width, height, {}};
  large.pixels.resize(static_cast<size_t>(width) * height * 3);
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      const Taps v = TapsAt(y, height, picture.height, sharp);
      for (int x = 0; x < width; ++x) {
        const Taps u = TapsAt(x, width, picture.width, sharp);
        for (int c = 0; c < 3; ++c) {
          const auto at = [&](int px, int py) {
            return static_cast<float>(
                picture.pixels[(static_cast<size_t>(py) * picture.width + px) * 3 + c]);
          };
          const float top = Mixed(at(u.first, v.first), at(u.second, v.first), u.weight);
          const float bottom = Mixed(at(u.first, v.second), at(u.second, v.second), u.weight);
          large.pixels[(static_cast<size_t>(y) * width + x) * 3 + c] =
              static_cast<uint8_t>(std::lround(Mixed(top, bottom, v.weight)));
        }
      }
    }
  });
  return large;
}

}  // namespace stillray::view
