// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_seen.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/cameras.h"
#include "io/aov_light.h"
#include "io/text.h"

namespace stillray::io {
namespace {

constexpr Aov kSeen[] = {Aov::kSeenDepth, Aov::kSeenNormal, Aov::kSeenAlbedo};

bool PointsToPrevious(const MotionConvention& motion) {
  return motion.direction == MotionDirection::kToPrevious ||
         motion.direction == MotionDirection::kFromPrevious;
}

/// The layers needed for comparison that are missing in the file.
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

/// The inconsistent pass, and the remedy.
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
    case NoSeenGuides::kFocal:
      return fmt::format(
          "the focal length, by which {} becomes the depth of images, is not in the file, and "
          "depth "
          "and normals reveal none: give it in pixels (--aov hit_distance=LAYER,focal=PIXELS), or "
          "the cameras (--cameras FILE.json)",
          LayerNameOf(layout, Aov::kHitDistance));
    case NoSeenGuides::kNone:
      break;
  }
  return "";
}

constexpr const char* kBlurred = "reflections and refractions do not follow ";
constexpr const char* kBlurredHits = "reflections do not follow ";

std::string Blurred(const AovLayout& layout, Aov aov, const std::string& reason) {
  return fmt::format("{}{}, and are blurred where they move: {}",
                     aov == Aov::kHitDistance ? kBlurredHits : kBlurred, LayerNameOf(layout, aov),
                     reason);
}

void Note(const AovLayout& used, Aov aov, NoSeenGuides why, std::vector<std::string>* notes) {
  if (why != NoSeenGuides::kNone) {
    notes->push_back(Blurred(used, aov, Reason(used, why)));
  } else if (aov == Aov::kHitDistance) {
    notes->push_back(fmt::format("reflections follow {}", LayerNameOf(used, aov)));
  } else {
    notes->push_back(fmt::format(
        "reflections in mirrors and what is seen through glass follow {}, and the normals and "
        "albedo beside it",
        LayerNameOf(used, aov)));
  }
}

bool IsBlurredNote(const std::string& note) {
  return note.starts_with(kBlurred) || note.starts_with(kBlurredHits);
}

bool ReflectsLight(const AovLayout& layout) {
  return !layout.from_colour && (layout.Find(Aov::kDirectSpecular) != nullptr ||
                                 layout.Find(Aov::kIndirectSpecular) != nullptr);
}

/// Why hit distances cannot be used at all; empty if they can.
std::string WhyUnused(const AovLayout& layout) {
  if (!ReflectsLight(layout)) {
    return "no layers hold reflected light of its own (direct_specular, indirect_specular)";
  }
  if (layout.Find(Aov::kReflectionDepth) != nullptr) {
    return fmt::format("{} is given as reflection_depth",
                       LayerNameOf(layout, Aov::kReflectionDepth));
  }
  return layout.Find(Aov::kDepth) == nullptr ? "the file has no depth" : "";
}

/// Drops a layer, and notes why.
void DropUnused(Aov aov, const std::string& why, AovLayout* layout) {
  layout->notes.push_back(
      fmt::format("{} is not used as {}: {}", LayerNameOf(*layout, aov), AovName(aov), why));
  Drop(aov, layout);
}

}  // namespace

std::string LackOfImages(const AovLayout& layout, NoSeenGuides why) {
  if (why == NoSeenGuides::kNone) {
    return "";
  }
  for (const Aov aov : {Aov::kHitDistance, Aov::kSeenDepth}) {
    if (layout.Find(aov) != nullptr) {
      return Blurred(layout, aov, Reason(layout, why));
    }
  }
  return fmt::format("reflections in convex surfaces do not follow the image behind them: {}",
                     Reason(layout, why));
}

bool IsNotedInLayout(const AovLayout& layout) {
  return std::any_of(layout.notes.begin(), layout.notes.end(), IsBlurredNote);
}

void NoteSeenGuidesOfKnownCamera(const ExrImage& image, AovLayout* layout) {
  if (!IsNotedInLayout(*layout)) {
    return;
  }
  std::erase_if(layout->notes, IsBlurredNote);
  if (layout->Find(Aov::kSeenDepth) != nullptr) {
    Note(*layout, Aov::kSeenDepth, CheckSeenLayers(image, *layout, true), &layout->notes);
  }
  if (layout->Find(Aov::kHitDistance) != nullptr) {
    Note(*layout, Aov::kHitDistance, CheckHitLayers(image, *layout, true), &layout->notes);
  }
}

void DecideSeenGuides(const ExrImage& image, AovLayout* layout) {
  const bool all = std::all_of(std::begin(kSeen), std::end(kSeen),
                               [&](Aov aov) { return layout->Find(aov) != nullptr; });
  const std::vector<std::string> missing = MissingFor(*layout);
  if (all && !layout->from_colour) {
    if (missing.empty()) {
      Note(*layout, Aov::kSeenDepth, CheckSeenLayers(image, *layout, false), &layout->notes);
    } else {
      layout->notes.push_back(
          Blurred(*layout, Aov::kSeenDepth,
                  fmt::format("the file has no {}", fmt::join(missing, ", no "))));
    }
  }
  if (!all || layout->from_colour || !missing.empty()) {
    // Hit distances replace the kSeen depth; the other kSeen layers are still used.
    const bool has_hits = layout->Find(Aov::kHitDistance) != nullptr && !layout->from_colour;
    for (const Aov aov : kSeen) {
      if (!has_hits || aov == Aov::kSeenDepth) {
        Drop(aov, layout);
      }
    }
  }
}

void DecideHits(const ExrImage& image, AovLayout* layout) {
  if (layout->Find(Aov::kHitDistance) != nullptr) {
    const std::string why = WhyUnused(*layout);
    if (why.empty()) {
      const auto camera = CameraOf(image);
      const bool has_camera = camera && HasPerspective(*camera, image.width, image.height);
      Note(*layout, Aov::kHitDistance, CheckHitLayers(image, *layout, has_camera), &layout->notes);
    } else {
      DropUnused(Aov::kHitDistance, why, layout);
    }
  }
  const bool has_images = layout->Find(Aov::kHitDistance) != nullptr ||
                          layout->Find(Aov::kSeenDepth) != nullptr ||
                          layout->Find(Aov::kReflectionDepth) != nullptr;
  if (layout->Find(Aov::kSpecularMotion) != nullptr && !has_images) {
    DropUnused(
        Aov::kSpecularMotion,
        "the depth of what is reflected is unknown (hit_distance, seen_depth with normal and "
        "albedo, or reflection_depth)",
        layout);
  }
}

void DecideCurvedImages(const ExrImage& image, AovLayout* layout) {
  const bool has_shape =
      layout->Find(Aov::kDepth) != nullptr && layout->Find(Aov::kNormal) != nullptr;
  const bool moves = layout->Find(Aov::kMotion) == nullptr || PointsToPrevious(layout->motion);
  layout->curved_images = layout->renderer != "stillray" && ReflectsLight(*layout) && has_shape &&
                          moves && layout->Find(Aov::kReflectionDepth) == nullptr &&
                          HasCurvedImages(image, *layout);
  if (layout->curved_images) {
    layout->notes.emplace_back(
        "reflections in convex surfaces follow the image behind them, whose place their shape "
        "gives");
  }
}

}  // namespace stillray::io
