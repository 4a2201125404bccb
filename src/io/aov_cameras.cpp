// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The camera matrices in OpenEXR's standard attributes.
#include <charconv>
#include <cmath>

#include "core/cameras.h"
#include "stillray/aov.h"

namespace stillray {
namespace {

/// 16 finite numbers, or nothing.
std::optional<std::array<double, 16>> Matrix(const ExrImage& image, const std::string& name) {
  const auto at = image.other_attributes.find(name);
  if (at == image.other_attributes.end()) {
    return std::nullopt;
  }
  std::array<double, 16> numbers;
  const char* begin = at->second.data();
  const char* end = begin + at->second.size();
  for (double& number : numbers) {
    while (begin < end && *begin == ' ') {
      ++begin;
    }
    const auto [stop, error] = std::from_chars(begin, end, number);
    if (error != std::errc() || !std::isfinite(number)) {
      return std::nullopt;
    }
    begin = stop;
  }
  return numbers;
}

}  // namespace

std::optional<CameraMatrices> CameraOf(const ExrImage& image) {
  const auto to_camera = Matrix(image, "worldToCamera");
  const auto to_ndc = Matrix(image, "worldToNDC");
  if (!to_camera || !to_ndc) {
    return std::nullopt;
  }
  const CameraMatrices camera = {*to_camera, *to_ndc, false};
  return HasInverse(camera) ? std::optional<CameraMatrices>(camera) : std::nullopt;
}

}  // namespace stillray
