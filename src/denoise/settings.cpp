// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "core/parameter_table.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using Member = ParameterMember<Settings>;

/// A row of the table with what only this file needs: the member, and the values of the presets
/// other than "default", whose values are the initialisers of Settings. nullptr: as in "default".
struct Row {
  Parameter info;
  Member member;
  const char* svgf = nullptr;
  const char* eaw = nullptr;
  const char* temporal = nullptr;
};

Row FloatRow(const char* name, float Settings::*member, double min, double max, const char* group,
             const char* unit, const char* symbol, const char* help, const char* svgf = nullptr,
             const char* eaw = nullptr, const char* temporal = nullptr) {
  return {{name, ParameterType::kFloat, group, help, unit, symbol, min, max, {}},
          member,
          svgf,
          eaw,
          temporal};
}
Row IntRow(const char* name, int Settings::*member, double min, double max, const char* group,
           const char* unit, const char* symbol, const char* help, const char* svgf = nullptr,
           const char* eaw = nullptr, const char* temporal = nullptr) {
  return {{name, ParameterType::kInt, group, help, unit, symbol, min, max, {}},
          member,
          svgf,
          eaw,
          temporal};
}
Row FlagRow(const char* name, bool Settings::*member, const char* group, const char* help,
            const char* svgf = nullptr, const char* eaw = nullptr, const char* temporal = nullptr) {
  return {{name, ParameterType::kFlag, group, help, "", "", 0, 1, {}}, member, svgf, eaw, temporal};
}
Row ChoiceRow(const char* name, ChoiceMember<Settings> member, std::vector<const char*> choices,
              const char* group, const char* help, const char* svgf = nullptr,
              const char* eaw = nullptr, const char* temporal = nullptr) {
  const double last = static_cast<double>(choices.size()) - 1;
  return {{name, ParameterType::kChoice, group, help, "", "", 0, last, std::move(choices)},
          member,
          svgf,
          eaw,
          temporal};
}

std::string StepsText(const Settings& s) {
  const int count = std::clamp(s.steps.count, 0, kMaxLevels);
  return fmt::format("{}", fmt::join(s.steps.step.begin(), s.steps.step.begin() + count, ","));
}

bool SetSteps(Settings* s, std::string_view text, const Parameter& info) {
  StepList list;
  list.count = 0;
  list.step = {};
  while (true) {
    const size_t comma = text.find(',');
    int step = 0;
    if (list.count == kMaxLevels || !ParseInRange(text.substr(0, comma), info, &step)) {
      return false;
    }
    list.step[static_cast<size_t>(list.count++)] = step;
    if (comma == std::string_view::npos) {
      break;
    }
    text.remove_prefix(comma + 1);
  }
  s->steps = list;
  return true;
}

std::string ExpectedSteps(const Parameter& info) {
  return fmt::format("1 to {} whole numbers from {} to {}, such as 1,2,4,8,16", kMaxLevels,
                     info.min, info.max);
}

