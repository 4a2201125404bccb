// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/nearest_names.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using PresetValue = std::pair<const char*, const char*>;

// The values of presets that differ from "default", whose values are the initialisers of Settings.

/// The best quality, at the cost of time.
constexpr PresetValue kBest[] = {{"restore_detail", "on"}};

/// Schied et al. 2017.
constexpr PresetValue kSvgf[] = {
    {"history_weight", "constant"},
    {"alpha_min", "0.2"},
    {"alpha_moments", "0.2"},
    {"limit_history", "off"},
    {"variance_of", "frame"},
    {"short_history", "spatial"},
    {"short_history_window", "7x7"},
    {"short_history_boost", "0"},
    {"prefilter_limit", "0"},
    {"feedback", "1"},
    {"feedback_when", "frame"},
    {"sigma_n", "128"},
    {"curvature", "0"},
    {"depth_weight", "gradient"},
    {"clip_outliers", "0"},
    {"restore_energy", "off"},
    {"pilot", "off"},
    {"sigma_l", "4"},
    {"noise_ratio", "1"},
    {"virtual_roughness", "0"},
    {"virtual_motion_roughness", "0"},
    {"mirror_roughness", "0"},
    {"keep_samples", "off"},
    {"taa_alpha", "0.1"},
    {"taa_moving_alpha", "0"},
    {"taa_filter", "catmull_rom"},
    {"taa_extrapolate_motion", "off"},
    {"taa_clamp", "picture"},
    {"taa_follow_light", "off"},
    {"fxaa", "off"},
};

/// Progressive SVGF (Dundr 2018).
constexpr PresetValue kPsvgf[] = {
    {"signals", "single"},
    {"alpha_min", "0.1"},
    {"limit_history", "off"},
    {"variance_of", "frame"},
    {"short_history", "blur"},
    {"short_history_window", "7x7"},
    {"short_history_boost", "0"},
    {"prefilter_limit", "0"},
    {"kernel", "3x3"},
    {"steps", "16,8,4,2,1"},
    {"feedback", "5"},
    {"sigma_n", "64"},
    {"curvature", "0"},
    {"depth_weight", "gradient"},
    {"clip_outliers", "0"},
    {"restore_energy", "off"},
    {"pilot", "off"},
    {"max_slope", "0.1"},
    {"sigma_l", "4"},
    {"luminance_epsilon", "0.05"},
    {"luminance", "rec601"},
    {"luminance_scale", "variance"},
    {"virtual_roughness", "0"},
    {"virtual_motion_roughness", "0"},
    {"mirror_roughness", "0"},
    {"keep_samples", "off"},
    {"taa_alpha", "0.1"},
    {"taa_moving_alpha", "0"},
    {"taa_filter", "catmull_rom"},
    {"taa_extrapolate_motion", "off"},
    {"taa_clamp", "picture"},
    {"taa_follow_light", "off"},
    {"noise_ratio", "1"},
    {"dither", "1"},
};

/// Dammertz et al. 2010.
constexpr PresetValue kEaw[] = {
    {"temporal", "off"},
    {"limit_history", "off"},
    {"variance_of", "frame"},
    {"prefilter_limit", "0"},
    {"wavelet", "eaw"},
    {"restore_energy", "off"},
    {"virtual_roughness", "0"},
    {"virtual_motion_roughness", "0"},
    {"mirror_roughness", "0"},
    {"antialias", "off"},
    {"taa_alpha", "0.1"},
    {"taa_moving_alpha", "0"},
    {"taa_filter", "catmull_rom"},
    {"taa_extrapolate_motion", "off"},
    {"taa_clamp", "picture"},
    {"taa_follow_light", "off"},
    {"fxaa", "off"},
    {"keep_samples", "off"},
};

/// Temporal accumulation only.
constexpr PresetValue kTemporal[] = {
    {"limit_history", "off"},
    {"prefilter_limit", "0"},
    {"wavelet", "off"},
    {"virtual_roughness", "0"},
    {"virtual_motion_roughness", "0"},
    {"mirror_roughness", "0"},
    {"antialias", "off"},
    {"taa_alpha", "0.1"},
    {"taa_moving_alpha", "0"},
    {"taa_filter", "catmull_rom"},
    {"taa_extrapolate_motion", "off"},
    {"taa_clamp", "picture"},
    {"taa_follow_light", "off"},
    {"fxaa", "off"},
    {"keep_samples", "off"},
};

struct Preset {
  std::string_view name;
  std::span<const PresetValue> values;
};

constexpr Preset kPresets[] = {{"default", {}},   {"best", kBest}, {"svgf", kSvgf},
                               {"psvgf", kPsvgf}, {"eaw", kEaw},   {"temporal", kTemporal}};

constexpr auto kPresetNames = [] {
  std::array<std::string_view, std::size(kPresets)> names;
  for (size_t i = 0; i < names.size(); ++i) {
    names[i] = kPresets[i].name;
  }
  return names;
}();

}  // namespace

std::span<const std::string_view> PresetNames() {
  return kPresetNames;
}

Result<Settings> PresetSettings(std::string_view name) {
  const auto* preset = std::find_if(std::begin(kPresets), std::end(kPresets),
                                    [&](const Preset& p) { return p.name == name; });
  if (preset == std::end(kPresets)) {
    const std::string meant = DidYouMeanOneOf(name, kPresetNames);
    return Status::InvalidArgument(fmt::format(
        "unknown preset '{}'{}", name,
        meant.empty() ? fmt::format("; presets are: {}", fmt::join(kPresetNames, ", ")) : meant));
  }
  Settings settings;
  for (const auto& [parameter, value] : preset->values) {
    STILLRAY_RETURN_IF_ERROR(SetParameter(&settings, parameter, value));
  }
  return settings;
}

}  // namespace stillray
