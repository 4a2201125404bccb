// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/next_motion.h"

#include <cmath>
#include <utility>

#include "denoise/stages/select_guides.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

/// Motion of virtual images towards `next`, for pixels that have a virtual image there; for others
/// the motion of the surface.
Image2 ImageMotionTowards(const Frame& next, const VirtualGuides& image) {
  if (image.empty() || image.motion.empty() || next.guides.motion.empty()) {
    return {};
  }
  constexpr SelectGuidesParameters kAnyRoughness = {
      .virtual_roughness = 1, .image_normal = 1, .virtual_motion_roughness = 0};
  const Image3 no_albedo;
  Guides selected;
  Image3 albedo;
  cpu::SelectGuides({&next.guides, &image, &next.guides.roughness, &no_albedo}, kAnyRoughness,
                    &selected, &albedo);
  return ReverseMotion(selected.motion, selected.depth);
}

/// Calls then(x, y, to_x, to_y) for each pixel whose motion leads into the image, with the nearest
/// pixel at its end.
template <typename Then>
void ForEachAlong(const Image2& motion, const Then& then) {
  const int width = motion.width();
  const int height = motion.height();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float at_x = std::floor(static_cast<float>(x) + motion[0](x, y) + 0.5f);
      const float at_y = std::floor(static_cast<float>(y) + motion[1](x, y) + 0.5f);
      // Also false for NaN.
      if (at_x >= 0 && at_y >= 0 && at_x < static_cast<float>(width) &&
          at_y < static_cast<float>(height)) {
        then(x, y, static_cast<int>(at_x), static_cast<int>(at_y));
      }
    }
  }
}

/// The normal of a pixel with unit length; zero if it is invalid.
vec3 NormalAt(const Image3& image, int x, int y) {
  const vec3 n(image[0](x, y), image[1](x, y), image[2](x, y));
  const float length2 = dot(n, n);
  return IsNormalLength2(length2) ? n / std::sqrt(length2) : vec3(0.0f);
}

/// The normals of a frame, rotated with the surface at the nearest pixel of `next` at the end of
/// the motion, by the smallest rotation from the previous normal of `next` to its normal. This is
/// exact where `frame` has that previous normal there, and otherwise keeps the angle between the
/// two, so that the normal test gives the result of the forward direction. Zero where unknown;
/// empty if `next` has no previous normals.
Image3 NormalsAlong(const Image2& motion, const Image3& normal, const Guides& next) {
  if (next.previous_normal.empty() || next.normal.empty() || normal.empty() || motion.empty()) {
    return {};
  }
  Image3 turned(motion.width(), motion.height());
  ForEachAlong(motion, [&](int x, int y, int to_x, int to_y) {
    const vec3 from = NormalAt(next.previous_normal, to_x, to_y);
    const vec3 to = NormalAt(next.normal, to_x, to_y);
    const vec3 n = NormalAt(normal, x, y);
    const float cosine = dot(from, to);
    constexpr float kOpposite = -0.999f;  // the axis of the rotation is undefined
    if (from == vec3(0.0f) || to == vec3(0.0f) || cosine < kOpposite) {
      return;
    }
    const vec3 sum = from + to;
    const vec3 result = n - (dot(n, sum) / (1 + cosine)) * sum + 2 * dot(n, from) * to;
    for (int c = 0; c < 3; ++c) {
      turned[c](x, y) = result[c];
    }
  });
  return turned;
}

/// The confidence at the pixel nearest to the end of the motion; 1 outside the image, where there
/// is no history. Empty if no confidence is given.
Image1 ConfidenceAlong(const Image2& motion, const Image1& confidence) {
  if (confidence.empty() || motion.empty()) {
    return {};
  }
  Image1 moved(motion.width(), motion.height());
  moved.Fill(1.0f);
  ForEachAlong(motion,
               [&](int x, int y, int to_x, int to_y) { moved(x, y) = confidence(to_x, to_y); });
  return moved;
}

}  // namespace

FrameMotion MotionTowards(const Frame& frame, const Frame& next, Image2 surface) {
  FrameMotion motion;
  motion.reflection = ImageMotionTowards(next, next.reflection);
  motion.refraction = ImageMotionTowards(next, next.refraction);
  motion.normal = NormalsAlong(surface, frame.guides.normal, next.guides);
  motion.confidence = ConfidenceAlong(surface, next.confidence);
  motion.surface = std::move(surface);
  return motion;
}

void SwapMotion(FrameMotion* motion, Frame* frame) {
  std::swap(motion->surface, frame->guides.motion);
  std::swap(motion->reflection, frame->reflection.motion);
  std::swap(motion->refraction, frame->refraction.motion);
  std::swap(motion->normal, frame->guides.previous_normal);
  std::swap(motion->confidence, frame->confidence);
}

}  // namespace stillray
