// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/next_motion.h"

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

}  // namespace

FrameMotion MotionTowards(const Frame& next, Image2 surface) {
  return {std::move(surface), ImageMotionTowards(next, next.reflection),
          ImageMotionTowards(next, next.refraction)};
}

void SwapMotion(FrameMotion* motion, Frame* frame) {
  std::swap(motion->surface, frame->guides.motion);
  std::swap(motion->reflection, frame->reflection.motion);
  std::swap(motion->refraction, frame->refraction.motion);
}

}  // namespace stillray
