// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/stages/restore_energy.h"

#include "denoise/stages/coarse_grid.h"
#include "denoise/stages/restore_energy_shared.h"
#include "denoise/stages/select_guides_shared.h"

namespace stillray::reference {
namespace {

void MeasureBlock(const EnergySignal& signal, const Block& block, int bx, int by) {
  float accumulated = 0;
  float filtered = 0;
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    const int x = 2 * bx + (k & 1);
    const int y = 2 * by + (k >> 1);
    const float w = block.weight[k];
    if (w > 0 && x < signal.length->width() && y < signal.length->height() &&
        (*signal.length)(x, y) > 0) {
      accumulated += w * (*signal.accumulated)(x, y);
      filtered += w * (*signal.filtered)(x, y);
      sum += w;
    }
  }
  const bool valid = sum > kLeastComparedWeight;
  const float scale = valid ? 1.0f / sum : 0.0f;
  FilterPlanes& light = signal.out->light;
  signal.out->valid(bx, by) = valid ? 1.0f : 0.0f;
  light.colour[0](bx, by) = accumulated * scale;
  light.colour[1](bx, by) = filtered * scale;
  light.variance(bx, by) = EnergyNoise(light.colour[0](bx, by), light.colour[1](bx, by));
}

}  // namespace

void MeasureEnergy(std::span<const EnergySignal> signals, const GuidePlanes& guides,
                   GuidePlanes* coarse) {
  for (int by = 0; by < coarse->id.height(); ++by) {
    for (int bx = 0; bx < coarse->id.width(); ++bx) {
      const Block block = BlockAt(guides, bx, by);
      StoreCoarse(guides, block, bx, by, coarse);
      for (const EnergySignal& signal : signals) {
        MeasureBlock(signal, block, bx, by);
      }
    }
  }
}

void RestoreEnergy(std::span<const RestoredSignal> signals, const GuidePlanes& coarse,
                   const GuidePlanes& guides) {
  for (const RestoredSignal& signal : signals) {
    const ComparedPlanes& compared = *signal.compared;
    LumaImage3& light = *signal.light;
    for (int y = 0; y < light[0].height(); ++y) {
      for (int x = 0; x < light[0].width(); ++x) {
        const bool changes =
            signal.roughness == nullptr || (*signal.roughness)(x, y) == kRoughnessOfImage;
        if (!changes || !(guides.inverse_depth(x, y) > 0)) {
          continue;
        }
        const BlocksAround around = FindBlocksAround(coarse, guides, x, y);
        float sum_ratio = 0;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
          if (compared.valid(around.x[k], around.y[k]) > 0) {
            sum_ratio += around.weight[k] * compared.ratio(around.x[k], around.y[k]);
            sum += around.weight[k];
          }
        }
        const float ratio = sum > kLeastComparedWeight ? sum_ratio / sum : 1.0f;
        for (int c = 0; c < 3; ++c) {
          light[c](x, y) *= ratio;
        }
      }
    }
  }
}

}  // namespace stillray::reference
