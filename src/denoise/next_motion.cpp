// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/next_motion.h"

#include <cmath>
#include <utility>

#include "denoise/stages/select_guides.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

/// Motion towards `next` of pixels that show this kind of image there, else of their surface.
Image2 ImageMotionTowards(const Frame& next, const VirtualGuides& image) {
  if (image.empty() || image.motion.empty() || next.guides.motion.empty()) {
    return {};
  }
  constexpr SelectGuidesParameters kAnyRoughness = {.virtual_roughness = 1};
  const Image3 no_albedo;
  Guides selected;
  Image3 albedo;
  cpu::SelectGuides({&next.guides, &image, &next.guides.roughness, &no_albedo}, kAnyRoughness,
                    &selected, &albedo);
  return ReverseMotion(selected.motion, selected.depth);
}

/// The confidence of the nearest pixel to where the motion leads; 1 outside the picture, where
/// there is no light to be confident in. Empty if none is given.
Image1 ConfidenceAlong(const Image2& motion, const Image1& confidence) {
  if (confidence.empty() || motion.empty()) {
    return {};
  }
  const int width = motion.width();
  const int height = motion.height();
  Image1 moved(width, height);
  moved.Fill(1.0f);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float at_x = std::floor(static_cast<float>(x) + motion[0](x, y) + 0.5f);
      const float at_y = std::floor(static_cast<float>(y) + motion[1](x, y) + 0.5f);
      // Also false for NaN.
      if (at_x >= 0 && at_y >= 0 && at_x < static_cast<float>(width) &&
          at_y < static_cast<float>(height)) {
        moved(x, y) = confidence(static_cast<int>(at_x), static_cast<int>(at_y));
      }
    }
  }
  return moved;
}

}  // namespace

FrameMotion MotionTowards(const Frame& next, Image2 surface) {
  FrameMotion motion;
  motion.reflection = ImageMotionTowards(next, next.reflection);
  motion.refraction = ImageMotionTowards(next, next.refraction);
  motion.confidence = ConfidenceAlong(surface, next.confidence);
  motion.surface = std::move(surface);
  return motion;
}

void SwapMotion(FrameMotion* motion, Frame* frame) {
  std::swap(motion->surface, frame->guides.motion);
  std::swap(motion->reflection, frame->reflection.motion);
  std::swap(motion->refraction, frame->refraction.motion);
  std::swap(motion->confidence, frame->confidence);
}

}  // namespace stillray
