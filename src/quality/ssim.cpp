// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility to
// Structural Similarity" (2004), eq. 13 with the Gaussian window of section III.B: 11x11, standard
// deviation 1.5, K1 = 0.01, K2 = 0.03. Departs from it at the border: windows are clipped there and
// their weights renormalised, so that every pixel has a value.
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "quality/filter_taps.h"
#include "quality/metrics.h"
#include "quality/row_sums.h"

namespace stillray::quality {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;
constexpr double kC1 = 0.01 * 0.01;  // (K1 L)^2 and (K2 L)^2 with L = 1, the range of CompressValue
constexpr double kC2 = 0.03 * 0.03;
constexpr int kBand = 32;

std::vector<double> WindowWeights() {
  std::vector<double> weights;
  for (int i = -kRadius; i <= kRadius; ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (kSigma * kSigma)));
  }
  return weights;
}

/// For each position in 0..length-1 the sum of the weights inside the image.
std::vector<double> WeightSums(const std::vector<double>& weights, int length) {
  std::vector<double> sums;
  for (int i = 0; i < length; ++i) {
    double sum = 0;
    for (int k = -kRadius; k <= kRadius; ++k) {
      sum += i + k >= 0 && i + k < length ? weights[static_cast<size_t>(k + kRadius)] : 0.0;
    }
    sums.push_back(sum);
  }
  return sums;
}

double Luma(const Image3& image, int x, int y, bool display) {
  return 0.2126 * CompressValue(image[0](x, y), display) +
         0.7152 * CompressValue(image[1](x, y), display) +
         0.0722 * CompressValue(image[2](x, y), display);
}

/// The window's means of test, reference, their squares and their product.
using Moments = std::array<double, 5>;

double Ssim(const Moments& m) {
  const double variance_test = m[2] - m[0] * m[0];
  const double variance_reference = m[3] - m[1] * m[1];
  const double covariance = m[4] - m[0] * m[1];
  return (2.0 * m[0] * m[1] + kC1) * (2.0 * covariance + kC2) /
         ((m[0] * m[0] + m[1] * m[1] + kC1) * (variance_test + variance_reference + kC2));
}

/// A window of rows of the five products, each filtered along the row, and zero outside the image.
class FilteredRows {
 public:
  FilteredRows(const PicturePair& pair, const std::vector<double>& weights, int y0, int y1)
      : width_(pair.width()), stride_(static_cast<size_t>(pair.width())) {
    const int first = y0 - kRadius;
    const int last = y1 + kRadius;
    for (std::vector<double>& plane : planes_) {
      plane.resize(stride_ * static_cast<size_t>(last - first));
    }
    std::array<std::vector<double>, 5> padded;
    padded.fill(std::vector<double>(stride_ + 2 * kRadius));
    for (int y = std::max(first, 0); y < std::min(last, pair.height()); ++y) {
      for (int x = 0; x < width_; ++x) {
        const double t = Luma(pair.test, x, y, pair.display);
        const double r = Luma(pair.reference, x, y, pair.display);
        const std::array<double, 5> products = {t, r, t * t, r * r, t * r};
        for (size_t i = 0; i < products.size(); ++i) {
          padded[i][static_cast<size_t>(x + kRadius)] = products[i];
        }
      }
      for (size_t i = 0; i < padded.size(); ++i) {
        FilterTaps(padded[i].data(), 1, weights, width_,
                   &planes_[i][stride_ * static_cast<size_t>(y - first)]);
      }
    }
  }

  /// Filters down the columns, centred on the row `row` rows below y0.
  void FilterDown(int row, const std::vector<double>& weights,
                  std::array<std::vector<double>, 5>* out) const {
    for (size_t i = 0; i < planes_.size(); ++i) {
      FilterTaps(&planes_[i][stride_ * static_cast<size_t>(row)], stride_, weights, width_,
                 (*out)[i].data());
    }
  }

 private:
  int width_;
  size_t stride_;
  std::array<std::vector<double>, 5> planes_;
};

}  // namespace

Image1 SsimErrorMap(const PicturePair& pair) {
  const std::vector<double> weights = WindowWeights();
  const std::vector<double> column_sums = WeightSums(weights, pair.width());
  const std::vector<double> row_sums = WeightSums(weights, pair.height());
  Image1 map(pair.width(), pair.height());
  ParallelRows(pair.height(), kBand, [&](int y0, int y1) {
    const FilteredRows rows(pair, weights, y0, y1);
    std::array<std::vector<double>, 5> sums;
    sums.fill(std::vector<double>(static_cast<size_t>(pair.width())));
    for (int y = y0; y < y1; ++y) {
      rows.FilterDown(y - y0, weights, &sums);
      for (int x = 0; x < pair.width(); ++x) {
        const size_t column = static_cast<size_t>(x);
        const double total = column_sums[column] * row_sums[static_cast<size_t>(y)];
        Moments moments;
        for (size_t i = 0; i < moments.size(); ++i) {
          moments[i] = sums[i][column] / total;
        }
        // |SSIM| <= 1; rounding must not make the error negative.
        map(x, y) = static_cast<float>(std::max(0.0, 1.0 - Ssim(moments)));
      }
    }
  });
  return map;
}

}  // namespace stillray::quality
