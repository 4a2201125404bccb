// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The table of the path tracer's settings. Defaults are the initialisers of RenderSettings.
#include <cmath>
#include <optional>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "core/parameter_table.h"
#include "stillray/render.h"

namespace stillray {
namespace {

struct Row {
  Parameter info;
  ParameterMember<RenderSettings> member;
  bool changes_light = false;  ///< see SameLight
};

std::string RateText(const RenderSettings& s) {
  return s.cycle == 1 ? fmt::format("{}", s.spp) : fmt::format("{}/{}", s.spp, s.cycle);
}

/// Parses n from "1/n" or from its decimal value; 0 if the text is neither.
int ParseCycle(std::string_view text) {
  int cycle = 0;
  double decimal = 0;
  if (text.substr(0, 2) == "1/") {
    ParseNumber(text.substr(2), &cycle);
  } else if (ParseNumber(text, &decimal) && decimal > 0.5 / kMaxCycle && decimal < 1) {
    const double frames = std::round(1 / decimal);
    // Decimals with three digits, such as 0.333, are rounded to the nearest 1/n.
    cycle = std::abs(decimal * frames - 1) < 0.005 ? static_cast<int>(frames) : 0;
  }
  return cycle >= 2 && cycle <= kMaxCycle ? cycle : 0;
}

bool SetRate(RenderSettings* s, std::string_view text, const Parameter& info) {
  if (ParseInRange(text, info, &s->spp)) {
    s->cycle = 1;
    return true;
  }
  const int cycle = ParseCycle(text);
  if (cycle > 0) {
    s->spp = 1;
    s->cycle = cycle;
  }
  return cycle > 0;
}

std::string ExpectedRate(const Parameter& info) {
  return fmt::format("1 to {}, or 1/2 to 1/{} for one path per pixel in several frames", info.max,
                     1 / info.min);
}

constexpr std::string_view kOfScene = "scene";

template <typename T>
std::string TextOf(const std::optional<T>& value) {
  if constexpr (std::is_same_v<T, int>) {
    return value ? std::to_string(*value) : std::string(kOfScene);
  } else {
    return value ? NumberText(*value) : std::string(kOfScene);
  }
}

std::string ApertureText(const RenderSettings& s) {
  if (s.f_number) {
    return "f/" + TextOf(s.f_number);
  }
  return TextOf(s.aperture);
}

bool SetAperture(RenderSettings* s, std::string_view text, const Parameter& info) {
  if (text == kOfScene) {
    s->aperture.reset();
    s->f_number.reset();
    return true;
  }
  float number = 0;
  if (text.substr(0, 2) == "f/") {
    if (!ParseNumber(text.substr(2), &number) || !(number >= kMinFNumber) ||
        !(number <= kMaxFNumber)) {
      return false;
    }
    s->aperture.reset();
    s->f_number = number;
    return true;
  }
  if (!ParseInRange(text, info, &number)) {
    return false;
  }
  s->aperture = number;
  s->f_number.reset();
  return true;
}

std::string ExpectedAperture(const Parameter& info) {
  return fmt::format("scene, a radius from 0 to {:g}, or f/{:g} to f/{:g}", info.max, kMinFNumber,
                     kMaxFNumber);
}

std::string FocusText(const RenderSettings& s) {
  return s.focus && *s.focus == 0.0f ? "auto" : TextOf(s.focus);
}

bool SetFocus(RenderSettings* s, std::string_view text, const Parameter& info) {
  float number = 0;
  if (text == kOfScene) {
    s->focus.reset();
    return true;
  }
  if (text == "auto") {
    s->focus = 0.0f;
    return true;
  }
  if (!ParseInRange(text, info, &number) || !(number > 0.0f)) {
    return false;
  }
  s->focus = number;
  return true;
}

std::string ExpectedFocus(const Parameter& info) {
  return fmt::format("scene, auto, or a distance above 0 and up to {:g}", info.max);
}

bool SetBlades(RenderSettings* s, std::string_view text, const Parameter& info) {
  int number = 0;
  if (text == kOfScene) {
    s->blades.reset();
    return true;
  }
  if (!ParseInRange(text, info, &number) || number == 1 || number == 2) {
    return false;
  }
  s->blades = number;
  return true;
}

std::string ExpectedBlades(const Parameter&) {
  return fmt::format("scene, 0, or 3 to {}", kMaxBlades);
}

bool SetBladeRotation(RenderSettings* s, std::string_view text, const Parameter& info) {
  float number = 0;
  if (text == kOfScene) {
    s->blade_rotation.reset();
    return true;
  }
  if (!ParseInRange(text, info, &number)) {
    return false;
  }
  s->blade_rotation = number;
  return true;
}

std::string ExpectedRotation(const Parameter& info) {
  return fmt::format("scene, or {:g} to {:g} degrees", info.min, info.max);
}

void AddLens(std::vector<Row>* table) {
  using S = RenderSettings;
  table->push_back(
      {.info = {.name = "aperture",
                .type = ParameterType::kText,
                .group = "lens",
                .help = "Radius of the lens in scene units, or its f-number; 0: a pinhole.",
                .max = kMaxAperture,
                .choices = {"scene", "RADIUS", "f/N"}},
       .member = TextMember<S>{ApertureText, SetAperture, ExpectedAperture},
       .changes_light = true});
  table->push_back({.info = {.name = "focus",
                             .type = ParameterType::kText,
                             .group = "lens",
                             .help = "Depth that is sharp, in scene units; auto: that of the "
                                     "surface in the picture's centre, in every frame.",
                             .max = kMaxFocus,
                             .choices = {"scene", "auto", "DISTANCE"}},
                    .member = TextMember<S>{FocusText, SetFocus, ExpectedFocus},
                    .changes_light = true});
  table->push_back({.info = {.name = "blades",
                             .type = ParameterType::kText,
                             .group = "lens",
                             .help = "Corners of the aperture, a regular polygon; 0: a circle.",
                             .max = kMaxBlades,
                             .choices = {"scene", "N"}},
                    .member = TextMember<S>{[](const S& s) { return TextOf(s.blades); }, SetBlades,
                                            ExpectedBlades},
                    .changes_light = true});
  table->push_back(
      {.info = {.name = "blade_rotation",
                .type = ParameterType::kText,
                .group = "lens",
                .help = "Turns that polygon anticlockwise, in degrees; a corner is at the right "
                        "at 0.",
                .min = -180,
                .max = 180,
                .choices = {"scene", "DEGREES"}},
       .member = TextMember<S>{[](const S& s) { return TextOf(s.blade_rotation); },
                               SetBladeRotation, ExpectedRotation},
       .changes_light = true});
}

std::vector<Row> MakeTable() {
  using S = RenderSettings;
  std::vector<Row> t;
  t.push_back({.info = {.name = "spp",
                        .type = ParameterType::kRate,
                        .group = "sampling",
                        .help = "Paths per pixel and frame; 1/2 to 1/256: one path per pixel in "
                                "that many frames.",
                        .min = 1.0 / kMaxCycle,
                        .max = kMaxSpp},
               .member = TextMember<S>{RateText, SetRate, ExpectedRate}});
  t.push_back({.info = {.name = "guides",
                        .type = ParameterType::kChoice,
                        .group = "sampling",
                        .help = "Below one path per pixel: guides of all pixels, or only of those "
                                "where a path is traced.",
                        .choices = {"full", "sparse"}},
               .member = Choice<S, &S::guides>()});
  t.push_back({.info = {.name = "seed",
                        .type = ParameterType::kSeed,
                        .group = "sampling",
                        .help = "Seed of the random numbers."},
               .member = &S::seed});
  t.push_back({.info = {.name = "sampler",
                        .type = ParameterType::kChoice,
                        .group = "sampling",
                        .help = "Owen-scrambled Sobol' points per pixel, cycles of the 16 Halton "
                                "points of SVGF (section 3), or Sobol' points that are stratified "
                                "over blocks of 8x8 pixels too, for less noise after a filter.",
                        .choices = {"sobol", "halton16", "zsobol"}},
               .member = Choice<S, &S::sampler>()});
  t.push_back({.info = {.name = "light_candidates",
                        .type = ParameterType::kInt,
                        .group = "sampling",
                        .help = "Lights, or points on them, that a surface draws before it sends "
                                "a shadow ray to one, chosen by how much it would add: less noise "
                                "for more time. Surfaces after the first draw half as many.",
                        .min = 1,
                        .max = kMaxLightCandidates},
               .member = &S::light_candidates});
  t.push_back({.info = {.name = "jitter",
                        .type = ParameterType::kFlag,
                        .group = "sampling",
                        .help = "The sample point moves within its pixel from frame to frame, for "
                                "antialiasing in time; pixel centres without."},
               .member = &S::jitter});
  t.push_back({.info = {.name = "filter_textures",
                        .type = ParameterType::kFlag,
                        .group = "sampling",
                        .help = "Base colour textures of visible surfaces, and of what smooth "
                                "mirrors and glass show, are averaged over their pixel, so that "
                                "fine textures do not flicker; only with jitter."},
               .member = &S::filter_textures});
  t.push_back({.info = {.name = "virtual_guides",
                        .type = ParameterType::kFlag,
                        .group = "sampling",
                        .help = "Guides of what mirrors and glass show, by extra rays from smooth "
                                "surfaces; light that comes through glass and blended surfaces is "
                                "then separate."},
               .member = &S::virtual_guides});
  t.push_back({.info = {.name = "bounces",
                        .type = ParameterType::kInt,
                        .group = "paths",
                        .help = "Surfaces at which a path may scatter after the first one.",
                        .min = 1,
                        .max = 32},
               .member = &S::bounces,
               .changes_light = true});
  t.push_back({.info = {.name = "regularise",
                        .type = ParameterType::kFlag,
                        .group = "paths",
                        .help = "Surfaces that a path meets after a rough one are treated as "
                                "rougher: fewer fireflies, dimmer caustics."},
               .member = &S::regularise,
               .changes_light = true});
  t.push_back({.info = {.name = "light_sampling",
                        .type = ParameterType::kChoice,
                        .group = "paths",
                        .help = "How paths find light: scattered rays alone, shadow rays only to "
                                "lights without extent, shadow rays to all lights, or both, "
                                "weighted by multiple importance sampling.",
                        .choices = {"none", "bsdf", "light", "mis"}},
               .member = Choice<S, &S::light_sampling>(),
               .changes_light = true});
  t.push_back({.info = {.name = "clamp_radiance",
                        .type = ParameterType::kFloat,
                        .group = "paths",
                        .help = "Limit of the light that one ray adds to a sample: fewer "
                                "fireflies, darker pictures; 0: no limit.",
                        .min = 0,
                        .max = kMaxClamp},
               .member = &S::clamp_radiance,
               .changes_light = true});
  AddLens(&t);
  return t;
}

const std::vector<Row>& Table() {
  static const std::vector<Row> table = MakeTable();
  return table;
}

Result<const Row*> FindRow(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Row& row : Table()) {
    if (name == row.info.name) {
      return &row;
    }
    names.push_back(row.info.name);
  }
  const std::string meant = DidYouMean(name, RenderParameters());
  return Status::InvalidArgument(fmt::format(
      "unknown render setting '{}'{}", name,
      meant.empty() ? fmt::format("; settings are: {}", fmt::join(names, ", ")) : meant));
}

Status BadValue(const Row& row, std::string_view value) {
  return Status::InvalidArgument(
      fmt::format("{} {}", row.info.name, BadMemberText(row.info, row.member, value)));
}

Status CheckSide(const char* name, int pixels) {
  if (pixels >= 1 && pixels <= kMaxSide) {
    return Status::Ok();
  }
  return Status::InvalidArgument(
      fmt::format("{} is {}, expected 1 to {} pixels", name, pixels, kMaxSide));
}

}  // namespace

