// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Colour spaces and the colour difference of FLIP (Andersson, Nilsson, Akenine-Moeller, Oskarsson,
/// Astroem and Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020).
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace stillray::quality {

/// CIE XYZ relative to the white point. For linear sRGB in 0..1 each component is in 0..1.
struct RelativeXyz {
  float x = 0;
  float y = 0;
  float z = 0;
};

/// CIELAB with a and b scaled by lightness (section 4.1, Hunt's effect).
struct HuntLab {
  float l = 0;
  float a = 0;
  float b = 0;
};

/// Linear sRGB to XYZ (IEC 61966-2-1, D65), each row divided by its sum, so that white is 1, 1, 1.
inline constexpr std::array<std::array<double, 3>, 3> kXyzOfRgb = [] {
  std::array<std::array<double, 3>, 3> m = {{{0.4123907993, 0.3575843394, 0.1804807884},
                                             {0.2126390059, 0.7151686788, 0.0721923154},
                                             {0.0193308187, 0.1191947798, 0.9505321522}}};
  for (auto& row : m) {
    const double white = row[0] + row[1] + row[2];
    for (double& value : row) {
      value /= white;
    }
  }
  return m;
}();

/// The inverse of kXyzOfRgb, by Cramer's rule.
inline constexpr std::array<std::array<double, 3>, 3> kRgbOfXyz = [] {
  const auto& m = kXyzOfRgb;
  std::array<std::array<double, 3>, 3> inverse = {};
  double determinant = 0;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      // Cofactor of (j, i): the cyclic order of indices takes care of its sign.
      const size_t r1 = (j + 1) % 3, r2 = (j + 2) % 3, c1 = (i + 1) % 3, c2 = (i + 2) % 3;
      inverse[i][j] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
    }
    determinant += m[0][i] * inverse[i][0];
  }
  for (auto& row : inverse) {
    for (double& value : row) {
      value /= determinant;
    }
  }
  return inverse;
}();

inline float Dot(const std::array<double, 3>& row, float a, float b, float c) {
  return static_cast<float>(row[0]) * a + static_cast<float>(row[1]) * b +
         static_cast<float>(row[2]) * c;
}

inline RelativeXyz XyzOfRgb(float r, float g, float b) {
  return {Dot(kXyzOfRgb[0], r, g, b), Dot(kXyzOfRgb[1], r, g, b), Dot(kXyzOfRgb[2], r, g, b)};
}

/// Clips the colour to the gamut of a display: linear RGB in 0..1.
inline RelativeXyz ClipToDisplay(const RelativeXyz& c) {
  const auto clip = [](float v) { return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f; };
  return XyzOfRgb(clip(Dot(kRgbOfXyz[0], c.x, c.y, c.z)), clip(Dot(kRgbOfXyz[1], c.x, c.y, c.z)),
                  clip(Dot(kRgbOfXyz[2], c.x, c.y, c.z)));
}

/// Cube root of a positive number, off by at most 4 units in the last place: a third of the
/// exponent as a first guess, then two steps of Halley's method. Three times as fast as std::cbrt.
inline float CubeRoot(float t) {
  constexpr uint32_t kTwoThirdsOfBias = 709921077;  // minimises the guess's largest error
  float root = std::bit_cast<float>(std::bit_cast<uint32_t>(t) / 3 + kTwoThirdsOfBias);
  for (int i = 0; i < 2; ++i) {
    const float cube = root * root * root;
    root *= (cube + 2.0f * t) / (2.0f * cube + t);
  }
  return root;
}

/// The nonlinearity of CIELAB.
inline float LabCurve(float t) {
  constexpr float kDelta = 6.0f / 29.0f;
  return t > kDelta * kDelta * kDelta ? CubeRoot(t) : t / (3.0f * kDelta * kDelta) + 4.0f / 29.0f;
}

inline HuntLab HuntLabOfXyz(const RelativeXyz& c) {
  const float fx = LabCurve(c.x);
  const float fy = LabCurve(c.y);
  const float fz = LabCurve(c.z);
  const float l = 116.0f * fy - 16.0f;
  const float hunt = 0.01f * l;
  return {l, 500.0f * (fx - fy) * hunt, 200.0f * (fy - fz) * hunt};
}

/// Distance of Abasi, Amani Tehran and Fairchild for large colour differences: city block in
/// lightness, Euclidean in chroma.
inline float HyAb(const HuntLab& p, const HuntLab& q) {
  const float da = p.a - q.a;
  const float db = p.b - q.b;
  return std::abs(p.l - q.l) + std::sqrt(da * da + db * db);
}

}  // namespace stillray::quality
