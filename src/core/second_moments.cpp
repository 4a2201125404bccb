// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/second_moments.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/colour.h"
#include "core/guides.h"
#include "core/pixels.h"

namespace stillray {
namespace {

/// Of windows that may show several surfaces.
constexpr int kRadius = 2;
constexpr int kCoefficient[3] = {1, -2, 1};
/// The neighbours of a pixel; the first four are also the directions of lines through it.
constexpr int kNeighbours = 8;
constexpr int kDirections = 4;
constexpr int kOffset[kNeighbours][2] = {{1, 0},  {0, 1},  {1, 1},   {1, -1},
                                         {-1, 0}, {0, -1}, {-1, -1}, {-1, 1}};
/// Minimum cosine between normals of one smooth surface, and maximum second difference of inverse
/// depth, relative to the inverse depth.
constexpr float kLeastCosine = 0.99f;
constexpr float kMostCurvature = 0.005f;
/// Up to this many samples a pixel's own difference counts fully, with more samples less: the mean
/// of many samples is rarely an outlier.
constexpr float kSamplesOfOwn = 4;

/// The luminance of demodulated radiance; NaN where there is no sample or no surface.
Image1 Luminance(const Frame& frame, const Signal& signal) {
  const Image3& light = signal.radiance;
  const Image3& albedo = AlbedoOf(frame.guides, signal.kind);
  Image1 luminance(frame.width, frame.height);
  ForEachPixel(frame.width, frame.height, [&](int x, int y) {
    const bool seen = frame.samples(x, y) > 0 && std::isfinite(frame.guides.depth(x, y));
    float sum[3];
    for (int c = 0; c < 3; ++c) {
      sum[c] = Demodulate(light[c](x, y), albedo.empty() ? 1.0f : albedo[c](x, y));
    }
    const float l = Luminance709(sum[0], sum[1], sum[2]);
    luminance(x, y) = seen && std::isfinite(l) ? l : NAN;
  });
  return luminance;
}

/// Bit mask of neighbours on the same surface, per pixel. Bit k: neighbour k; bit kNeighbours + k:
/// the neighbours in direction k and opposite, with linear inverse depth over the three pixels.
using Surroundings = Plane<uint16_t>;

/// Whether both neighbours in direction k are on the pixel's surface.
bool HasPair(unsigned surroundings, int k) {
  const unsigned both = 1u << k | 1u << (k + kDirections);
  return (surroundings & both) == both;
}

/// Whether normals of any length are similar; false for zero.
bool HaveOneNormal(const Image3& normal, int x0, int y0, int x1, int y1) {
  if (normal.empty()) {
    return true;
  }
  const vec3 a = VectorAt(normal, x0, y0);
  const vec3 b = VectorAt(normal, x1, y1);
  const float product = dot(a, b);
  return product > 0 && product * product > kLeastCosine * kLeastCosine * (dot(a, a) * dot(b, b));
}

bool HaveOneId(const Plane<uint32_t>& id, int x0, int y0, int x1, int y1) {
  return id.empty() || id(x0, y0) == id(x1, y1);
}

/// Whether two pixels are on one surface, with the same virtual image.
bool AreAlike(const Guides& guides, const VirtualGuides& image, int x0, int y0, int x1, int y1) {
  if (!IsSurface(guides.depth(x0, y0)) || !IsSurface(guides.depth(x1, y1)) ||
      !HaveOneId(guides.id, x0, y0, x1, y1) || !HaveOneNormal(guides.normal, x0, y0, x1, y1)) {
    return false;
  }
  if (image.empty()) {
    return true;
  }
  const float z0 = image.depth(x0, y0);
  const float z1 = image.depth(x1, y1);
  const bool same_kind = (z0 > 0) == (z1 > 0) && std::isfinite(z0) == std::isfinite(z1);
  return same_kind && (!IsSurface(z0) || (HaveOneId(image.id, x0, y0, x1, y1) &&
                                          HaveOneNormal(image.normal, x0, y0, x1, y1)));
}

/// Inverse depth; 0 where there is no surface; empty if depth is empty.
Image1 InverseOf(const Image1& depth) {
  Image1 inverse = depth;
  ForEachPixel(depth.width(), depth.height(), [&](int x, int y) {
    inverse(x, y) = IsSurface(depth(x, y)) ? 1.0f / depth(x, y) : 0.0f;
  });
  return inverse;
}

/// Whether inverse depth is linear over three pixels in a line. True if all are 0, or if the plane
/// is empty.
bool IsStraight(const Image1& inverse, int x, int y, const int (&offset)[2]) {
  if (inverse.empty()) {
    return true;
  }
  const float middle = inverse(x, y);
  const float bend =
      inverse(x - offset[0], y - offset[1]) - 2 * middle + inverse(x + offset[0], y + offset[1]);
  return std::abs(bend) <= kMostCurvature * middle;
}

Surroundings FindSurroundings(const Guides& guides, const VirtualGuides& image) {
  const int width = guides.depth.width();
  const int height = guides.depth.height();
  const Image1 inverse = InverseOf(guides.depth);
  const Image1 inverse_of_image = InverseOf(image.depth);
  // Only for the first four neighbours: each pair of pixels is tested once.
  Plane<uint8_t> first(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    unsigned bits = 0;
    for (int k = 0; k < kDirections; ++k) {
      const int i = x + kOffset[k][0];
      const int j = y + kOffset[k][1];
      const bool inside = i >= 0 && j >= 0 && i < width && j < height;
      bits |= inside && AreAlike(guides, image, x, y, i, j) ? 1u << k : 0u;
    }
    first(x, y) = static_cast<uint8_t>(bits);
  });
  Surroundings found(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    unsigned bits = first(x, y);
    for (int k = 0; k < kDirections; ++k) {
      const int i = x - kOffset[k][0];
      const int j = y - kOffset[k][1];
      const bool inside = i >= 0 && j >= 0 && i < width && j < height;
      bits |= inside && (first(i, j) >> k & 1) != 0 ? 1u << (k + kDirections) : 0u;
    }
    for (int k = 0; k < kDirections; ++k) {
      if (HasPair(bits, k) && IsStraight(inverse, x, y, kOffset[k]) &&
          IsStraight(inverse_of_image, x, y, kOffset[k])) {
        bits |= 1u << (kNeighbours + k);
      }
    }
    found(x, y) = static_cast<uint16_t>(bits);
  });
  return found;
}

