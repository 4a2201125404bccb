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

std::string MotionName(const AovLayout& layout) {
  return layout.Find(Aov::kMotion) == nullptr ? "motion" : LayerNameOf(layout, Aov::kMotion);
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
          "(stillray check), give the cameras (--cameras FILE.json), or render objects that fill "
          "the picture in a separate view layer",
          MotionName(layout));
    case NoSeenGuides::kOnePlane:
      return fmt::format(
          "all surfaces that follow the camera lie in one plane, whose {} is not enough to find "
          "the "
          "camera's: give the cameras (--cameras FILE.json), or show surfaces at other depths",
          MotionName(layout));
    case NoSeenGuides::kNone:
      break;
  }
  return "";
}

constexpr const char* kFollow =
    "reflections in mirrors and what is seen through glass follow {}, and the normals and albedo "
    "beside it";
constexpr const char* kBlurred = "reflections and refractions do not follow ";

void Note(const AovLayout& used, NoSeenGuides why, std::vector<std::string>* notes) {
  notes->push_back(why == NoSeenGuides::kNone
                       ? fmt::format(kFollow, LayerNameOf(used, Aov::kSeenDepth))
                       : LackOfImages(used, why));
}

std::string Blurred(const AovLayout& layout, const std::string& reason) {
  return fmt::format("{}{}, and are blurred where they move: {}", kBlurred,
                     LayerNameOf(layout, Aov::kSeenDepth), reason);
}

}  // namespace

std::string LackOfImages(const AovLayout& layout, NoSeenGuides why) {
  if (why == NoSeenGuides::kNone) {
    return "";
  }
  return layout.Find(Aov::kSeenDepth) != nullptr
             ? Blurred(layout, Reason(layout, why))
             : fmt::format("reflections in convex surfaces do not follow the image behind them: {}",
                           Reason(layout, why));
}

bool IsNotedInLayout(const AovLayout& layout) {
  return std::any_of(layout.notes.begin(), layout.notes.end(),
                     [](const std::string& note) { return note.starts_with(kBlurred); });
}

void NoteSeenGuidesOfKnownCamera(const ExrImage& image, AovLayout* layout) {
  if (layout->Find(Aov::kSeenDepth) == nullptr || !IsNotedInLayout(*layout)) {
    return;
  }
  std::erase_if(layout->notes, [](const std::string& note) { return note.starts_with(kBlurred); });
  Note(*layout, CheckSeenLayers(image, *layout, true), &layout->notes);
}

void DecideSeenGuides(const ExrImage& image, AovLayout* layout) {
  const bool all = std::all_of(std::begin(kSeen), std::end(kSeen),
                               [&](Aov aov) { return layout->Find(aov) != nullptr; });
  const std::vector<std::string> missing = MissingFor(*layout);
  if (all && !layout->from_colour) {
    if (missing.empty()) {
      Note(*layout, CheckSeenLayers(image, *layout, false), &layout->notes);
    } else {
      layout->notes.push_back(
          Blurred(*layout, fmt::format("the file has no {}", fmt::join(missing, ", no "))));
    }
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
