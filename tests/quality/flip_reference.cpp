// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "flip_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stillray::flip_reference {
namespace {

using Vec = std::array<double, 3>;
using Matrix = std::array<Vec, 3>;
using Field = std::vector<Vec>;

constexpr double kPi = 3.141592653589793;

Vec Times(const Matrix& m, const Vec& v) {
  Vec out = {};
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      out[i] += m[i][j] * v[j];
    }
  }
  return out;
}

/// Gauss-Jordan elimination with pivoting.
Matrix Inverse(Matrix m) {
  Matrix inverse = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (size_t i = 0; i < 3; ++i) {
    size_t pivot = i;
    for (size_t r = i; r < 3; ++r) {
      pivot = std::abs(m[r][i]) > std::abs(m[pivot][i]) ? r : pivot;
    }
    std::swap(m[i], m[pivot]);
    std::swap(inverse[i], inverse[pivot]);
    const double scale = m[i][i];
    for (size_t j = 0; j < 3; ++j) {
      m[i][j] /= scale;
      inverse[i][j] /= scale;
    }
    for (size_t r = 0; r < 3; ++r) {
      const double factor = m[r][i];
      for (size_t j = 0; j < 3 && r != i; ++j) {
        m[r][j] -= factor * m[i][j];
        inverse[r][j] -= factor * inverse[i][j];
      }
    }
  }
  return inverse;
}

Vec XyzOfChromaticity(double x, double y) {
  return {x / y, 1.0, (1.0 - x - y) / y};
}

const Vec& White() {
  static const Vec white = XyzOfChromaticity(0.3127, 0.3290);
  return white;
}

/// From the chromaticities that ITU-R BT.709 and sRGB define.
const Matrix& XyzOfRgb() {
  static const Matrix matrix = [] {
    const std::array<Vec, 3> primaries = {XyzOfChromaticity(0.64, 0.33),
                                          XyzOfChromaticity(0.30, 0.60),
                                          XyzOfChromaticity(0.15, 0.06)};
    Matrix columns;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) {
        columns[i][j] = primaries[j][i];
      }
    }
    const Vec scale = Times(Inverse(columns), White());
    for (Vec& row : columns) {
      for (size_t j = 0; j < 3; ++j) {
        row[j] *= scale[j];
      }
    }
    return columns;
  }();
  return matrix;
}

Vec YCxCzOfRgb(const Vec& rgb) {
  const Vec xyz = Times(XyzOfRgb(), rgb);
  const double x = xyz[0] / White()[0], y = xyz[1] / White()[1], z = xyz[2] / White()[2];
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

Vec RgbOfYCxCz(const Vec& c) {
  static const Matrix inverse = Inverse(XyzOfRgb());
  const double y = (c[0] + 16) / 116;
  const double x = y + c[1] / 500;
  const double z = y - c[2] / 200;
  return Times(inverse, {x * White()[0], y * White()[1], z * White()[2]});
}

Vec HuntLab(const Vec& rgb) {
  const Vec xyz = Times(XyzOfRgb(), rgb);
  Vec f;
  for (size_t i = 0; i < 3; ++i) {
    const double t = xyz[i] / White()[i];
    f[i] = t > std::pow(6.0 / 29, 3) ? std::pow(t, 1.0 / 3) : t * 841.0 / 108 + 4.0 / 29;
  }
  const double l = 116 * f[1] - 16;
  return {l, 500 * (f[0] - f[1]) * l / 100, 200 * (f[1] - f[2]) * l / 100};
}

double HyAb(const Vec& p, const Vec& q) {
  return std::abs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]);
}

/// A square kernel: weights of offsets -radius..radius in x and y.
struct Kernel {
  int radius = 0;
  std::vector<double> weights;
};

Kernel MakeKernel(int radius, const std::function<double(int, int)>& weight) {
  Kernel kernel{radius, {}};
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      kernel.weights.push_back(weight(x, y));
    }
  }
  double positive = 0, negative = 0;
  for (const double w : kernel.weights) {
    positive += std::max(w, 0.0);
    negative += std::max(-w, 0.0);
  }
  for (double& w : kernel.weights) {
    w /= w > 0 ? positive : (negative > 0 ? negative : 1.0);
  }
  return kernel;
}

double Convolve(const Field& field, size_t channel, int width, int height, int px, int py,
                const Kernel& kernel) {
  double sum = 0;
  size_t i = 0;
  for (int dy = -kernel.radius; dy <= kernel.radius; ++dy) {
    for (int dx = -kernel.radius; dx <= kernel.radius; ++dx, ++i) {
      const int x = std::clamp(px + dx, 0, width - 1);
      const int y = std::clamp(py + dy, 0, height - 1);
      sum += kernel.weights[i] * field[static_cast<size_t>(y * width + x)][channel];
    }
  }
  return sum;
}

constexpr double kPpd = 67;

const std::array<Kernel, 3>& Sensitivity() {
  static const std::array<Kernel, 3> kernels = [] {
    struct Row {
      double a1, b1, a2, b2;
    };
    constexpr std::array<Row, 3> kTable = {
        {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * kPpd));
    std::array<Kernel, 3> made;
    for (size_t c = 0; c < 3; ++c) {
      made[c] = MakeKernel(radius, [&](int x, int y) {
        const Row& t = kTable[c];
        const double d2 = (x * x + y * y) / (kPpd * kPpd);
        return t.a1 * std::sqrt(kPi / t.b1) * std::exp(-kPi * kPi * d2 / t.b1) +
               t.a2 * std::sqrt(kPi / t.b2) * std::exp(-kPi * kPi * d2 / t.b2);
      });
    }
    return made;
  }();
  return kernels;
}

