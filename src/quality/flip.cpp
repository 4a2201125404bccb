// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// LDR-FLIP: Andersson et al., "FLIP: A Difference Evaluator for Alternating Images" (2020), section
// 4, for 67 pixels per degree; HDR-FLIP takes its maximum over exposures (see hdr_flip.cpp).
// Images are extended by repeating their border pixels.
//
// Images are processed in tiles, with all exposures of a tile at once, so that intermediate
// planes stay in cache. The order of operations for a pixel does not depend on its tile.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "quality/filter_taps.h"
#include "quality/flip_colour.h"
#include "quality/flip_tonemap.h"
#include "quality/metrics.h"

namespace stillray::quality {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kPixelsPerDegree = 67.0;
constexpr int kTileWidth = 256;
constexpr int kTileHeight = 64;

/// Section 4.1.1, table 1: sums of Gaussians that approximate the contrast sensitivity functions of
/// the opponent channels.
struct SensitivityGaussian {
  double a;
  double b;
};
constexpr SensitivityGaussian kAchromatic = {1.0, 0.0047};
constexpr SensitivityGaussian kRedGreen = {1.0, 0.0053};
constexpr std::array<SensitivityGaussian, 2> kBlueYellow = {{{34.1, 0.04}, {13.5, 0.025}}};

constexpr double kFeatureWidth = 0.082;    // section 4.2: width of edges and points in degrees
constexpr float kColourExponent = 0.7f;    // q_c
constexpr float kColourKnee = 0.4f;        // p_c
constexpr float kColourKneeError = 0.95f;  // p_t
// The exponent q_f of the feature error is 0.5: a square root.

using Kernel = std::vector<float>;

/// exp(-pi^2 x^2 / b) at pixel centres, not normalised. All sensitivity kernels have the radius of
/// three standard deviations of the widest one.
std::vector<double> SensitivityProfile(double b) {
  const double widest = std::sqrt(kBlueYellow[0].b / (2.0 * kPi * kPi));
  const int radius = static_cast<int>(std::ceil(3.0 * widest * kPixelsPerDegree));
  std::vector<double> profile;
  for (int i = -radius; i <= radius; ++i) {
    const double x = i / kPixelsPerDegree;
    profile.push_back(std::exp(-kPi * kPi * x * x / b));
  }
  return profile;
}

double Sum(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return sum;
}

/// Divides positive values by their sum, and negative ones by the magnitude of theirs.
Kernel NormaliseBySign(const std::vector<double>& values) {
  double positive = 0;
  double negative = 0;
  for (const double value : values) {
    (value > 0 ? positive : negative) += std::abs(value);
  }
  Kernel kernel;
  for (const double value : values) {
    kernel.push_back(static_cast<float>(value / (value > 0 ? positive : negative)));
  }
  return kernel;
}

/// All filters of FLIP as one-dimensional kernels of odd length.
struct Kernels {
  Kernel achromatic;
  Kernel red_green;
  // The sum of two Gaussians of x^2 + y^2 is not separable, but each of the two is.
  std::array<Kernel, 2> blue_yellow;
  std::array<float, 2> blue_yellow_share;
  // The feature detectors are products of a profile along one axis and a Gaussian along the other.
  // Their signs change with the profile alone, so normalising the profile normalises the product.
  Kernel gaussian;
  Kernel edge;
  Kernel point;

