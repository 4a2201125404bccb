// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "quality/metrics.h"

namespace stillray::quality {
namespace {

/// Minimum excess of a speck's distance from its neighbourhood over the reference's: 10 of 255
/// display values.
constexpr float kLeastDistance = 0.04f;
constexpr int kBand = 16;

Image1 CompressedLuminanceOf(const PicturePair& pair, const Image3& image) {
  Image1 light(pair.width(), pair.height());
  ParallelRows(pair.height(), kBand, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < pair.width(); ++x) {
        light(x, y) = static_cast<float>(CompressedLuminance(image, x, y, pair.display));
      }
    }
  });
  return light;
}

float Middle(float a, float b, float c) {
  return std::max(std::min(a, b), std::min(std::max(a, b), c));
}

/// Any window, also one clipped at the border; for an even number of pixels, the mean of the two
/// middle values.
float MedianOfWindow(const Image1& light, int x, int y) {
  std::array<float, 9> values;
  size_t count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, light.height() - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, light.width() - 1); ++u) {
      // Insertion sort, which is fast for few values.
      size_t at = count++;
      for (; at > 0 && values[at - 1] > light(u, v); --at) {
        values[at] = values[at - 1];
      }
      values[at] = light(u, v);
    }
  }
  return 0.5f * (values[(count - 1) / 2] + values[count / 2]);
}

/// The columns of three pixels of one row of windows, each sorted, which neighbouring windows
/// share.
class SortedColumns {
 public:
  explicit SortedColumns(int width) {
    for (std::vector<float>* values : {&low_, &middle_, &high_}) {
      values->resize(static_cast<size_t>(width));
    }
  }

  /// \param y  not the first and not the last row
  void Sort(const Image1& light, int y) {
    const float* above = light.Row(y - 1);
    const float* at = light.Row(y);
    const float* below = light.Row(y + 1);
    for (size_t x = 0; x < low_.size(); ++x) {
      low_[x] = std::min(std::min(above[x], at[x]), below[x]);
      middle_[x] = Middle(above[x], at[x], below[x]);
      high_[x] = std::max(std::max(above[x], at[x]), below[x]);
    }
  }

  /// \param x  not the first and not the last column
  float Median(size_t x) const {
    return Middle(std::max(std::max(low_[x - 1], low_[x]), low_[x + 1]),
                  Middle(middle_[x - 1], middle_[x], middle_[x + 1]),
                  std::min(std::min(high_[x - 1], high_[x]), high_[x + 1]));
  }

 private:
  std::vector<float> low_, middle_, high_;
};

/// The distances of one row's pixels from the medians of their windows.
void FindDistances(const Image1& light, int y, SortedColumns* columns,
                   std::vector<float>* distances) {
  const int width = light.width();
  const bool inside = y > 0 && y < light.height() - 1;
  if (inside) {
    columns->Sort(light, y);
  }
  for (int x = 0; x < width; ++x) {
    const size_t column = static_cast<size_t>(x);
    const float median =
        inside && x > 0 && x < width - 1 ? columns->Median(column) : MedianOfWindow(light, x, y);
    (*distances)[column] = light(x, y) - median;
  }
}

struct Counts {
  int64_t bright = 0;
  int64_t dark = 0;
};

Counts CountInRow(const PicturePair& pair, int y, const std::vector<float>& test,
                  const std::vector<float>& reference) {
  Counts counts;
  for (int x = 0; x < pair.width(); ++x) {
    const float t = test[static_cast<size_t>(x)];
    const float r = reference[static_cast<size_t>(x)];
    if (pair.valid(x, y) != 0) {
      counts.bright += t - std::max(r, 0.0f) > kLeastDistance;
      counts.dark += -t - std::max(-r, 0.0f) > kLeastDistance;
    }
  }
  return counts;
}

}  // namespace

SpeckShares FindSpecks(const PicturePair& pair) {
  const Image1 test = CompressedLuminanceOf(pair, pair.test);
  const Image1 reference = CompressedLuminanceOf(pair, pair.reference);
  std::vector<Counts> rows(static_cast<size_t>(pair.height()));
  ParallelRows(pair.height(), kBand, [&](int y0, int y1) {
    SortedColumns columns(pair.width());
    std::vector<float> test_distances(static_cast<size_t>(pair.width()));
    std::vector<float> reference_distances = test_distances;
    for (int y = y0; y < y1; ++y) {
      FindDistances(test, y, &columns, &test_distances);
      FindDistances(reference, y, &columns, &reference_distances);
      rows[static_cast<size_t>(y)] = CountInRow(pair, y, test_distances, reference_distances);
    }
  });
  Counts total;
  for (const Counts& row : rows) {
    total.bright += row.bright;
    total.dark += row.dark;
  }
  const double unit = 1e4 / static_cast<double>(pair.valid_count);
  return {static_cast<double>(total.bright) * unit, static_cast<double>(total.dark) * unit};
}

}  // namespace stillray::quality
