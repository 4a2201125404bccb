// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/fused/fused.h"

namespace stillray {

Fusion ChooseFusion(const FramePlan& plan, bool keeps_outputs) {
  return {.prepare_and_find_taps = plan.runs.reproject,
          .accumulate_in_place = plan.runs.reproject,
          .antialias_parts = plan.has_picture && !plan.runs.fxaa && !keeps_outputs,
          .mix_pilot = true};
}

bool ChangesInPlace(const Fusion& fusion, const ReprojectionTaps& taps,
                    const StagedHistory& staged) {
  const int64_t gathers = taps.GatherCount();
  return fusion.accumulate_in_place && gathers >= 0 &&
         staged.HasRoom(static_cast<size_t>(gathers), taps.lanes);
}

}  // namespace stillray
