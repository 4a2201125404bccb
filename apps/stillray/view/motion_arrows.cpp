// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/motion_arrows.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "view/colour_maps.h"

namespace stillray::view {
namespace {

constexpr float kSlow = 0.05f;   // pixels per frame
constexpr float kHead = 5;       // pixels
constexpr int kThickFrom = 400;  // images of at least this height have lines two pixels wide
constexpr Rgb8 kArrow = {255, 225, 70};
constexpr Rgb8 kStill = {150, 160, 170};

void Dot(float x, float y, Rgb8 colour, Rgb8Image* picture) {
  const int size = picture->height >= kThickFrom ? 2 : 1;
  const auto left = static_cast<int>(std::floor(x));
  const auto top = static_cast<int>(std::floor(y));
  const auto width = static_cast<size_t>(picture->width);
  for (int py = std::max(top, 0); py < std::min(top + size, picture->height); ++py) {
    for (int px = std::max(left, 0); px < std::min(left + size, picture->width); ++px) {
      uint8_t* pixel =
          picture->pixels.data() + (static_cast<size_t>(py) * width + static_cast<size_t>(px)) * 3;
      pixel[0] = colour.r;
      pixel[1] = colour.g;
      pixel[2] = colour.b;
    }
  }
}

void Line(float x0, float y0, float x1, float y1, Rgb8 colour, Rgb8Image* picture) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0)))));
  for (int i = 0; i <= steps; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(steps);
    Dot(x0 + (x1 - x0) * t, y0 + (y1 - y0) * t, colour, picture);
  }
}

void Arrow(float x, float y, float dx, float dy, Rgb8Image* picture) {
  if (const std::optional<Rgb8> mark = NotFiniteColour(dx, dy)) {
    Dot(x, y, *mark, picture);
    return;
  }
  const float speed = std::hypot(dx, dy);
  if (speed < kSlow) {
    Dot(x, y, kStill, picture);
    return;
  }
  const float length = ArrowLength(speed);
  const float ux = dx / speed;
  const float uy = dy / speed;
  const float tip_x = x + ux * length;
  const float tip_y = y + uy * length;
  Line(x, y, tip_x, tip_y, kArrow, picture);
  const float head = std::min(kHead, length * 0.6f);
  for (const float side : {-0.5f, 0.5f}) {
    Line(tip_x, tip_y, tip_x - head * (ux - uy * side), tip_y - head * (uy + ux * side), kArrow,
         picture);
  }
}

}  // namespace

float ArrowLength(float pixels_per_frame) {
  return 4 * std::log2(1 + 8 * pixels_per_frame);
}

void DrawMotionArrows(const Image2& motion, Rgb8Image* picture) {
  for (uint8_t& value : picture->pixels) {
    value = static_cast<uint8_t>(value / 2);
  }
  for (int y = kArrowSpacing / 2; y < picture->height; y += kArrowSpacing) {
    for (int x = kArrowSpacing / 2; x < picture->width; x += kArrowSpacing) {
      Arrow(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, -motion[0](x, y),
            -motion[1](x, y), picture);
    }
  }
}

}  // namespace stillray::view
