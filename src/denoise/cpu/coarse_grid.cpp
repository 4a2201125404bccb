// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/coarse_grid.h"

#include <array>

namespace stillray {

void MakeCoarsePlanes(const GuidePlanes& guides, size_t signals, LayerWork* work) {
  const int width = CoarseSize(guides.id.width());
  const int height = CoarseSize(guides.id.height());
  if (work->coarse.id.width() != width || work->coarse.id.height() != height ||
      work->compared.size() != signals) {
    work->coarse = GuidePlanes(width, height, kComparedBorder);
    work->compared.assign(signals, ComparedPlanes(width, height));
  }
}

void RunComparedLevels(const CpuPipeline& p, int levels, int mask, LayerWork* work) {
  std::array<AtrousSignal, kMostGroups> signals;
  for (int level = 0; level < levels; ++level) {
    size_t count = 0;
    for (size_t i = 0; i < work->compared.size(); ++i) {
      if ((mask >> i & 1) == 0) {
        continue;
      }
      ComparedPlanes& c = work->compared[i];
      const FilterPlanes& from = level % 2 == 0 ? c.light : c.work;
      FilterPlanes* to = level % 2 == 0 ? &c.work : &c.light;
      AtrousSignal& signal = signals[count++];
      signal = {&from.colour, &from.variance, to, nullptr, &c.valid};
      signal.zero_where_absent = !p.plan.is_sparse;
    }
    p.stages.atrous({signals.data(), count}, work->coarse, ComparedLevel(level), p.plan.compared);
  }
}

void RunWideLevel(const CpuPipeline& p, LayerWork* work) {
  std::array<AtrousSignal, kMostGroups> signals;
  const auto count = static_cast<size_t>(p.plan.limit_history.wide_signals);
  for (size_t i = 0; i < work->compared.size(); ++i) {
    ComparedPlanes& c = work->compared[i];
    if (i < count) {
      p.stages.measure_change(c.work, &c);
      signals[i] = {&c.light.colour, &c.light.variance, &c.wide, nullptr, &c.valid};
      signals[i].zero_where_absent = !p.plan.is_sparse;
    } else {
      c.wide.variance.Fill(1);  // the weight of a single neighbourhood: no change
    }
  }
  p.stages.atrous({signals.data(), count}, work->coarse, kWideLevel, p.plan.compared);
}

}  // namespace stillray
