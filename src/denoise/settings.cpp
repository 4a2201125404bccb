// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include <fmt/format.h>

#include "core/nearest_names.h"
#include "core/parameter_table.h"
#include "denoise/plan.h"
#include "stillray/denoise.hpp"

namespace stillray {
namespace {

using Member = ParameterMember<Settings>;

/// The part of a parameter that the history depends on: the history restarts when the key changes.
struct HistoryKey {
  int (*key)(const Settings&) = nullptr;  ///< nullptr: never
  const char* when = "";                  ///< Parameter::resets_history
};

constexpr HistoryKey kCompress = {
    [](const Settings& s) { return s.firefly == Firefly::kCompress ? 1 : 0; },
    "on a change to or from compress"};
constexpr HistoryKey kBlend = {[](const Settings& s) { return LayoutOf(s).with_behind ? 1 : 0; },
                               "on a change that begins or ends blended feedback"};

/// The key is the value itself.
template <auto kMember>
constexpr HistoryKey Always() {
  return {[](const Settings& s) { return static_cast<int>(s.*kMember); }, "on every change"};
}

/// A row of the table with the columns that only this file uses.
struct Row {
  Parameter info;
  Member member;
  HistoryKey history = {};
};

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
  using enum ParameterType;
  return {
      {.info = {.name = "fill_guides",
                .type = kFlag,
                .group = "fill_guides",
                .help = "Fill unknown guides (depth 0 and no sample) from earlier frames, or from "
                        "the nearest known pixels."},
       .member = &Settings::fill_guides},
      {.info = {.name = "normals",
                .type = kChoice,
                .group = "prepare_guides",
                .help = "Storage of normals in the filter: three floats, or octahedral in 2 x 16 "
                        "bits, off by 0.0037 degrees at most, for a third of the memory. auto: "
                        "octahedral on devices with half precision, else plain.",
                .max = 2,
                .choices = {"auto", "plain", "octahedral"}},
       .member = Choice<Settings, &Settings::normals>(),
       .history = Always<&Settings::normals>()},
      {.info = {.name = "signals",
                .type = kChoice,
                .group = "demodulate",
                .help = "Grouping of light into signals, each with its own filter and history: "
                        "direct diffuse, indirect diffuse and specular; direct and indirect; "
                        "diffuse and specular; all in one; all in one per channel of colour, each "
                        "with its own variance.",
                .max = 4,
                .choices = {"split", "direct_indirect", "diffuse_specular", "single", "channels"}},
       .member = Choice<Settings, &Settings::signals>(),
       .history = Always<&Settings::signals>()},
      {.info = {.name = "demodulate",
                .type = kFlag,
                .group = "demodulate",
                .help =
                    "Divide light by the albedo before filtering, so that textures stay sharp."},
       .member = &Settings::demodulate,
       .history = Always<&Settings::demodulate>()},
      {.info = {.name = "firefly",
                .type = kChoice,
                .group = "suppress_fireflies",
                .help =
                    "Limit single bright samples, at the cost of light: clamp, to the brightest "
                    "neighbour, takes 6 to 19 % of that of the built-in scenes at one sample "
                    "per pixel; compress, by filtering under a curve that bends above a "
                    "luminance of 32, below 0.5 %, but more where much light is brighter.",
                .max = 2,
                .choices = {"off", "clamp", "compress"}},
       .member = Choice<Settings, &Settings::firefly>(),
       .history = kCompress},
      {.info = {.name = "temporal",
                .type = kFlag,
                .group = "accumulate",
                .help = "Accumulate light from earlier frames."},
       .member = &Settings::temporal,
       .history = kBlend},
      {.info =
           {.name = "history_weight",
            .type = kChoice,
            .group = "accumulate",
            .help =
                "Weight of a new frame: constant alpha_min, or 1/age until alpha_min is reached.",
            .choices = {"constant", "age"}},
       .member = Choice<Settings, &Settings::history_weight>()},
      {.info = {.name = "alpha_min",
                .type = kFloat,
                .group = "accumulate",
                .help = "Smallest weight of a new frame's light; 0 with history_weight=age gives a "
                        "plain mean.",
                .symbol = "alpha"},
       .member = &Settings::alpha_min},
      {.info = {.name = "alpha_moments",
                .type = kFloat,
                .group = "accumulate",
                .help = "Smallest weight of a new frame's luminance moments.",
                .symbol = "alpha"},
       .member = &Settings::alpha_moments},
      {.info = {.name = "max_history",
                .type = kInt,
                .group = "accumulate",
                .help = "Upper limit of the history length; 0: no limit.",
                .unit = "samples",
                .max = 1 << 20},
       .member = &Settings::max_history},
      {.info = {.name = "history_depth",
                .type = kFloat,
                .group = "reproject",
                .help = "Largest difference of depth between a pixel and its history.",
                .unit = "of depth",
                .min = 1e-4,
                .max = 10.0},
       .member = &Settings::history_depth},
      {.info = {.name = "history_normal",
                .type = kFloat,
                .group = "reproject",
                .help = "Largest angle between the normals of a pixel and its history.",
                .unit = "degrees",
                .max = 180.0},
       .member = &Settings::history_normal},
      {.info = {.name = "history_id",
                .type = kFlag,
                .group = "reproject",
                .help = "Require the history to have the same surface id, if ids are given."},
       .member = &Settings::history_id},
      {.info = {.name = "history_taps",
                .type = kChoice,
                .group = "reproject",
                .help = "Pixels of the last frame that a history is fetched from: the four around "
                        "the position, or the nearest, which does not blur but moves in steps.",
                .choices = {"bilinear", "nearest"}},
       .member = Choice<Settings, &Settings::history_taps>()},
      {.info = {.name = "history_search",
                .type = kFlag,
                .group = "reproject",
                .help = "Search the 3x3 pixels around the reprojected position when no other "
                        "tap matches the surface."},
       .member = &Settings::history_search},
      {.info = {.name = "limit_history",
                .type = kFlag,
                .group = "limit_history",
                .help = "Shorten histories that differ from the new frame by more than noise, such "
                        "as after a change of the light."},
       .member = &Settings::limit_history,
       .history = Always<&Settings::limit_history>()},
      {.info = {.name = "correct_history",
                .type = kFlag,
                .group = "limit_history",
                .help = "Multiply histories by the ratio of the new light to the old over a "
                        "neighbourhood, as far as it is significant, before limit_history judges "
                        "what change is left. Needs limit_history."},
       .member = &Settings::correct_history},
      {.info = {.name = "limit_gain",
                .type = kFloat,
                .group = "limit_history",
                .help = "Rate at which the history shortens with the difference beyond limit_dead.",
                .max = 1000.0},
       .member = &Settings::limit_gain},
      {.info = {.name = "limit_dead",
                .type = kFloat,
                .group = "limit_history",
                .help = "Dead zone: differences up to this many expected variances are ignored.",
                .max = 1000.0},
       .member = &Settings::limit_dead},
      {.info = {.name = "variance_of",
                .type = kChoice,
                .group = "estimate_variance",
                .help = "Variance that steers the filter: of a single frame (the papers), or of "
                        "the accumulated mean, which narrows the filter as a still view converges.",
                .choices = {"frame", "mean"}},
       .member = Choice<Settings, &Settings::variance_of>()},
      {.info =
           {.name = "short_history",
            .type = kChoice,
            .group = "estimate_variance",
            .help =
                "For short histories: estimate the variance from the neighbourhood, by its "
                "spread (the papers) or by second differences along rows and columns, "
                "which slopes of the light do not enter; or filter without the luminance "
                "weight. Below one sample per pixel second_difference is the spread of 7x7 pixels.",
            .choices = {"spatial", "blur", "second_difference"}},
       .member = Choice<Settings, &Settings::short_history>()},
      {.info = {.name = "short_history_window",
                .type = kChoice,
                .group = "estimate_variance",
                .help = "Neighbourhood of short_history=spatial and second_difference.",
                .choices = {"7x7", "5x5"}},
       .member = Choice<Settings, &Settings::short_history_window>()},
      {.info = {.name = "short_history_length",
                .type = kInt,
                .group = "estimate_variance",
                .help = "Histories below this length are short.",
                .unit = "samples",
                .max = 64},
       .member = &Settings::short_history_length},
      {.info = {.name = "short_history_boost",
                .type = kFloat,
                .group = "estimate_variance",
                .help = "Variance estimates of short histories are multiplied by "
                        "(short_history_length / length) to this power.",
                .max = 4.0},
       .member = &Settings::short_history_boost},
      {.info = {.name = "prefilter_variance",
                .type = kChoice,
                .group = "prefilter_variance",
                .help = "Smooth the variance with a 3x3 kernel before it scales the luminance "
                        "weight: never; once, before the first level; before every level.",
                .max = 2,
                .choices = {"off", "once", "on"}},
       .member = Choice<Settings, &Settings::prefilter_variance>()},
      {.info = {.name = "prefilter_limit",
                .type = kFloat,
                .group = "prefilter_variance",
                .help = "With prefilter_variance=on: largest ratio of the smoothed variance to the "
                        "pixel's own; 0: no limit.",
                .max = 1000.0},
       .member = &Settings::prefilter_limit},
      {.info = {.name = "wavelet",
                .type = kChoice,
                .group = "atrous",
                .help = "Spatial filter: none; without edge-stopping weights (for comparison); "
                        "edge-avoiding Gaussians; variance-guided.",
                .max = 3,
                .choices = {"off", "naive", "eaw", "svgf"}},
       .member = Choice<Settings, &Settings::wavelet>(),
       .history = kBlend},
      {.info = {.name = "kernel",
                .type = kChoice,
                .group = "atrous",
                .help = "Kernel of each level.",
                .choices = {"3x3", "5x5"}},
       .member = Choice<Settings, &Settings::kernel>()},
      {.info = {.name = "steps",
                .type = kSteps,
                .group = "atrous",
                .help = "Distance of the taps of each level, in the order of filtering.",
                .unit = "pixels",
                .min = 1,
                .max = 64},
       .member = TextMember<Settings>{StepsText, SetSteps, ExpectedSteps}},
      {.info = {.name = "feedback",
                .type = kInt,
                .group = "atrous",
                .help = "Level whose output becomes the history of the next frame; 0: none, the "
                        "accumulated light is the history.",
                .unit = "level",
                .max = kMaxLevels},
       .member = &Settings::feedback,
       .history = kBlend},
      {.info = {.name = "feedback_when",
                .type = kChoice,
                .group = "atrous",
                .help = "When filtered light becomes history: after every frame; once per whole "
                        "sample per pixel; or likewise, blended in until the next. All are equal "
                        "at one sample per pixel and above.",
                .max = 2,
                .choices = {"frame", "sample", "blend"}},
       .member = Choice<Settings, &Settings::feedback_when>(),
       .history = kBlend},
      {.info = {.name = "sigma_n",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Exponent of the normal weight: larger keeps finer creases.",
                .symbol = "sigma_n",
                .max = 1024.0},
       .member = &Settings::sigma_n},
      {.info = {.name = "curvature",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Rate at which curved surfaces lower sigma_n, so that their pixels have "
                        "neighbours: to sigma_n / (1 + curvature sigma_n a^2), but not below 8 "
                        "(32 for specular light), where the normal turns by a radians per pixel. "
                        "0: off.",
                .max = 100.0},
       .member = &Settings::curvature},
      {.info = {.name = "depth_weight",
                .type = kChoice,
                .group = "edge_stopping",
                .help = "Compare depth differences with the slope (the papers), measure them from "
                        "the plane through the pixel, or weigh by the Gaussian of the distance of "
                        "the points in space, which needs the focal length of the frames. With "
                        "wavelet=eaw gradient is as plane, with eaw_sigma_z.",
                .max = 2,
                .choices = {"gradient", "plane", "position"}},
       .member = Choice<Settings, &Settings::depth_weight>()},
      {.info = {.name = "sigma_z",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Tolerance of depth_weight=gradient, in slopes.",
                .symbol = "sigma_z",
                .min = 1e-3,
                .max = 1000.0},
       .member = &Settings::sigma_z},
      {.info = {.name = "plane_tolerance",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Distance from the plane at which the weight of depth_weight=plane is 1/e.",
                .unit = "of depth",
                .min = 1e-5,
                .max = 10.0},
       .member = &Settings::plane_tolerance},
      {.info = {.name = "position_sigma",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Width of the Gaussian of depth_weight=position: the distance of two "
                        "points at which their weight is 1/e.",
                .unit = "of depth",
                .symbol = "sigma_x",
                .min = 1e-4,
                .max = 1000.0},
       .member = &Settings::position_sigma},
      {.info = {.name = "depth_epsilon",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Smallest tolerance of depth_weight=gradient.",
                .unit = "of depth",
                .symbol = "epsilon",
                .min = 1e-6},
       .member = &Settings::depth_epsilon},
      {.info = {.name = "max_slope",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Disable depth_weight=gradient at slopes above this; 0: never.",
                .unit = "of depth per pixel",
                .max = 100.0},
       .member = &Settings::max_slope},
      {.info = {.name = "sigma_l",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Tolerance of the luminance weight, in standard deviations: larger blurs "
                        "more. With "
                        "variance_of=mean divided by the cube root of the samples per pixel.",
                .symbol = "sigma_l",
                .min = 1e-3,
                .max = 1000.0},
       .member = &Settings::sigma_l},
      {.info = {.name = "luminance_epsilon",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Smallest tolerance of the luminance weight.",
                .unit = "of luminance",
                .symbol = "epsilon",
                .max = 10.0},
       .member = &Settings::luminance_epsilon},
      {.info = {.name = "luminance_floor",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Added to the tolerance of the luminance weight: smooths dim areas, whose "
                        "light differs by less than this. The result then depends on exposure.",
                .unit = "luminance",
                .symbol = "epsilon",
                .max = 1000.0},
       .member = &Settings::luminance_floor},
      {.info = {.name = "luminance",
                .type = kChoice,
                .group = "edge_stopping",
                .help = "Weights of red, green and blue in luminance.",
                .choices = {"rec709", "rec601"}},
       .member = Choice<Settings, &Settings::luminance>(),
       .history = Always<&Settings::luminance>()},
      {.info = {.name = "luminance_scale",
                .type = kChoice,
                .group = "edge_stopping",
                .help = "Divide luminance differences by the standard deviation, or by the "
                        "variance, as PSVGF prints it; the result then depends on exposure.",
                .choices = {"deviation", "variance"}},
       .member = Choice<Settings, &Settings::luminance_scale>()},
      {.info = {.name = "pilot",
                .type = kFlag,
                .group = "edge_stopping",
                .help = "Compare the mean of 3x3 pixels of the same surface in the luminance "
                        "weight of the first level (for indirect diffuse light of the first two), "
                        "not single pixels, whose own noise makes them refuse bright neighbours: "
                        "without it frames of few samples darken."},
       .member = &Settings::pilot},
      {.info = {.name = "noise_ratio",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Upper limit of the factor by which a noisier neighbour raises the "
                        "tolerance of the luminance weight. At 1, as in the papers, sparsely lit "
                        "surfaces become too dark; large values blur penumbras.",
                .min = 1.0,
                .max = 100.0},
       .member = &Settings::noise_ratio},
      {.info = {.name = "wavelet_id",
                .type = kFlag,
                .group = "edge_stopping",
                .help = "Never filter across different surface ids."},
       .member = &Settings::wavelet_id},
      {.info = {.name = "eaw_sigma_l",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Width of the luminance Gaussian of wavelet=eaw; halves with every level.",
                .unit = "mean luminances",
                .symbol = "sigma_rt",
                .min = 1e-3,
                .max = 1000.0},
       .member = &Settings::eaw_sigma_l},
      {.info = {.name = "eaw_sigma_n",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Width of the Gaussian of normal differences of wavelet=eaw.",
                .symbol = "sigma_n",
                .min = 1e-3,
                .max = 100.0},
       .member = &Settings::eaw_sigma_n},
      {.info = {.name = "eaw_sigma_z",
                .type = kFloat,
                .group = "edge_stopping",
                .help = "Width of the Gaussian of distances from the plane of wavelet=eaw.",
                .unit = "of depth",
                .symbol = "sigma_x",
                .min = 1e-4,
                .max = 100.0},
       .member = &Settings::eaw_sigma_z},
      {.info = {.name = "clip_outliers",
                .type = kFloat,
                .group = "clip_outliers",
                .help =
                    "Filtered light outside the range of the eight neighbours is brought back to "
                    "it, if the excess is at most this many standard deviations; 0: never. Only "
                    "for wavelet=svgf.",
                .max = 1000.0},
       .member = &Settings::clip_outliers},
      {.info = {.name = "restore_energy",
                .type = kFlag,
                .group = "restore_energy",
                .help = "Make filtered indirect diffuse light, and what mirrors show, as bright as "
                        "its samples, over some fifty pixels, where the difference is "
                        "significant. Not for signals with other light too, nor with feedback or "
                        "firefly=compress."},
       .member = &Settings::restore_energy},
      {.info = {.name = "virtual_roughness",
                .type = kFloat,
                .group = "select_guides",
                .help = "Reflections in surfaces up to this roughness follow the guides of the "
                        "virtual image where frames have them, and so does transmitted light; 0: "
                        "neither does."},
       .member = &Settings::virtual_roughness},
      {.info = {.name = "virtual_motion_roughness",
                .type = kFloat,
                .group = "select_guides",
                .help = "On surfaces above virtual_roughness and up to this, the history of "
                        "reflected light moves with the virtual image where frames have one; 0: "
                        "with the surface."},
       .member = &Settings::virtual_motion_roughness},
      {.info = {.name = "mirror_roughness",
                .type = kFloat,
                .group = "keep_mirrors",
                .help =
                    "Reflections and refractions of surfaces up to this roughness keep this "
                    "frame's samples if their noise is less than the filter's change; 0: never."},
       .member = &Settings::mirror_roughness},
      {.info = {.name = "keep_samples",
                .type = kFlag,
                .group = "keep_samples",
                .help = "Keep this frame's samples where they have less noise than the filter has "
                        "error. Only of frames of 2 samples per pixel or more, with second moments "
                        "if they are on a device."},
       .member = &Settings::keep_samples},
      {.info = {.name = "restore_detail",
                .type = kFlag,
                .group = "restore_detail",
                .help = "Add back what the filter has removed from the light of earlier frames "
                        "too, as far as this frame's samples agree. On the CPU only."},
       .member = &Settings::restore_detail},
      {.info =
           {.name = "antialias",
            .type = kChoice,
            .group = "antialias",
            .help =
                "Temporal antialiasing of the finished picture: never, always, or for "
                "jittered frames. Without jitter edges are smooth only where the picture moves.",
            .max = 2,
            .choices = {"off", "taa", "auto"}},
       .member = Choice<Settings, &Settings::antialias>()},
      {.info = {.name = "taa_alpha",
                .type = kFloat,
                .group = "antialias",
                .help = "Weight of the new frame in temporal antialiasing.",
                .symbol = "alpha"},
       .member = &Settings::taa_alpha},
      {.info = {.name = "taa_moving_alpha",
                .type = kFloat,
                .group = "antialias",
                .help = "Weight of the new frame where the picture moves by a quarter of a pixel "
                        "or more, if it is larger: the previous picture, resampled in every "
                        "frame, lags and blurs there."},
       .member = &Settings::taa_moving_alpha},
      {.info = {.name = "taa_filter",
                .type = kChoice,
                .group = "antialias",
                .help = "Filter that resamples the previous picture along the motion, in every "
                        "frame anew. Catmull-Rom's kernel blurs a little each time; the cubic "
                        "spline through the pixels keeps textures sharper; subcell resolution "
                        "places a step inside each pixel that lies between its neighbours, so "
                        "that edges stay sharp too.",
                .max = 2,
                .choices = {"catmull_rom", "spline", "subcell"}},
       .member = Choice<Settings, &Settings::taa_filter>()},
      {.info = {.name = "taa_extrapolate_motion",
                .type = kFlag,
                .group = "antialias",
                .help = "The previous picture beside a silhouette is fetched along the motion of "
                        "the surface in front: extrapolate that to the pixel, where the surface "
                        "moves differently from pixel to pixel, rather than take the neighbour's."},
       .member = &Settings::taa_extrapolate_motion},
      {.info = {.name = "taa_clamp",
                .type = kChoice,
                .group = "antialias",
                .help = "What of the previous picture is clamped to the range around a pixel of "
                        "the current one: the picture, or its light without albedo, which keeps "
                        "texture that the rays of one frame miss, and lags less behind light that "
                        "changes.",
                .max = 1,
                .choices = {"picture", "light"}},
       .member = Choice<Settings, &Settings::taa_clamp>()},
      {.info = {.name = "taa_follow_light",
                .type = kFlag,
                .group = "antialias",
                .help = "Multiply the previous picture by the change of the filtered light, so "
                        "that it does not lag behind light that moves."},
       .member = &Settings::taa_follow_light},
      {.info = {.name = "taa_tonemapped",
                .type = kFlag,
                .group = "antialias",
                .help = "Blend pictures under Reinhard's curve of the exposed light, as if "
                        "antialiasing ran after the tone curve: edges of bright lamps are smooth "
                        "too, but textures of high contrast darken."},
       .member = &Settings::taa_tonemapped},
      {.info = {.name = "fxaa",
                .type = kChoice,
                .group = "fxaa",
                .help = "Smooth jagged edges within the frame: never; below one sample per pixel, "
                        "of pixels with fewer than four samples; always.",
                .max = 2,
                .choices = {"off", "sparse", "on"}},
       .member = Choice<Settings, &Settings::fxaa>()},
      {.info = {.name = "exposure",
                .type = kFloat,
                .group = "tonemap",
                .help = "Light is multiplied by 2^exposure for display; linear files are not.",
                .unit = "EV",
                .min = -32.0,
                .max = 32.0},
       .member = &Settings::exposure},
      {.info = {.name = "tonemap",
                .type = kChoice,
                .group = "tonemap",
                .help = "Tone curve for display; linear files have none.",
                .max = 3,
                .choices = {"linear", "reinhard", "filmic", "aces"}},
       .member = Choice<Settings, &Settings::tonemap>()},
      {.info =
           {.name = "dither",
            .type =
                kFloat,
            .group = "tonemap",
            .help =
                "Noise added for display, against bands in slow gradients; linear files have none.",
            .unit = "8-bit steps",
            .max = 8.0},
       .member = &Settings::dither}};
}

const std::vector<Row>& Table() {
  static const std::vector<Row> table = [] {
    std::vector<Row> rows = MakeTable();
    for (Row& row : rows) {
      row.info.resets_history = row.history.when;
    }
    return rows;
  }();
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

}  // namespace

std::span<const Parameter> Parameters() {
  static const std::vector<Parameter> parameters = InfosOf(Table());
  return parameters;
}

bool NeedsNewHistory(const Settings& a, const Settings& b) {
  return std::any_of(Table().begin(), Table().end(), [&](const Row& row) {
    return row.history.key != nullptr && row.history.key(a) != row.history.key(b);
  });
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
