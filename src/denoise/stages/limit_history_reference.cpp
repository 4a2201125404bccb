// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/shared.h"
#include "denoise/stages/coarse_grid.h"
#include "denoise/stages/limit_history.h"
#include "denoise/stages/limit_history_shared.h"
#include "denoise/stages/reproject.h"

namespace stillray::reference {
namespace {

SignalHistory Fetched(const SignalHistory& before, const ReprojectionTaps& taps) {
  SignalHistory fetched = before;
  FetchHistory(before, taps, &fetched);
  return fetched;
}

struct Means {
  float present = 0, history = 0, noise = 0;
  float compressed_present = 0, compressed_history = 0, single = 0, compressed_noise = 0;
  float weight = 0;
};

void AddPixel(const NewLight& light, const SignalHistory& before, float roughness, int x, int y,
              float w, Means* m) {
  const float n = light.samples(x, y);
  const float length = before.length(x, y);
  if (!(n > 0) || !(length > 0)) {
    return;
  }
  const float scale = before.compressed_scale;
  const float l = light.colour[0](x, y);
  const float mean = before.mean(x, y);
  const float variance = before.variance(x, y);
  const float weights2 = before.weights2(x, y);
  const float then = before.compressed(x, y);
  const float single = CompressedVariance(then, mean, variance, scale);
  m->present += w * l;
  m->history += w * mean;
  m->noise += w * w * ComparisonNoise(l, n, length, mean, variance, weights2);
  const float compressed = CompressLuminance(l, scale);
  m->compressed_present += w * compressed;
  m->compressed_history += w * then;
  const float share = ShareOfChange(roughness, length);
  const float change = compressed - then;
  const float spread = SpreadOfDifference(n, weights2);
  m->single += w * SingleVariance(change, single, length, spread);
  m->compressed_noise += w * w * CompressedNoise(change, single, spread, share);
  m->weight += w;
}

void StoreMeans(const Means& m, int bx, int by, ComparedPlanes* out) {
  const bool valid = m.weight > kLeastComparedWeight;
  const float scale = valid ? 1.0f / m.weight : 0.0f;
  out->valid(bx, by) = valid ? 1.0f : 0.0f;
  out->light.colour[0](bx, by) = m.present * scale;
  out->light.colour[1](bx, by) = m.history * scale;
  out->light.variance(bx, by) = m.noise * scale * scale;
  out->compressed.colour[0](bx, by) = m.compressed_present * scale;
  out->compressed.colour[1](bx, by) = m.compressed_history * scale;
  out->compressed.colour[2](bx, by) = m.single * scale;
  out->compressed.variance(bx, by) = m.compressed_noise * scale * scale;
}

}  // namespace

void CompareWithHistory(std::span<const ComparedSignal> signals, const ReprojectionTaps& taps,
                        const GuidePlanes& guides, const Image1& roughness, GuidePlanes* coarse) {
  const int width = guides.id.width();
  const int height = guides.id.height();
  for (const ComparedSignal& signal : signals) {
    const SignalHistory before = Fetched(*signal.before, taps);
    for (int by = 0; by < CoarseSize(height); ++by) {
      for (int bx = 0; bx < CoarseSize(width); ++bx) {
        const Block block = BlockAt(guides, bx, by);
        StoreCoarse(guides, block, bx, by, coarse);
        Means means;
        for (int k = 0; k < 4; ++k) {
          const int x = 2 * bx + (k & 1);
          const int y = 2 * by + (k >> 1);
          if (block.weight[k] > 0 && x < width && y < height) {
            const float r = roughness.empty() ? 0.0f : roughness(x, y);
            AddPixel(*signal.light, before, r, x, y, block.weight[k], &means);
          }
        }
        StoreMeans(means, bx, by, signal.out);
      }
    }
  }
}

namespace {

struct Jittered {
  float shift;  ///< JitterShift
  float noise;  ///< JitterNoise
};

/// JitterShift and JitterNoise of a block. The slope along an axis is zero if a neighbour has no
/// history or is outside the image.
Jittered JitteredAt(const ComparedPlanes& planes, const LimitHistoryParameters& p, int x, int y) {
  if ((p.jitter_x == 0 && p.jitter_y == 0) || !(planes.valid(x, y) > 0)) {
    return {0, 0};
  }
  const Image1& history = planes.compressed.colour[1];
  const float here = history(x, y);
  const auto at = [&](int nx, int ny) {
    const bool inside = nx >= 0 && ny >= 0 && nx < history.width() && ny < history.height();
    return inside && planes.valid(nx, ny) > 0 ? history(nx, ny) : here;
  };
  const float dx = BlockSlope(at(x - 1, y), here, at(x + 1, y));
  const float dy = BlockSlope(at(x, y - 1), here, at(x, y + 1));
  return {JitterShift(dx, dy, p.jitter_x, p.jitter_y), JitterNoise(dx, dy)};
}

}  // namespace

void MeasureChange(const FilterPlanes& averaged, ComparedPlanes* planes) {
  for (int y = 0; y < planes->valid.height(); ++y) {
    for (int x = 0; x < planes->valid.width(); ++x) {
      const bool valid = planes->valid(x, y) > 0;
      const float change =
          valid ? LogChange(averaged.colour[0](x, y), averaged.colour[1](x, y)) : 0.0f;
      planes->light.colour[0](x, y) = change;
      planes->light.colour[1](x, y) = change * change;
      planes->light.variance(x, y) = valid ? 1.0f : 0.0f;
    }
  }
}

void CorrectHistory(const FilterPlanes& averaged, const LimitHistoryParameters& p,
                    ComparedPlanes* planes) {
  const FilterPlanes& compressed = planes->compressed;
  const bool corrects = p.correct_history != 0;
  for (int y = 0; y < planes->ratio.height(); ++y) {
    for (int x = 0; x < planes->ratio.width(); ++x) {
      float ratio = 1;
      if (corrects && planes->valid(x, y) > 0) {
        const FilterPlanes& changes = planes->wide;
        const float variance = ChangeVariance(averaged.variance(x, y), averaged.colour[1](x, y));
        const float wide = WideRatio(changes.colour[0](x, y), changes.colour[1](x, y), variance,
                                     changes.variance(x, y));
        ratio = CorrectedRatio(averaged.colour[0](x, y), averaged.colour[1](x, y),
                               averaged.variance(x, y), wide, planes->moving);
      }
      const Jittered jittered = JitteredAt(*planes, p, x, y);
      planes->ratio(x, y) = ratio;
      planes->light.colour[0](x, y) = compressed.colour[0](x, y) -
                                      ScaledCompressed(compressed.colour[1](x, y), ratio) -
                                      jittered.shift;
      planes->light.colour[1](x, y) = compressed.colour[2](x, y);
      planes->light.variance(x, y) = compressed.variance(x, y) + jittered.noise;
    }
  }
}

namespace {

void LimitPixel(const LimitedSignal& signal, const GuidePlanes& coarse, const GuidePlanes& guides,
                int x, int y) {
  const ComparedPlanes& compared = *signal.compared;
  const BlocksAround around = FindBlocksAround(coarse, guides, x, y);
  float sum_ratio = 0;
  float sum_bias = 0;
  float sum = 0;
  for (int k = 0; k < 4; ++k) {
    const int bx = around.x[k];
    const int by = around.y[k];
    if (compared.valid(bx, by) > 0) {  // 0 in the border
      sum_ratio += around.weight[k] * compared.ratio(bx, by);
      sum_bias += around.weight[k] * compared.bias(bx, by);
      sum += around.weight[k];
    }
  }
  if (sum > kLeastComparedWeight) {
    (*signal.ratio)(x, y) = sum_ratio / sum;
    (*signal.bias)(x, y) = BiasOfFrame(sum_bias / sum, (*signal.samples)(x, y));
  }
}

}  // namespace

void LimitHistory(std::span<const LimitedSignal> signals, const GuidePlanes& coarse,
                  const GuidePlanes& guides) {
  for (const LimitedSignal& signal : signals) {
    for (int y = 0; y < signal.ratio->height(); ++y) {
      for (int x = 0; x < signal.ratio->width(); ++x) {
        (*signal.ratio)(x, y) = 1;
        (*signal.bias)(x, y) = 0;
        if (guides.inverse_depth(x, y) > 0 && (*signal.samples)(x, y) > 0) {
          LimitPixel(signal, coarse, guides, x, y);
        }
      }
    }
  }
}

}  // namespace stillray::reference
