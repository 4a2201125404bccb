// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/energy.h"

#include <array>

#include "denoise/cpu/coarse_grid.h"
#include "denoise/cpu/wavelet.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// The signals of the stage.
struct EnergySignals {
  std::array<EnergySignal, kMostGroups> signal;
  size_t count = 0;

  std::span<const EnergySignal> all() const { return {signal.data(), count}; }
};

EnergySignals SignalsOf(const CpuPipeline& p, LayerWork* work) {
  EnergySignals signals;
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((p.plan.energy_signals >> i & 1) != 0) {
      const WaveletPlanes& planes = work->wavelet[i];
      signals.signal[signals.count++] = {&(*planes.light)[0], &planes.history->length,
                                         &work->compared[i]};
    }
  }
  return signals;
}

}  // namespace

void RunBeginEnergy(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                    DenoisedFrame* out) {
  if (p.plan.energy_signals == 0) {
    return;
  }
  const StageTimer timer(&out->timings, "restore_energy");
  MakeCoarsePlanes(guides, work->wavelet.size(), work);
  p.stages.begin_energy(SignalsOf(p, work).all(), guides, &work->coarse);
}

void RunRestoreEnergy(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                      DenoisedFrame* out) {
  const int mask = p.plan.energy_signals;
  if (mask == 0) {
    return;
  }
  const StageTimer timer(&out->timings, "restore_energy");
  p.stages.measure_energy(SignalsOf(p, work).all(), guides, &work->coarse);
  static_assert(kCorrectHistoryLevels % 2 == 1, "the result lies in `work`");
  RunComparedLevels(p, kCorrectHistoryLevels, mask, work);
  std::array<RestoredSignal, kMostGroups> restored;
  size_t count = 0;
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((mask >> i & 1) != 0) {
      ComparedPlanes& compared = work->compared[i];
      FindEnergyRatio(compared.work, &compared);
      restored[count++] = {&compared, ChangeableLight(&work->wavelet[i])};
    }
  }
  p.stages.restore_energy({restored.data(), count}, work->coarse, guides);
}

}  // namespace stillray