std::span<const Parameter> RenderParameters() {
  static const std::vector<Parameter> parameters = InfosOf(Table());
  return parameters;
}

Status SetRenderParameter(RenderSettings* settings, std::string_view name, std::string_view value) {
  const Result<const Row*> row = FindRow(name);
  STILLRAY_RETURN_IF_ERROR(row.status());
  const bool valid = SetMember((*row)->info, (*row)->member, value, settings);
  return valid ? Status::Ok() : BadValue(**row, value);
}

Result<std::string> GetRenderParameter(const RenderSettings& settings, std::string_view name) {
  const Result<const Row*> row = FindRow(name);
  STILLRAY_RETURN_IF_ERROR(row.status());
  return GetMember((*row)->info, (*row)->member, settings);
}

Status ValidateRenderSettings(const RenderSettings& settings) {
  STILLRAY_RETURN_IF_ERROR(CheckSide("width", settings.width));
  STILLRAY_RETURN_IF_ERROR(CheckSide("height", settings.height));
  for (const Row& row : Table()) {
    RenderSettings scratch = settings;
    const std::string value = GetMember(row.info, row.member, settings);
    if (!SetMember(row.info, row.member, value, &scratch)) {
      return BadValue(row, value);
    }
  }
  return Status::Ok();
}

bool SameLight(const RenderSettings& a, const RenderSettings& b) {
  for (const Row& row : Table()) {
    if (row.changes_light &&
        GetMember(row.info, row.member, a) != GetMember(row.info, row.member, b)) {
      return false;
    }
  }
  return true;
}

}  // namespace stillray