/// The square of a filter's result, and the variance of the result for samples of variance 1; a
/// variance of 0 if a pixel is missing.
struct Residual {
  float square = 0;
  float variance = 0;
};

Residual Usable(float root, float variance) {
  const float square = root * root;
  return std::isfinite(square) && std::isfinite(variance) ? Residual{square, variance} : Residual();
}

/// The radiance of one signal, and its variance for samples of variance 1.
struct MeanLight {
  Image1 luminance;  ///< NaN: missing
  const Image1& variance;
};

/// (1 -2 1) across and down. Not for pixels on the image border.
Residual FilterBlock(const MeanLight& light, int x, int y) {
  float root = 0;
  float variance = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const auto c = static_cast<float>(kCoefficient[dx + 1] * kCoefficient[dy + 1]);
      root += c * light.luminance(x + dx, y + dy);
      variance += c * c * light.variance(x + dx, y + dy);
    }
  }
  return Usable(root, variance);
}

float SumOfEnds(const Image1& plane, int x, int y, const int (&offset)[2]) {
  return plane(x - offset[0], y - offset[1]) + plane(x + offset[0], y + offset[1]);
}

/// (1 -2 1) along a line.
Residual FilterLine(const MeanLight& light, int x, int y, const int (&offset)[2]) {
  return Usable(SumOfEnds(light.luminance, x, y, offset) - 2 * light.luminance(x, y),
                SumOfEnds(light.variance, x, y, offset) + 4 * light.variance(x, y));
}

