// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/settings.h"

namespace stillray {
namespace {

/// If edges are mixtures that differ in every frame, strict tests of the history fail there and
/// leave noise. limit_history still rejects history with different light; without it strict tests
/// are better.
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

/// Files without motion have no usable history; temporal antialiasing needs jittered frames, and
/// would blur those of other renderers.
Settings SettingsFor(const SequenceOptions& options, const AovLayout& layout, const ExrImage& first,
                     bool has_motion) {
  Settings settings = options.settings;
  RelaxHistoryTests(options, layout, &settings);
  if (!has_motion) {
    settings.temporal = false;
  }
  const auto jitter = first.attributes.find("jitter");
  const bool jittered =
      jitter != first.attributes.end() && jitter->second != "0 0" && !options.passes;
  if (!has_motion || (!jittered && !options.IsFixed("antialias"))) {
    settings.antialias = Antialias::kOff;
  }
  return settings;
}

}  // namespace stillray