  int SensitivityRadius() const { return static_cast<int>(achromatic.size() / 2); }
  int FeatureRadius() const { return static_cast<int>(gaussian.size() / 2); }
  int Radius() const { return std::max(SensitivityRadius(), FeatureRadius()); }
};

Kernels MakeKernels() {
  Kernels k;
  k.achromatic = NormaliseBySign(SensitivityProfile(kAchromatic.b));
  k.red_green = NormaliseBySign(SensitivityProfile(kRedGreen.b));
  std::array<double, 2> mass = {};
  for (size_t i = 0; i < 2; ++i) {
    const std::vector<double> profile = SensitivityProfile(kBlueYellow[i].b);
    k.blue_yellow[i] = NormaliseBySign(profile);
    mass[i] = kBlueYellow[i].a * std::sqrt(kPi / kBlueYellow[i].b) * Sum(profile) * Sum(profile);
  }
  for (size_t i = 0; i < 2; ++i) {
    k.blue_yellow_share[i] = static_cast<float>(mass[i] / (mass[0] + mass[1]));
  }
  const double sigma = 0.5 * kFeatureWidth * kPixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> gaussian, edge, point;
  for (int i = -radius; i <= radius; ++i) {
    const double value = std::exp(-0.5 * i * i / (sigma * sigma));
    gaussian.push_back(value);
    edge.push_back(-i * value);
    point.push_back((i * i / (sigma * sigma) - 1.0) * value);
  }
  k.gaussian = NormaliseBySign(gaussian);
  k.edge = NormaliseBySign(edge);
  k.point = NormaliseBySign(point);
  return k;
}

const Kernels& AllKernels() {
  static const Kernels kernels = MakeKernels();
  return kernels;
}

/// Section 4.1.4: the largest colour difference inside the sRGB cube, between green and blue.
float GreatestColourDifference() {
  static const float greatest = std::pow(
      HyAb(HuntLabOfXyz(XyzOfRgb(0, 1, 0)), HuntLabOfXyz(XyzOfRgb(0, 0, 1))), kColourExponent);
  return greatest;
}

/// Maps 0..p_c c_max to 0..p_t and the rest to p_t..1.
float ColourError(const HuntLab& test, const HuntLab& reference) {
  const float greatest = GreatestColourDifference();
  const float knee = kColourKnee * greatest;
  const float difference = std::pow(HyAb(test, reference), kColourExponent);
  if (difference < knee) {
    return kColourKneeError / knee * difference;
  }
  return std::min(
      1.0f, kColourKneeError + (difference - knee) / (greatest - knee) * (1.0f - kColourKneeError));
}

/// The features of one pixel that FLIP compares.
struct Appearance {
  HuntLab colour;
  float edge = 0;
  float point = 0;
};

float FlipError(const Appearance& test, const Appearance& reference) {
  const float colour = ColourError(test.colour, reference.colour);
  const float feature =
      std::max(std::abs(reference.edge - test.edge), std::abs(reference.point - test.point));
  constexpr float kInverseRoot2 = 0.70710678f;
  const float feature_error = std::min(1.0f, std::sqrt(kInverseRoot2 * feature));
  return colour > 0 ? std::pow(colour, 1.0f - feature_error) : 0.0f;
}

struct Tile {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

/// Computes the appearance of one tile; holds its intermediate planes.
class TileFilter {
 public:
  /// Fills `out` (tile.width * tile.height) with the appearance of the tile's pixels.
  void Run(const Image3& image, const Exposure& exposure, const Tile& tile, Appearance* out) {
    FilterRows(image, exposure, tile);
    for (int y = 0; y < tile.height; ++y) {
      FilterColumnsOfRow(y, tile.width);
      Appearance* row = out + static_cast<ptrdiff_t>(y) * tile.width;
      for (int x = 0; x < tile.width; ++x) {
        row[x] = AppearanceAt(static_cast<size_t>(x));
      }
    }
  }

 private:
  // Filtered along rows: opponent channels for the colours, luminance for the features.
  enum RowPlane { kRowA, kRowRg, kRowBy0, kRowBy1, kRowGaussian, kRowEdge, kRowPoint, kRowPlanes };
  enum Feature { kA, kRg, kBy0, kBy1, kEdgeX, kEdgeY, kPointX, kPointY, kFeatures };
  static constexpr size_t kStride = kTileWidth;

  void FilterRows(const Image3& image, const Exposure& exposure, const Tile& tile) {
    const Kernels& k = AllKernels();
    const int radius = k.Radius();
    const size_t feature_inset = static_cast<size_t>(radius - k.FeatureRadius());
    const size_t colour_inset = static_cast<size_t>(radius - k.SensitivityRadius());
    for (std::vector<float>& plane : rows_) {
      plane.resize(kStride * static_cast<size_t>(kTileHeight + 2 * radius));
    }
    for (std::vector<float>& source : source_) {
      source.resize(kStride + 2 * static_cast<size_t>(radius));
    }
    for (int y = 0; y < tile.height + 2 * radius; ++y) {
      ReadRow(image, exposure, tile.x - radius, tile.y + y - radius, tile.width + 2 * radius);
      const auto filter = [&](size_t source, size_t inset, const Kernel& kernel, RowPlane plane) {
        FilterTaps(source_[source].data() + inset, 1, kernel, tile.width,
                   &rows_[plane][kStride * static_cast<size_t>(y)]);
      };
      filter(0, colour_inset, k.achromatic, kRowA);
      filter(1, colour_inset, k.red_green, kRowRg);
      filter(2, colour_inset, k.blue_yellow[0], kRowBy0);
      filter(2, colour_inset, k.blue_yellow[1], kRowBy1);
      filter(0, feature_inset, k.gaussian, kRowGaussian);
      filter(0, feature_inset, k.edge, kRowEdge);
      filter(0, feature_inset, k.point, kRowPoint);
    }
  }