std::vector<Row> MakeTable() {
  std::vector<Row> t;
  t.push_back(
      FlagRow("fill_guides", &Settings::fill_guides, "fill_guides",
              "Guides of pixels of which nothing is known (depth 0 and no sample) come from "
              "earlier frames, or from the nearest that are known."));
  t.push_back(ChoiceRow(
      "signals", Choice<Settings, &Settings::signals>(),
      {"split", "direct_indirect", "diffuse_specular", "single"}, "demodulate",
      "How light is grouped into signals with a filter and a history of their own: direct diffuse, "
      "indirect diffuse and specular; direct and indirect; diffuse and specular; all in one."));
  t.push_back(FlagRow("demodulate", &Settings::demodulate, "demodulate",
                      "Divide light by the albedo before filtering, so that textures stay sharp."));
  t.push_back(ChoiceRow("firefly", Choice<Settings, &Settings::firefly>(),
                        {"off", "clamp", "compress"}, "suppress_fireflies",
                        "Limit single bright samples: to the brightest neighbour, or by filtering "
                        "under a curve that compresses a luminance above 32."));
  t.push_back(FlagRow("temporal", &Settings::temporal, "accumulate",
                      "Accumulate light from earlier frames.", nullptr, "off"));
  t.push_back(ChoiceRow("history_weight", Choice<Settings, &Settings::history_weight>(),
                        {"constant", "age"}, "accumulate",
                        "Weight of a new frame: alpha_min wherever there is history, or 1/age "
                        "until alpha_min is reached.",
                        "constant"));
  t.push_back(FloatRow(
      "alpha_min", &Settings::alpha_min, 0.0, 1.0, "accumulate", "", "alpha",
      "Smallest weight of a new frame's light; 0 with history_weight=age is a plain mean.", "0.2"));
  t.push_back(FloatRow("alpha_moments", &Settings::alpha_moments, 0.0, 1.0, "accumulate", "",
                       "alpha", "Smallest weight of a new frame's luminance moments.", "0.2"));
  t.push_back(IntRow("max_history", &Settings::max_history, 0, 1 << 20, "accumulate", "samples", "",
                     "Longest history that counts; 0 for no limit."));
  t.push_back(FloatRow("history_depth", &Settings::history_depth, 1e-4, 10.0, "reproject",
                       "of depth", "",
                       "Largest difference of depth between a pixel and its history."));
  t.push_back(FloatRow("history_normal", &Settings::history_normal, 0.0, 180.0, "reproject",
                       "degrees", "",
                       "Largest angle between the normals of a pixel and its history."));
  t.push_back(FlagRow("history_id", &Settings::history_id, "reproject",
                      "History must have the same surface id, where ids are given."));
  t.push_back(
      FlagRow("history_search", &Settings::history_search, "reproject",
              "Search the 3x3 pixels around the place when no bilinear tap shows the surface."));
  t.push_back(FlagRow(
      "limit_history", &Settings::limit_history, "limit_history",
      "Shorten histories that no longer resemble the present, where the light itself changed.",
      "off", "off", "off"));
  t.push_back(FloatRow("limit_gain", &Settings::limit_gain, 0.0, 1000.0, "limit_history", "", "",
                       "How quickly a history that does not resemble the present is given up."));
  t.push_back(FloatRow(
      "limit_dead", &Settings::limit_dead, 0.0, 1000.0, "limit_history", "", "",
      "How far beyond the expected noise, in variances, a difference may go before it counts."));
  t.push_back(ChoiceRow("variance_of", Choice<Settings, &Settings::variance_of>(),
                        {"frame", "mean"}, "estimate_variance",
                        "Noise that steers the filter: of a single frame (the papers), or of the "
                        "accumulated mean, which "
                        "lets the filter shrink as a still view converges.",
                        "frame", "frame"));
  t.push_back(ChoiceRow("short_history", Choice<Settings, &Settings::short_history>(),
                        {"spatial", "blur"}, "estimate_variance",
                        "While the history is short: estimate the variance from the 7x7 "
                        "neighbourhood, or filter without "
                        "regard to luminance."));
  t.push_back(IntRow("short_history_length", &Settings::short_history_length, 0, 64,
                     "estimate_variance", "samples", "", "Histories below this length are short."));
  t.push_back(FloatRow(
      "short_history_boost", &Settings::short_history_boost, 0.0, 4.0, "estimate_variance", "", "",
      "Power of (short_history_length / length) by which estimates of short histories are raised.",
      "0"));
  t.push_back(
      FlagRow("prefilter_variance", &Settings::prefilter_variance, "prefilter_variance",
              "Smooth the variance with a 3x3 kernel before it scales the luminance weight."));
  t.push_back(ChoiceRow(
      "wavelet", Choice<Settings, &Settings::wavelet>(), {"off", "naive", "eaw", "svgf"}, "atrous",
      "Spatial filter: none; without edge stops (for comparison); edge-avoiding Gaussians; "
      "variance-guided.",
      nullptr, "eaw", "off"));
  t.push_back(ChoiceRow("kernel", Choice<Settings, &Settings::kernel>(), {"3x3", "5x5"}, "atrous",
                        "Kernel of each level."));
  t.push_back({{"steps",
                ParameterType::kSteps,
                "atrous",
                "Distance of the taps of each level, in the order of filtering.",
                "pixels",
                "",
                1,
                64,
                {}},
               TextMember<Settings>{StepsText, SetSteps, ExpectedSteps}});
  t.push_back(IntRow("feedback", &Settings::feedback, 0, kMaxLevels, "atrous", "level", "",
                     "Which level's output becomes the history of the next frame; 0: none, the "
                     "accumulated light itself.",
                     "1"));
  t.push_back(ChoiceRow(
      "feedback_when", Choice<Settings, &Settings::feedback_when>(), {"frame", "sample", "blend"},
      "atrous",
      "When filtered light becomes history: after every frame; once a whole sample per pixel has "
      "arrived; then, but blended in until the next one. All are the same at one sample per pixel "
      "and above.",
      "frame"));
  t.push_back(FloatRow("sigma_n", &Settings::sigma_n, 0.0, 1024.0, "edge_stopping", "", "sigma_n",
                       "Exponent of the normal weight: larger keeps finer creases.", "128"));
  t.push_back(ChoiceRow("depth_weight", Choice<Settings, &Settings::depth_weight>(),
                        {"gradient", "plane"}, "edge_stopping",
                        "Depth differences are held against the slope (the papers), or measured "
                        "from the plane through "
                        "the pixel.",
                        "gradient"));
  t.push_back(FloatRow("sigma_z", &Settings::sigma_z, 1e-3, 1000.0, "edge_stopping", "", "sigma_z",
                       "Tolerance of depth_weight=gradient, in slopes."));
  t.push_back(FloatRow("plane_tolerance", &Settings::plane_tolerance, 1e-5, 10.0, "edge_stopping",
                       "of depth", "",
                       "Distance from the plane at which depth_weight=plane has fallen to 1/e."));
  t.push_back(FloatRow("depth_epsilon", &Settings::depth_epsilon, 1e-6, 1.0, "edge_stopping",
                       "of depth", "epsilon", "Smallest tolerance of depth_weight=gradient."));
  t.push_back(FloatRow("max_slope", &Settings::max_slope, 0.0, 100.0, "edge_stopping",
                       "of depth per pixel", "",
                       "Slopes beyond this switch depth_weight=gradient off; 0: never."));
  t.push_back(FloatRow(
      "sigma_l", &Settings::sigma_l, 1e-3, 1000.0, "edge_stopping", "", "sigma_l",
      "Tolerance of the luminance weight, in standard deviations: larger blurs more.", "4"));
  t.push_back(FloatRow("luminance_epsilon", &Settings::luminance_epsilon, 0.0, 10.0,
                       "edge_stopping", "of luminance", "epsilon",
                       "Smallest tolerance of the luminance weight."));
  t.push_back(ChoiceRow("luminance", Choice<Settings, &Settings::luminance>(), {"rec709", "rec601"},
                        "edge_stopping", "Weights of red, green and blue in luminance."));
  t.push_back(ChoiceRow(
      "luminance_scale", Choice<Settings, &Settings::luminance_scale>(), {"deviation", "variance"},
      "edge_stopping",
      "Luminance differences are divided by the standard deviation, or, as PSVGF prints it, by the "
      "variance: the result then depends on exposure."));
  t.push_back(FloatRow(
      "noise_ratio", &Settings::noise_ratio, 1.0, 100.0, "edge_stopping", "", "",
      "How far a noisier neighbour may raise the noise that luminance differences are measured in. "
      "At 1, as in the papers, sparsely lit surfaces come out too dark; large values blur "
      "penumbras.",
      "1"));
  t.push_back(FlagRow("wavelet_id", &Settings::wavelet_id, "edge_stopping",
                      "Never filter across different surface ids."));
  t.push_back(FloatRow("eaw_sigma_l", &Settings::eaw_sigma_l, 1e-3, 1000.0, "edge_stopping",
                       "mean luminances", "sigma_rt",
                       "Width of the luminance Gaussian of wavelet=eaw; halves with every level."));
  t.push_back(FloatRow("eaw_sigma_n", &Settings::eaw_sigma_n, 1e-3, 100.0, "edge_stopping", "",
                       "sigma_n", "Width of the Gaussian of normal differences of wavelet=eaw."));
  t.push_back(FloatRow("eaw_sigma_z", &Settings::eaw_sigma_z, 1e-4, 100.0, "edge_stopping",
                       "of depth", "sigma_x",
                       "Width of the Gaussian of distances from the plane of wavelet=eaw."));
  t.push_back(
      FloatRow("mirror_roughness", &Settings::mirror_roughness, 0.0, 1.0, "keep_mirrors", "", "",
               "Reflections and refractions of surfaces up to this roughness keep this frame's "
               "samples where their noise is less than what the filter would change; 0: never.",
               "0", "0", "0"));
  t.push_back(ChoiceRow(
      "antialias", Choice<Settings, &Settings::antialias>(), {"off", "taa", "auto"}, "antialias",
      "Temporal antialiasing of the finished picture: never, always, or where frames are jittered. "
      "Without jitter it only blurs.",
      nullptr, "off", "off"));
  t.push_back(FloatRow("taa_alpha", &Settings::taa_alpha, 0.0, 1.0, "antialias", "", "alpha",
                       "Weight of the new frame in temporal antialiasing."));
  t.push_back(
      ChoiceRow("fxaa", Choice<Settings, &Settings::fxaa>(), {"off", "sparse", "on"}, "fxaa",
                "Smooth jagged edges within the frame: never; below one sample per pixel, of "
                "pixels with fewer than "
                "four samples; always.",
                "off", "off", "off"));
  t.push_back(FloatRow("exposure", &Settings::exposure, -32.0, 32.0, "tonemap", "EV", "",
                       "Light is multiplied by 2^exposure for display; linear files are not."));
  t.push_back(ChoiceRow("tonemap", Choice<Settings, &Settings::tonemap>(),
                        {"linear", "reinhard", "filmic", "aces"}, "tonemap",
                        "Tone curve for display; linear files have none."));
  t.push_back(FloatRow("dither", &Settings::dither, 0.0, 8.0, "tonemap", "8-bit steps", "",
                       "Noise added for display, against bands in slow gradients; linear files "
                       "have none."));
  return t;
}

