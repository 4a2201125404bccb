// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_seen.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/aov_light.h"
#include "io/text.h"

namespace stillray::io {
namespace {

constexpr Aov kSeen[] = {Aov::kSeenDepth, Aov::kSeenNormal, Aov::kSeenAlbedo};

bool PointsToPrevious(const MotionConvention& motion) {
  return motion.direction == MotionDirection::kToPrevious ||
         motion.direction == MotionDirection::kFromPrevious;
}

/// What the layers are compared with and the file lacks.
std::vector<std::string> MissingFor(const AovLayout& layout) {
  std::vector<std::string> missing;
  for (const Aov aov : {Aov::kDepth, Aov::kNormal, Aov::kMotion}) {
    if (layout.Find(aov) == nullptr) {
      missing.push_back(AovName(aov));
    } else if (aov == Aov::kMotion && !PointsToPrevious(layout.motion)) {
      missing.push_back("motion to the previous frame");
    }
  }
  return missing;
}

/// The pass that does not fit, and what to change.
std::string Reason(const AovLayout& layout, NoSeenGuides why) {
  switch (why) {
    case NoSeenGuides::kLens:
      return fmt::format(
          "{} is not the length of paths to the depth in {} in most pixels: use a perspective "
          "camera without depth of field, and fewer mirrors and transparent objects in a picture",
          LayerNameOf(layout, Aov::kSeenDepth), LayerNameOf(layout, Aov::kDepth));
    case NoSeenGuides::kNormal:
      return fmt::format(
          "{} has not the normals of {} in the camera's axes, or all are parallel: take both from "
          "one render, {} in world space",
          LayerNameOf(layout, Aov::kSeenNormal), LayerNameOf(layout, Aov::kNormal),
          LayerNameOf(layout, Aov::kNormal));
    case NoSeenGuides::kMotion:
      return fmt::format(
          "{} is not the motion of a camera before a mostly static scene: check its signs "
          "(stillray check), and render objects that fill the picture in a separate view layer",
          LayerNameOf(layout, Aov::kMotion));
    case NoSeenGuides::kNone:
      break;
  }
  return "";
}

void Note(const AovLayout& used, const std::string& reason, std::vector<std::string>* notes) {
  const std::string depth = LayerNameOf(used, Aov::kSeenDepth);
  notes->push_back(
      reason.empty()
          ? fmt::format("reflections in mirrors and what is seen through glass follow {}, and "
                        "the normals and albedo beside it",
                        depth)
          : fmt::format("reflections and refractions do not follow {}, and are blurred where they "
                        "move: {}",
                        depth, reason));
}

}  // namespace

void DecideSeenGuides(const ExrImage& image, AovLayout* layout) {
  const bool all = std::all_of(std::begin(kSeen), std::end(kSeen),
                               [&](Aov aov) { return layout->Find(aov) != nullptr; });
  const std::vector<std::string> missing = MissingFor(*layout);
  if (all && !layout->from_colour) {
    Note(*layout,
         missing.empty() ? Reason(*layout, CheckSeenLayers(image, *layout))
                         : fmt::format("the file has no {}", fmt::join(missing, ", no ")),
         &layout->notes);
  }
  if (!all || layout->from_colour || !missing.empty()) {
    for (const Aov aov : kSeen) {
      Drop(aov, layout);
    }
  }
}

void DecideCurvedImages(const ExrImage& image, AovLayout* layout) {
  const bool reflects = layout->Find(Aov::kDirectSpecular) != nullptr ||
                        layout->Find(Aov::kIndirectSpecular) != nullptr;
  const bool has_shape =
      layout->Find(Aov::kDepth) != nullptr && layout->Find(Aov::kNormal) != nullptr;
  const bool moves = layout->Find(Aov::kMotion) == nullptr || PointsToPrevious(layout->motion);
  layout->curved_images = layout->renderer != "stillray" && !layout->from_colour && reflects &&
                          has_shape && moves && layout->Find(Aov::kReflectionDepth) == nullptr &&
                          HasCurvedImages(image, *layout);
  if (layout->curved_images) {
    layout->notes.emplace_back(
        "reflections in convex surfaces follow the image behind them, whose place their shape "
        "gives");
  }
}

}  // namespace stillray::io
