// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/energy.h"

#include <array>

#include "denoise/cpu/coarse_grid.h"
#include "denoise/cpu/wavelet.h"
#include "denoise/stage_timer.h"

namespace stillray {
void RunRestoreEnergy(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                      LayerWork* work, DenoisedFrame* out) {
  const int mask = p.plan.restore_energy.energy_signals;
  const int of_images = p.plan.restore_energy.image_signals;
  if (mask == 0) {
    return;
  }
  const StageTimer timer(&out->timings, "restore_energy");
  MakeCoarsePlanes(guides, work->wavelet.size(), work);
  std::array<EnergySignal, kMostGroups> signals;
  std::array<RestoredSignal, kMostGroups> restored;
  size_t count = 0;
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((mask >> i & 1) == 0) {
      continue;
    }
    WaveletPlanes& planes = work->wavelet[i];
    LumaImage3* light = ChangeableLight(&planes);
    signals[count] = {&planes.history->colour[0], &(*light)[0], &planes.history->length,
                      &work->compared[i]};
    restored[count++] = {&work->compared[i], light,
                         (of_images >> i & 1) != 0 ? &in.roughness : nullptr};
  }
  p.stages.measure_energy({signals.data(), count}, guides, &work->coarse);
  static_assert(kCorrectHistoryLevels % 2 == 1, "the result lies in `work`");
  RunComparedLevels(p, kCorrectHistoryLevels, mask, work);
  for (size_t i = 0; i < count; ++i) {
    FindEnergyRatio(signals[i].out->work, signals[i].out);
  }
  p.stages.restore_energy({restored.data(), count}, work->coarse, guides);
}

}  // namespace stillray
