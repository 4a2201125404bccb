// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/exact_accumulation.h"

#include "denoise/plan.h"

namespace stillray::view {
namespace {

void CopyAccumulation(const Settings& from, Settings* to) {
  to->temporal = from.temporal;
  to->history_weight = from.history_weight;
  to->alpha_min = from.alpha_min;
  to->alpha_moments = from.alpha_moments;
  to->max_history = from.max_history;
  to->limit_history = from.limit_history;
  to->feedback = from.feedback;
  to->variance_of = from.variance_of;
}

/// Sets the parameters of equal weights that do not change the history's planes.
void SetEqualWeights(Settings* settings) {
  settings->history_weight = HistoryWeight::kAge;
  settings->alpha_min = 0;
  settings->alpha_moments = 0;
  settings->max_history = 0;
  settings->feedback = 0;
  settings->variance_of = VarianceOf::kMean;
}

}  // namespace

bool AccumulatesExactly(const Settings& s) {
  return s.temporal && s.history_weight == HistoryWeight::kAge && s.alpha_min == 0 &&
         s.alpha_moments == 0 && s.max_history == 0 && !s.limit_history && s.feedback == 0 &&
         s.variance_of == VarianceOf::kMean;
}

void SetExactAccumulation(bool on, const Settings& preset, Settings* settings) {
  if (!on) {
    CopyAccumulation(preset, settings);
    return;
  }
  settings->temporal = true;
  settings->limit_history = false;
  SetEqualWeights(settings);
}

Settings WithEqualWeights(const Settings& settings) {
  Settings equal = settings;
  equal.limit_gain = 0;
  equal.correct_history = false;
  SetEqualWeights(&equal);
  const bool restarts =
      NeedsNewHistory(settings, equal) && settings.signals != SignalGrouping::kSingle;
  return restarts ? settings : equal;
}

}  // namespace stillray::view