const std::vector<Row>& Table() {
  static const std::vector<Row> table = MakeTable();
  return table;
}

const Row* FindRow(std::string_view name) {
  for (const Row& row : Table()) {
    if (name == row.info.name) {
      return &row;
    }
  }
  return nullptr;
}

Status UnknownParameter(std::string_view name) {
  const std::string meant = DidYouMean(name, Parameters());
  return Status::InvalidArgument(
      fmt::format("unknown parameter '{}'{}", name,
                  meant.empty() ? "; docs/parameters.md lists all of them" : meant));
}

Status BadValue(const Row& row, std::string_view value) {
  return Status::InvalidArgument(
      fmt::format("parameter '{}' {}", row.info.name, BadMemberText(row.info, row.member, value)));
}

constexpr std::string_view kPresets[] = {"default", "svgf", "psvgf", "eaw", "temporal"};

/// Progressive SVGF (Dundr 2018), where it differs from "default".
constexpr std::pair<const char*, const char*> kPsvgf[] = {
    {"signals", "single"},
    {"alpha_min", "0.1"},
    {"limit_history", "off"},
    {"variance_of", "frame"},
    {"short_history", "blur"},
    {"short_history_boost", "0"},
    {"kernel", "3x3"},
    {"steps", "16,8,4,2,1"},
    {"feedback", "5"},
    {"sigma_n", "64"},
    {"depth_weight", "gradient"},
    {"max_slope", "0.1"},
    {"sigma_l", "4"},
    {"luminance_epsilon", "0.05"},
    {"luminance", "rec601"},
    {"luminance_scale", "variance"},
    {"mirror_roughness", "0"},
    {"noise_ratio", "1"},
    {"dither", "1"},
};

}  // namespace