  /// The opponent channels Y, X - Y and Y - Z of part of a row: the paper's YCxCz (eq. 4 to 6)
  /// without its factors and offset, which normalised filters preserve.
  void ReadRow(const Image3& image, const Exposure& exposure, int x0, int y, int width) {
    const int row = std::clamp(y, 0, image.height() - 1);
    const FlipTonemap tonemap(exposure);
    for (int i = 0; i < width; ++i) {
      const int x = std::clamp(x0 + i, 0, image.width() - 1);
      const RelativeXyz c =
          XyzOfRgb(tonemap(image[0](x, row)), tonemap(image[1](x, row)), tonemap(image[2](x, row)));
      const size_t at = static_cast<size_t>(i);
      source_[0][at] = c.y;
      source_[1][at] = c.x - c.y;
      source_[2][at] = c.y - c.z;
    }
  }

  void FilterColumnsOfRow(int y, int width) {
    const Kernels& k = AllKernels();
    const auto filter = [&](RowPlane plane, const Kernel& kernel, Feature result) {
      const int inset = k.Radius() - static_cast<int>(kernel.size() / 2);
      FilterTaps(&rows_[plane][kStride * static_cast<size_t>(y + inset)], kStride, kernel, width,
                 results_[result].data());
    };
    filter(kRowA, k.achromatic, kA);
    filter(kRowRg, k.red_green, kRg);
    filter(kRowBy0, k.blue_yellow[0], kBy0);
    filter(kRowBy1, k.blue_yellow[1], kBy1);
    filter(kRowEdge, k.gaussian, kEdgeX);
    filter(kRowGaussian, k.edge, kEdgeY);
    filter(kRowPoint, k.gaussian, kPointX);
    filter(kRowGaussian, k.point, kPointY);
  }

  Appearance AppearanceAt(size_t x) const {
    const Kernels& k = AllKernels();
    const float luminance = results_[kA][x];
    const float x_minus_y = results_[kRg][x];
    const float y_minus_z =
        k.blue_yellow_share[0] * results_[kBy0][x] + k.blue_yellow_share[1] * results_[kBy1][x];
    const RelativeXyz filtered = {luminance + x_minus_y, luminance, luminance - y_minus_z};
    const auto length = [](float a, float b) { return std::sqrt(a * a + b * b); };
    return {HuntLabOfXyz(ClipToDisplay(filtered)), length(results_[kEdgeX][x], results_[kEdgeY][x]),
            length(results_[kPointX][x], results_[kPointY][x])};
  }

  std::array<std::vector<float>, 3> source_;
  std::array<std::vector<float>, kRowPlanes> rows_;
  std::array<std::array<float, kTileWidth>, kFeatures> results_ = {};
};

/// Updates `map` with the maximum of itself and the errors of one tile.
void FlipTile(const PicturePair& pair, const std::vector<Exposure>& exposures, const Tile& tile,
              TileFilter* filter, Image1* map) {
  const size_t count = static_cast<size_t>(tile.width) * static_cast<size_t>(tile.height);
  std::vector<Appearance> test(count);
  std::vector<Appearance> reference(count);
  for (const Exposure& exposure : exposures) {
    filter->Run(pair.test, exposure, tile, test.data());
    filter->Run(pair.reference, exposure, tile, reference.data());
    size_t i = 0;
    for (int y = tile.y; y < tile.y + tile.height; ++y) {
      for (int x = tile.x; x < tile.x + tile.width; ++x, ++i) {
        (*map)(x, y) = std::max((*map)(x, y), FlipError(test[i], reference[i]));
      }
    }
  }
}

}  // namespace

Image1 FlipErrorMap(const PicturePair& pair, const std::vector<Exposure>& exposures) {
  Image1 map(pair.width(), pair.height());
  ParallelRows(pair.height(), kTileHeight, [&](int y0, int y1) {
    TileFilter filter;
    for (int x = 0; x < pair.width(); x += kTileWidth) {
      const Tile tile = {x, y0, std::min(kTileWidth, pair.width() - x), y1 - y0};
      FlipTile(pair, exposures, tile, &filter, &map);
    }
  });
  return map;
}

}  // namespace stillray::quality
