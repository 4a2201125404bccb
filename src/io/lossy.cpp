// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/lossy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "core/parallel.h"

namespace stillray::io {
namespace {

constexpr int kBlock = 8;

/// The brightest finite value of every block.
Image1 BrightestOfBlocks(const Image3& light) {
  const int width = light.width();
  const int height = light.height();
  Image1 brightest((width + kBlock - 1) / kBlock, (height + kBlock - 1) / kBlock);
  ParallelRows(brightest.height(), 1, [&](int first, int last) {
    for (int y = first * kBlock; y < std::min(last * kBlock, height); ++y) {
      for (int x = 0; x < width; ++x) {
        float& of_block = brightest(x / kBlock, y / kBlock);
        for (int c = 0; c < 3; ++c) {
          const float value = light[c](x, y);
          of_block = std::isfinite(value) ? std::max(of_block, value) : of_block;
        }
      }
    }
  });
  return brightest;
}

/// The maximum over the blocks around a pixel.
float BrightestNearby(const Image1& blocks, int x, int y) {
  float brightest = 0;
  for (int v = std::max(y / kBlock - 1, 0); v <= std::min(y / kBlock + 1, blocks.height() - 1);
       ++v) {
    for (int u = std::max(x / kBlock - 1, 0); u <= std::min(x / kBlock + 1, blocks.width() - 1);
         ++u) {
      brightest = std::max(brightest, blocks(u, v));
    }
  }
  return brightest;
}

}  // namespace

bool IsLossy(const ExrImage& image, const Channel& channel) {
  const std::string& codec = image.compression_name;
  if (codec.starts_with("b44")) {
    return channel.type == PixelType::kHalf;
  }
  if (!codec.starts_with("dwa") || channel.type == PixelType::kUint32) {
    return false;
  }
  constexpr std::array<std::string_view, 6> kTransformed = {"R", "G", "B", "Y", "RY", "BY"};
  const std::string_view name = channel.name;
  const size_t dot = name.rfind('.');
  const std::string_view last = dot == std::string_view::npos ? name : name.substr(dot + 1);
  return std::find(kTransformed.begin(), kTransformed.end(), last) != kTransformed.end();
}

void RemoveRinging(Image3* light) {
  const Image1 blocks = BrightestOfBlocks(*light);
  ParallelRows(light->height(), kBlock, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < light->width(); ++x) {
        for (int c = 0; c < 3; ++c) {
          float& value = (*light)[c](x, y);
          if (value < 0 && -value <= kRinging * BrightestNearby(blocks, x, y)) {
            value = 0;
          }
        }
      }
    }
  });
}

}  // namespace stillray::io
