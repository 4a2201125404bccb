// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Files of one pixel, and the frames that they become.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "stillray/aov.h"
#include "stillray/io.h"

namespace stillray::test {

/// A picture of one pixel. "DiffDir:RGB" is a layer and its letters.
inline ExrImage OnePixel(const std::map<std::string, std::vector<float>>& layers) {
  ExrImage image;
  image.width = 1;
  image.height = 1;
  for (const auto& [name, values] : layers) {
    const size_t colon = name.find(':');
    const std::string layer = name.substr(0, colon);
    for (size_t c = 0; c < values.size(); ++c) {
      Image1 plane(1, 1);
      plane.Fill(values[c]);
      const std::string letter(1, name[colon + 1 + c]);
      image.Add(layer.empty() ? letter : layer + "." + letter, PixelType::kFloat, plane);
    }
  }
  return image;
}

inline Result<Frame> Import(const ExrImage& image, const AovOptions& options = {}) {
  const Result<AovLayout> layout = UnderstandAovs(image, options, "file");
  if (!layout.ok()) {
    return layout.status();
  }
  return ImportFrame(image, *layout, {0, 0}, "file");
}

using Rgb = std::array<float, 3>;

inline Rgb Pixel(const Image3& image) {
  return {image[0](0, 0), image[1](0, 0), image[2](0, 0)};
}
/// The passes of Cycles, by layer and letters.
inline std::map<std::string, std::vector<float>> BlenderLayers() {
  return {{"DiffDir:RGB", {1, 2, 3}},
          {"DiffInd:RGB", {0.5f, 0.5f, 0.5f}},
          {"DiffCol:RGB", {0.5f, 0.25f, 1}},
          {"GlossDir:RGB", {1, 0, 0}},
          {"GlossInd:RGB", {0, 1, 0}},
          {"GlossCol:RGB", {1, 1, 0.5f}},
          {"TransDir:RGB", {0, 0, 4}},
          {"TransInd:RGB", {2, 0, 0}},
          {"TransCol:RGB", {0.5f, 0, 0.5f}},
          {"Emit:RGB", {0, 0, 0.125f}},
          {"Env:RGB", {0.25f, 0, 0}},
          {"Depth:Z", {4}},
          {"Normal:XYZ", {0, 0, 0.5f}},
          {"Vector:XYZW", {3, 2, 7, 7}},
          {"IndexOB:X", {5}}};
}

}  // namespace stillray::test