std::span<const Parameter> Parameters() {
  static const std::vector<Parameter> parameters = [] {
    std::vector<Parameter> list;
    for (const Row& row : Table()) {
      list.push_back(row.info);
    }
    return list;
  }();
  return parameters;
}

std::span<const std::string_view> PresetNames() {
  return kPresets;
}

Result<Settings> PresetSettings(std::string_view name) {
  if (std::find(std::begin(kPresets), std::end(kPresets), name) == std::end(kPresets)) {
    return Status::InvalidArgument(
        fmt::format("unknown preset '{}'; presets are: {}", name, fmt::join(kPresets, ", ")));
  }
  Settings settings;
  if (name == "psvgf") {
    for (const auto& [parameter, value] : kPsvgf) {
      STILLRAY_RETURN_IF_ERROR(SetParameter(&settings, parameter, value));
    }
    return settings;
  }
  for (const Row& row : Table()) {
    const char* value = name == "svgf"       ? row.svgf
                        : name == "eaw"      ? row.eaw
                        : name == "temporal" ? row.temporal
                                             : nullptr;
    if (value != nullptr) {
      STILLRAY_RETURN_IF_ERROR(SetParameter(&settings, row.info.name, value));
    }
  }
  return settings;
}

Status SetParameter(Settings* settings, std::string_view name, std::string_view value) {
  const Row* row = FindRow(name);
  if (row == nullptr) {
    return UnknownParameter(name);
  }
  const bool valid = SetMember(row->info, row->member, value, settings);
  return valid ? Status::Ok() : BadValue(*row, value);
}

Status AssignParameter(Settings* settings, std::string_view assignment) {
  std::string_view name;
  std::string_view value;
  STILLRAY_RETURN_IF_ERROR(SplitAssignment(assignment, &name, &value));
  return SetParameter(settings, name, value);
}

Result<std::string> GetParameter(const Settings& settings, std::string_view name) {
  const Row* row = FindRow(name);
  if (row == nullptr) {
    return UnknownParameter(name);
  }
  return GetMember(row->info, row->member, settings);
}

Status ValidateSettings(const Settings& settings) {
  for (const Row& row : Table()) {
    Settings scratch = settings;
    const std::string value = GetMember(row.info, row.member, settings);
    if (!SetMember(row.info, row.member, value, &scratch)) {
      return BadValue(row, value);
    }
  }
  if (settings.feedback > settings.steps.count) {
    return Status::InvalidArgument(
        fmt::format("parameter 'feedback' is {}, but 'steps' has only {} levels", settings.feedback,
                    settings.steps.count));
  }
  return Status::Ok();
}

}  // namespace stillray
