// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoisers on the device of a test, and how their pictures are compared with the CPU's.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>

#include "denoise/vulkan/host_denoiser.h"
#include "gpu/vulkan_test.h"
#include "stillray/denoise.hpp"

namespace stillray::test {

/// How far a picture may be from the reference: the root mean square of the differences over that
/// of the reference, and the share of pixels further off than ten times that plus a little. Pixels
/// may be: a tap that one version accepts and the other just does not makes a visible difference.
struct Tolerance {
  double rms;
  double outliers;
};

/// With 32 bits both differ in rounding and in the exponentials of the device alone.
inline constexpr Tolerance kFloat = {2e-3, 0.004};
/// Halves keep 11 bits of light, normals 15 bits of each octahedral coordinate.
inline constexpr Tolerance kHalf = {1e-2, 0.01};

/// What is divided by a variance near zero, or squared, shows every rounding of a half: how long a
/// history may count for, and what depends on it.
inline constexpr Tolerance kHalfOfSquares = {0.15, 0.05};

inline Tolerance ToleranceOf(const std::string& name, DevicePrecision precision) {
  const bool squares = name.find("variance") != std::string::npos || name.find("limit") == 0;
  return precision == DevicePrecision::kFloat ? kFloat : squares ? kHalfOfSquares : kHalf;
}

struct Difference {
  double rms = 0;
  double outliers = 0;
};

inline Difference Compare(const Image1& a, const Image1& b, double tolerance) {
  double error = 0;
  double square = 0;
  for (int y = 0; y < b.height(); ++y) {
    for (int x = 0; x < b.width(); ++x) {
      const double d = static_cast<double>(a(x, y)) - static_cast<double>(b(x, y));
      error += std::isfinite(d) ? d * d : 1e30;
      square += static_cast<double>(b(x, y)) * static_cast<double>(b(x, y));
    }
  }
  const double pixels = static_cast<double>(b.width()) * b.height();
  const double scale = std::sqrt(square / pixels);
  Difference result;
  result.rms = scale > 0 ? std::sqrt(error / pixels) / scale : std::sqrt(error / pixels);
  for (int y = 0; y < b.height(); ++y) {
    for (int x = 0; x < b.width(); ++x) {
      const double d = std::abs(static_cast<double>(a(x, y)) - static_cast<double>(b(x, y)));
      const double room = std::abs(static_cast<double>(b(x, y))) + 0.1 * scale + 1e-6;
      result.outliers += d > 10 * tolerance * room ? 1 / pixels : 0.0;
    }
  }
  return result;
}

inline void ExpectImage(const NamedImage& a, const NamedImage& b, const Tolerance& t,
                        const std::string& what) {
  ASSERT_EQ(a.channels.size(), b.channels.size()) << what << " " << a.name;
  for (size_t c = 0; c < a.channels.size(); ++c) {
    const Difference d = Compare(a.channels[c], b.channels[c], t.rms);
    EXPECT_LE(d.rms, t.rms) << what << " " << a.name << "[" << c << "]";
    EXPECT_LE(d.outliers, t.outliers) << what << " " << a.name << "[" << c << "]";
  }
}

class DeviceTest : public test::VulkanTest {
 protected:
  Denoiser MakeDenoiser(const Settings& settings, DevicePrecision precision) {
    Result<Denoiser> made = Denoiser::Create(settings, device(), precision);
    EXPECT_TRUE(made.ok()) << made.status().message();
    return std::move(made.value());
  }
  Device device() { return MakeDevice(std::make_shared<vulkan::VulkanBackend>(device_), "test"); }
};

inline Settings With(std::string_view preset,
                     std::initializer_list<std::pair<const char*, const char*>> changes) {
  Settings s = PresetSettings(preset).value();
  for (const auto& [name, value] : changes) {
    EXPECT_TRUE(SetParameter(&s, name, value).ok()) << name;
  }
  return s;
}

}  // namespace stillray::test
