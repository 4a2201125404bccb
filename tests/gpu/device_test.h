// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoisers on the device of a test, and how their pictures are compared with the CPU's.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "denoise/stage_parity.h"
#include "denoise/vulkan/host_denoiser.h"
#include "gpu/vulkan_test.h"
#include "stillray/denoise.hpp"

namespace stillray::test {

/// With 32 bits both differ in rounding and in the exponentials of the device alone.
inline constexpr Tolerance kFloat = {2e-3, 0.004};
/// Halves keep 11 bits of light, normals 15 bits of each octahedral coordinate.
inline constexpr Tolerance kHalf = {1e-2, 0.01};

/// What is divided by a variance near zero, or squared, shows every rounding of a half: how long a
/// history may count for, and what depends on it.
inline constexpr Tolerance kHalfOfSquares = {0.15, 0.05};

/// Sums of weights, some of which are on one side of a threshold on the CPU and on the other on the
/// device.
inline constexpr Tolerance kSumsOfWeights = {6e-3, 0.01};

inline Tolerance ToleranceOf(const std::string& name, DevicePrecision precision) {
  if (precision == DevicePrecision::kFloat && name.starts_with("weights")) {
    return kSumsOfWeights;
  }
  const bool squares = name.find("variance") != std::string::npos || name.find("limit") == 0;
  return precision == DevicePrecision::kFloat ? kFloat : squares ? kHalfOfSquares : kHalf;
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

}  // namespace stillray::test