/// FilterBlock around each pixel.
Plane<Residual> FilterBlocks(const MeanLight& light) {
  const int width = light.luminance.width();
  const int height = light.luminance.height();
  Plane<Residual> blocks(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const bool inside = x > 0 && y > 0 && x < width - 1 && y < height - 1;
    blocks(x, y) = inside ? FilterBlock(light, x, y) : Residual();
  });
  return blocks;
}

constexpr float kUnknown = -1;

/// The variance of a sample from 3x3 pixels of one smooth surface; kUnknown if there are none.
float EstimateOnSurface(const MeanLight& light, const Residual& block, unsigned surroundings, int x,
                        int y) {
  const unsigned lines = surroundings >> kNeighbours;
  if (lines == (1u << kDirections) - 1) {
    return block.variance > 0 ? block.square / block.variance : kUnknown;
  }
  float sum = 0;
  int count = 0;
  for (int k = 0; k < kDirections; ++k) {
    const Residual line = (lines >> k & 1) != 0 ? FilterLine(light, x, y, kOffset[k]) : Residual();
    if (line.variance > 0) {
      sum += line.square / line.variance;
      ++count;
    }
  }
  return count > 0 ? sum / static_cast<float>(count) : kUnknown;
}

/// The neighbours whose opposite neighbour is in the set too; the whole set if there are none.
unsigned Paired(unsigned neighbours) {
  const unsigned opposite = neighbours << kDirections | neighbours >> kDirections;
  const unsigned paired = neighbours & opposite;
  return paired != 0 ? paired : neighbours;
}

/// The squared difference of a pixel from the mean of these neighbours.
Residual DifferenceFrom(const MeanLight& light, unsigned neighbours, int x, int y) {
  float sum = 0;
  float variance = 0;
  float count = 0;
  for (int k = 0; k < kNeighbours; ++k) {
    if ((neighbours >> k & 1) != 0) {
      sum += light.luminance(x + kOffset[k][0], y + kOffset[k][1]);
      variance += light.variance(x + kOffset[k][0], y + kOffset[k][1]);
      count += 1;
    }
  }
  return Usable(light.luminance(x, y) - sum / count,
                light.variance(x, y) + variance / (count * count));
}

/// The estimate from a pixel's own difference to its neighbours on the surface; 0 without
/// neighbours. Uses pairs of opposite neighbours, in which gradients cancel, if there are any.
float EstimateByItself(const MeanLight& light, unsigned surroundings, int x, int y) {
  unsigned present = surroundings & ((1u << kNeighbours) - 1);
  Residual own = DifferenceFrom(light, Paired(present), x, y);
  if (!(own.variance > 0) && present != 0) {  // one of them is missing
    for (int k = 0; k < kNeighbours; ++k) {
      if ((present >> k & 1) != 0 &&
          std::isnan(light.luminance(x + kOffset[k][0], y + kOffset[k][1]))) {
        present &= ~(1u << k);
      }
    }
    own = DifferenceFrom(light, Paired(present), x, y);
  }
  return own.variance > 0 ? own.square / own.variance : 0.0f;
}

/// Calls body(i, j) for the pixels of the image within kRadius of (x, y) in both directions.
template <typename T, typename Body>
void ForWindow(const Plane<T>& picture, int x, int y, const Body& body) {
  for (int j = std::max(y - kRadius, 0); j <= std::min(y + kRadius, picture.height() - 1); ++j) {
    for (int i = std::max(x - kRadius, 0); i <= std::min(x + kRadius, picture.width() - 1); ++i) {
      body(i, j);
    }
  }
}

/// The mean of the estimates other than kUnknown.
struct KnownMean {
  float sum = 0;
  int count = 0;

  void Add(float estimate) {
    if (estimate >= 0) {
      sum += estimate;
      ++count;
    }
  }
  float Value() const { return count > 0 ? sum / static_cast<float>(count) : kUnknown; }
};

