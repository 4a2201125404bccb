// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_mapping.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/nearest_names.h"
#include "io/text.h"

namespace stillray {
namespace io {
namespace {

Status UnknownWord(const AovMapping& mapping, const std::string& word, const char* expected) {
  return Status::InvalidArgument(fmt::format("--aov {}: '{}' is not understood, expected {}",
                                             AovName(mapping.aov), OneLine(word), expected));
}

/// The number after "name=" if `word` starts with it and the number is finite and positive.
std::optional<float> PositiveAfter(const std::string& name, const std::string& word) {
  const std::string start = name + "=";
  if (!word.starts_with(start)) {
    return std::nullopt;
  }
  float value = 0;
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data() + start.size(), end, value);
  if (error != std::errc() || stop != end || !(value > 0)) {
    return std::nullopt;
  }
  return value;
}

Status ApplyMotionWord(const AovMapping& mapping, const std::string& word, MotionConvention* c) {
  if (word == "pixels") {
    c->unit = MotionUnit::kPixels;
  } else if (word == "fraction") {
    c->unit = MotionUnit::kFraction;
  } else if (word == "ndc") {
    c->unit = MotionUnit::kNdc;
  } else if (word == "to_previous") {
    c->direction = MotionDirection::kToPrevious;
  } else if (word == "from_previous") {
    c->direction = MotionDirection::kFromPrevious;
  } else if (word == "to_next") {
    c->direction = MotionDirection::kToNext;
  } else if (word == "from_next") {
    c->direction = MotionDirection::kFromNext;
  } else if (word == "y_up" || word == "y_down") {
    c->y_up = word == "y_up";
  } else if (word == "jittered") {
    c->jittered = true;
  } else if (const auto scale = PositiveAfter("scale", word); scale && std::isfinite(*scale)) {
    c->scale = *scale;
  } else {
    return UnknownWord(
        mapping, word,
        "pixels, fraction, ndc, to_previous, from_previous, to_next, from_next, y_up, "
        "y_down, jittered, scale=NUMBER or channels=XY");
  }
  return Status::Ok();
}

Status ApplyDepthWord(const AovMapping& mapping, const std::string& word, DepthConvention* c) {
  constexpr const char* kKinds[] = {"linear",     "ray",       "inverse",
                                    "normalised", "projected", "reversed"};
  const auto kind = std::find(std::begin(kKinds), std::end(kKinds), word);
  if (kind != std::end(kKinds)) {
    c->kind = static_cast<DepthKind>(kind - std::begin(kKinds));
  } else if (const auto near = PositiveAfter("near", word); near && std::isfinite(*near)) {
    c->near = *near;
  } else if (const auto far = PositiveAfter("far", word)) {
    c->far = *far;
  } else if (const auto focal = PositiveAfter("focal", word); focal && std::isfinite(*focal)) {
    c->focal = *focal;
  } else if (const auto background = PositiveAfter("background", word)) {
    c->background = *background;
  } else {
    return UnknownWord(mapping, word,
                       "linear, ray, inverse, normalised, projected, reversed, near=, far=, focal= "
                       "(pixels), background= or channels=Z");
  }
  return Status::Ok();
}

/// As for depth, but only the kinds that are valid for lengths along a ray.
Status ApplyHitWord(const AovMapping& mapping, const std::string& word, DepthConvention* c) {
  const bool no_length = word == "ray" || word == "projected" || word == "reversed";
  if (no_length || !ApplyDepthWord(mapping, word, c).ok()) {
    return UnknownWord(mapping, word,
                       "linear, inverse, normalised, near=, far=, focal= (pixels), background= or "
                       "channels=Z");
  }
  return Status::Ok();
}

/// "x-zy" as {1, -3, 2}. Every axis once.
bool ParseAxes(std::string_view text, std::array<int, 3>* axes) {
  std::array<int, 3> parsed = {0, 0, 0};
  std::array<bool, 3> used = {false, false, false};
  size_t at = 0;
  for (int& axis : parsed) {
    const bool negative = at < text.size() && text[at] == '-';
    at += negative ? 1 : 0;
    if (at >= text.size() || text[at] < 'x' || text[at] > 'z' || used[text[at] - 'x']) {
      return false;
    }
    used[text[at] - 'x'] = true;
    axis = (text[at] - 'x' + 1) * (negative ? -1 : 1);
    ++at;
  }
  if (at != text.size()) {
    return false;
  }
  *axes = parsed;
  return true;
}

Status ApplyNormalWord(const AovMapping& mapping, const std::string& word, NormalConvention* c) {
  if (word == "world" || word == "camera") {
    c->camera_space = word == "camera";
  } else if (word == "encoded" || word == "signed") {
    c->encoded = word == "encoded";
  } else if (!word.starts_with("axes=") || !ParseAxes(word.substr(5), &c->axes)) {
    return UnknownWord(mapping, word,
                       "world, camera, encoded, signed, axes= (such as axes=x-zy) or channels=XYZ");
  }
  return Status::Ok();
}

Status CheckDepth(Aov aov, const DepthConvention& c) {
  if (c.kind == DepthKind::kRay && !(c.focal > 0)) {
    return Status::InvalidArgument("--aov depth: ray needs focal=PIXELS");
  }
  if (c.kind == DepthKind::kNormalised && (!(c.far > c.near) || std::isinf(c.far))) {
    return Status::InvalidArgument(
        fmt::format("--aov {}: normalised needs near= and far= with near < far; they are {} and {}",
                    AovName(aov), c.near, c.far));
  }
  const bool projected = c.kind == DepthKind::kProjected || c.kind == DepthKind::kReversed;
  if (projected && !(c.near > 0 && c.far > c.near)) {
    return Status::InvalidArgument(
        fmt::format("--aov depth: {} needs near= and far= with 0 < near < far; they are {} and {}",
                    c.kind == DepthKind::kProjected ? "projected" : "reversed", c.near, c.far));
  }
  return Status::Ok();
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

Result<AovMapping> ParseAovMapping(const std::string& text) {
  const size_t equals = text.find('=');
  AovMapping mapping;
  std::vector<std::string_view> names;
  bool found = false;
  for (int i = 0; i < kAovCount; ++i) {
    const Aov aov = static_cast<Aov>(i);
    names.push_back(AovName(aov));
    if (equals != std::string::npos && text.substr(0, equals) == AovName(aov)) {
      mapping.aov = aov;
      found = true;
    }
  }
  if (!found) {
    return Status::InvalidArgument(fmt::format(
        "--aov is '{}', expected NAME=LAYER[,WORD...] with NAME one of {}{}", OneLine(text),
        fmt::join(names, ", "), DidYouMean(std::string_view(text).substr(0, equals), names)));
  }
  const std::vector<std::string> parts = SplitAtCommas(text.substr(equals + 1));
  mapping.layer = parts[0];
  for (size_t i = 1; i < parts.size(); ++i) {
    if (parts[i].starts_with("channels=")) {
      mapping.channels = parts[i].substr(9);
    } else {
      mapping.words.push_back(parts[i]);
    }
  }
  return mapping;
}

Status ApplyWords(const AovMapping& mapping, AovLayout* layout) {
  for (const std::string& word : mapping.words) {
    switch (mapping.aov) {
      case Aov::kMotion:
        STILLRAY_RETURN_IF_ERROR(ApplyMotionWord(mapping, word, &layout->motion));
        break;
      case Aov::kNextMotion:
        STILLRAY_RETURN_IF_ERROR(ApplyMotionWord(mapping, word, &layout->next_motion));
        break;
      case Aov::kDepth:
        STILLRAY_RETURN_IF_ERROR(ApplyDepthWord(mapping, word, &layout->depth));
        break;
      case Aov::kSpecularMotion:
        STILLRAY_RETURN_IF_ERROR(ApplyMotionWord(mapping, word, &layout->specular_motion));
        break;
      case Aov::kHitDistance:
        STILLRAY_RETURN_IF_ERROR(ApplyHitWord(mapping, word, &layout->hit_distance));
        break;
      case Aov::kNormal:
        STILLRAY_RETURN_IF_ERROR(ApplyNormalWord(mapping, word, &layout->normal));
        break;
      default:
        return UnknownWord(mapping, word, "channels=LETTERS and nothing else");
    }
  }
  const MotionDirection next = layout->next_motion.direction;
  if (mapping.aov == Aov::kNextMotion && next != MotionDirection::kToNext &&
      next != MotionDirection::kFromNext) {
    return Status::InvalidArgument(
        fmt::format("--aov next_motion: its direction is {}, expected to_next or from_next",
                    next == MotionDirection::kToPrevious ? "to_previous" : "from_previous"));
  }
  if (mapping.aov == Aov::kHitDistance) {
    return CheckDepth(mapping.aov, layout->hit_distance);
  }
  return mapping.aov == Aov::kDepth ? CheckDepth(mapping.aov, layout->depth) : Status::Ok();
}

}  // namespace io

const char* AovName(Aov aov) {
  constexpr const char* kNames[kAovCount] = {"colour",
                                             "result",
                                             "alpha",
                                             "depth",
                                             "normal",
                                             "previous_normal",
                                             "motion",
                                             "next_motion",
                                             "albedo",
                                             "specular_albedo",
                                             "transmission_albedo",
                                             "fallback_albedo",
                                             "fallback_normal",
                                             "seen_depth",
                                             "seen_normal",
                                             "seen_albedo",
                                             "hit_distance",
                                             "specular_motion",
                                             "reflection_depth",
                                             "reflection_normal",
                                             "reflection_albedo",
                                             "reflection_motion",
                                             "reflection_id",
                                             "refraction_depth",
                                             "refraction_normal",
                                             "refraction_albedo",
                                             "refraction_motion",
                                             "refraction_id",
                                             "id",
                                             "cryptomatte",
                                             "roughness",
                                             "samples",
                                             "confidence",
                                             "direct_diffuse",
                                             "indirect_diffuse",
                                             "direct_specular",
                                             "indirect_specular",
                                             "direct_transmission",
                                             "indirect_transmission",
                                             "direct_volume",
                                             "indirect_volume",
                                             "emission",
                                             "background"};
  return kNames[static_cast<size_t>(aov)];
}

}  // namespace stillray