/// Derivative of a Gaussian in x (order 1 or 2), or in y with `swap`.
Kernel FeatureKernel(int order, bool swap) {
  const double sigma = 0.5 * 0.082 * kPpd;
  return MakeKernel(static_cast<int>(std::ceil(3 * sigma)), [=](int kx, int ky) {
    const double x = swap ? ky : kx;
    const double gaussian = std::exp(-(kx * kx + ky * ky) / (2 * sigma * sigma));
    return order == 1 ? -x * gaussian : (x * x / (sigma * sigma) - 1) * gaussian;
  });
}

struct Appearance {
  Vec lab;
  double edge;
  double point;
};

std::vector<Appearance> Appearances(const Image3& image) {
  static const std::array<Kernel, 4> features = {FeatureKernel(1, false), FeatureKernel(1, true),
                                                 FeatureKernel(2, false), FeatureKernel(2, true)};
  const int width = image.width(), height = image.height();
  Field opponent;
  Field luminance;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      opponent.push_back(YCxCzOfRgb({image[0](x, y), image[1](x, y), image[2](x, y)}));
      luminance.push_back({(opponent.back()[0] + 16) / 116, 0, 0});
    }
  }
  std::vector<Appearance> result;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Vec filtered;
      for (size_t c = 0; c < 3; ++c) {
        filtered[c] = Convolve(opponent, c, width, height, x, y, Sensitivity()[c]);
      }
      Vec rgb = RgbOfYCxCz(filtered);
      for (double& v : rgb) {
        v = std::clamp(v, 0.0, 1.0);
      }
      std::array<double, 4> response;
      for (size_t i = 0; i < 4; ++i) {
        response[i] = Convolve(luminance, 0, width, height, x, y, features[i]);
      }
      result.push_back({HuntLab(rgb), std::hypot(response[0], response[1]),
                        std::hypot(response[2], response[3])});
    }
  }
  return result;
}

double Error(const Appearance& test, const Appearance& reference) {
  const double greatest = std::pow(HyAb(HuntLab({0, 1, 0}), HuntLab({0, 0, 1})), 0.7);
  const double knee = 0.4 * greatest;
  const double e = std::pow(HyAb(test.lab, reference.lab), 0.7);
  const double colour =
      e < knee ? 0.95 / knee * e : 0.95 + (e - knee) / (greatest - knee) * (1 - 0.95);
  const double feature = std::sqrt(
      std::max(std::abs(reference.edge - test.edge), std::abs(reference.point - test.point)) /
      std::sqrt(2.0));
  return std::pow(colour, 1 - feature);
}

double ToneCurve(double x) {
  const double y = 0.6 * x;
  return y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14);
}

}  // namespace

std::vector<double> LdrFlip(const Image3& test, const Image3& reference) {
  const std::vector<Appearance> t = Appearances(test);
  const std::vector<Appearance> r = Appearances(reference);
  std::vector<double> errors;
  for (size_t i = 0; i < t.size(); ++i) {
    errors.push_back(Error(t[i], r[i]));
  }
  return errors;
}

std::vector<double> Exposures(const Image3& reference) {
  // The curve rises: bisection finds where it reaches 0.85.
  double low = 0, high = 100;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (ToneCurve(middle) < 0.85 ? low : high) = middle;
  }
  std::vector<double> luminances;
  for (int y = 0; y < reference.height(); ++y) {
    for (int x = 0; x < reference.width(); ++x) {
      luminances.push_back(
          Times(XyzOfRgb(), {reference[0](x, y), reference[1](x, y), reference[2](x, y)})[1]);
    }
  }
  std::sort(luminances.begin(), luminances.end());
  const size_t n = luminances.size();
  const double median = 0.5 * (luminances[n / 2] + luminances[(n - 1) / 2]);
  const double start = std::log2(low / luminances.back());
  const double stop = std::log2(low / median);
  const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
  std::vector<double> stops;
  for (int i = 0; i < count; ++i) {
    stops.push_back(start + (stop - start) * i / (count - 1));
  }
  return stops;
}

Image3 Develop(const Image3& radiance, double stops) {
  Image3 image(radiance.width(), radiance.height());
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const double shown = ToneCurve(std::exp2(stops) * radiance[c](x, y));
        image[c](x, y) = static_cast<float>(std::clamp(shown, 0.0, 1.0));
      }
    }
  }
  return image;
}

std::vector<double> HdrFlip(const Image3& test, const Image3& reference) {
  std::vector<double> errors;
  for (const double stops : Exposures(reference)) {
    const std::vector<double> at_exposure =
        LdrFlip(Develop(test, stops), Develop(reference, stops));
    errors.resize(at_exposure.size());
    for (size_t i = 0; i < errors.size(); ++i) {
      errors[i] = std::max(errors[i], at_exposure[i]);
    }
  }
  return errors;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

}  // namespace stillray::flip_reference
