// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/settings.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "io/aov_samples.h"
#include "io/text.h"

namespace stillray {
namespace {

/// From the options or the first file; 0: unknown.
int KnownSamples(const SequenceOptions& options, const ExrImage& first) {
  return options.spp > 0 ? options.spp : io::StatedSamples(first);
}

/// The weight of a new frame if rays pass through the pixel centres: past frames are resampled
/// along the motion, and each resampling blurs (docs/renderers.md).
constexpr float kCentredAlpha = 0.3f;

bool IsJitteredSequence(const ExrImage& first) {
  const auto jitter = first.attributes.find("jitter");
  return jitter != first.attributes.end() && jitter->second != "0 0";
}

/// If guides are means over the pixel, rays pass through random points of it: the albedo at edges
/// and in textures is noisy, and with it the image, even if the radiance is clean; the mean over
/// frames is not. Otherwise, without jitter, rays pass through the pixel centres: edges are
/// smoothed where the image moves. Published presets are not changed.
void AntialiasInTime(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     Settings* settings) {
  const int samples = KnownSamples(options, first);
  const bool mixed = layout.soft_guides && samples > 0;
  if (!options.IsFixed("antialias")) {
    settings->antialias =
        mixed && settings->limit_history && !options.passes ? Antialias::kTaa : Antialias::kOff;
  }
  if (settings->antialias != Antialias::kTaa || !settings->limit_history ||
      options.IsFixed("taa_alpha")) {
    return;
  }
  if (mixed) {
    settings->taa_alpha = AntialiasingWeight(settings->taa_alpha, samples);
  } else if (!layout.soft_guides) {
    settings->taa_alpha = std::max(settings->taa_alpha, kCentredAlpha);
  }
}

/// If edges are mixtures that differ in every frame, strict history tests fail there and leave
/// noise. limit_history still rejects a history of different radiance; without it strict tests are
/// better.
void RelaxHistoryTests(const SequenceOptions& options, const AovLayout& layout,
                       Settings* settings) {
  if (!layout.soft_guides || !settings->limit_history) {
    return;
  }
  if (!options.IsFixed("history_id")) {
    settings->history_id = false;
  }
  if (!options.IsFixed("history_normal")) {
    settings->history_normal = 80.0f;
  }
  if (!options.IsFixed("history_depth")) {
    settings->history_depth = 0.3f;
  }
}

}  // namespace

float AntialiasingWeight(float alpha, int samples) {
  const float n = static_cast<float>(samples);
  return n * alpha / (1 - alpha + n * alpha);
}

/// Files without motion have no usable history. Temporal antialiasing needs jittered frames or
/// mixed guides, unless requested by the user: images of other renderers may be antialiased
/// already.
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     bool has_motion) {
  Settings settings = options.settings;
  RelaxHistoryTests(options, layout, &settings);
  if (!has_motion) {
    settings.temporal = false;
    settings.antialias = Antialias::kOff;
  } else if (!IsJitteredSequence(first) || options.passes) {
    AntialiasInTime(options, layout, first, &settings);
  }
  return settings;
}

bool HasJaggedEdges(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                    bool has_motion) {
  const bool known = layout.renderer == "blender" || layout.renderer == "stillray";
  return known && has_motion && options.files.size() > 1 && !layout.soft_guides &&
         !layout.from_colour && !IsJitteredSequence(first) && !options.passes &&
         !options.IsFixed("antialias") && options.settings.antialias == Antialias::kAuto;
}

Result<int> SamplesFor(const SequenceOptions& options, const AovLayout& layout,
                       const ExrImage& first, const Settings& settings) {
  const AovSource* counts = layout.Find(Aov::kSamples);
  if (options.spp > 0 && counts != nullptr) {
    return Status::InvalidArgument(
        fmt::format("--spp: the files have the numbers of samples in layer {} (--aov samples=none "
                    "with --spp: not read)",
                    io::OneLine(counts->layer)));
  }
  if (options.spp > 0 || counts != nullptr) {
    return std::max(options.spp, 1);
  }
  const std::vector<std::string>& mappings = options.aovs.mappings;
  const bool refused =
      std::find(mappings.begin(), mappings.end(), "samples=none") != mappings.end();
  return refused || !settings.limit_history ? 1 : io::StatedSamples(first);
}

}  // namespace stillray