float MeanOnSurface(const Image1& estimates, unsigned surroundings, int x, int y) {
  KnownMean mean;
  mean.Add(estimates(x, y));
  for (int k = 0; k < kNeighbours; ++k) {
    if ((surroundings >> k & 1) != 0) {
      mean.Add(estimates(x + kOffset[k][0], y + kOffset[k][1]));
    }
  }
  return mean.Value();
}

float MeanAround(const Image1& estimates, int x, int y) {
  KnownMean mean;
  ForWindow(estimates, x, y, [&](int i, int j) { mean.Add(estimates(i, j)); });
  return mean.Value();
}

/// From 5x5 blocks of any surfaces; 0 if all blocks have a missing pixel.
float EstimateAnyhow(const Plane<Residual>& blocks, int x, int y) {
  Residual sum;
  ForWindow(blocks, x, y, [&](int i, int j) {
    sum.square += blocks(i, j).square;
    sum.variance += blocks(i, j).variance;
  });
  return sum.variance > 0 ? sum.square / sum.variance : 0.0f;
}

/// The variance of single samples.
Image1 EstimateVariance(const MeanLight& light, const Surroundings& surroundings) {
  const int width = light.luminance.width();
  const int height = light.luminance.height();
  const Plane<Residual> blocks = FilterBlocks(light);
  Image1 estimates(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    estimates(x, y) = EstimateOnSurface(light, blocks(x, y), surroundings(x, y), x, y);
  });
  Image1 variance(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    if (std::isnan(light.luminance(x, y))) {
      return;
    }
    const unsigned around = surroundings(x, y);
    float v = MeanOnSurface(estimates, around, x, y);
    if (v < 0) {
      v = MeanAround(estimates, x, y);
    }
    if (v < 0) {
      v = EstimateAnyhow(blocks, x, y);
    }
    const float share = std::min(kSamplesOfOwn * light.variance(x, y), 1.0f);
    variance(x, y) = std::max(v, share * EstimateByItself(light, around, x, y));
  });
  return variance;
}

/// The virtual guides of signals of this kind; empty for diffuse signals.
const VirtualGuides& ImageOf(const Frame& frame, SignalKind kind) {
  static const VirtualGuides kNone;
  switch (kind) {
    case SignalKind::kDirectSpecular:
    case SignalKind::kIndirectSpecular:
      return frame.reflection;
    case SignalKind::kDirectTransmission:
    case SignalKind::kIndirectTransmission:
      return frame.refraction;
    default:
      return kNone;
  }
}

}  // namespace

bool LacksSecondMoments(const Frame& frame) {
  const bool has_all = std::all_of(frame.signals.begin(), frame.signals.end(),
                                   [](const Signal& s) { return !s.second_moment.empty(); });
  return !has_all && AnyPixel(frame.samples, [](float n) { return n > 1; });
}

void EstimateSecondMoments(Frame* frame) {
  if (!LacksSecondMoments(*frame)) {
    return;
  }
  frame->has_estimated_moments = true;
  const int width = frame->width;
  const int height = frame->height;
  Image1 inverse(width, height);
  ForEachPixel(width, height, [&](int x, int y) { inverse(x, y) = 1.0f / frame->samples(x, y); });
  std::map<const VirtualGuides*, Surroundings> surroundings;  // by image
  for (Signal& signal : frame->signals) {
    if (!signal.second_moment.empty()) {
      continue;
    }
    const VirtualGuides& image = ImageOf(*frame, signal.kind);
    const auto [at, is_new] = surroundings.try_emplace(image.empty() ? nullptr : &image);
    if (is_new) {
      at->second = FindSurroundings(frame->guides, image);
    }
    const MeanLight light = {Luminance(*frame, signal), inverse};
    const Image1 variance = EstimateVariance(light, at->second);
    signal.second_moment = Image1(width, height);
    ForEachPixel(width, height, [&](int x, int y) {
      const float l = light.luminance(x, y);
      const float n = frame->samples(x, y);
      if (!std::isnan(l)) {
        signal.second_moment(x, y) = l * l + variance(x, y) * std::max(n - 1, 0.0f) / n;
      }
    });
  }
}

}  // namespace stillray
