// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_energy: gives filtered indirect diffuse radiance the mean of its input, over some fifty
/// pixels of the same surface. Its samples are few and bright: the wavelet's luminance weights
/// reject them, and clip_outliers removes the remaining ones, which darkens this radiance by 5 to
/// 20 % on the built-in scenes. The mean of the samples is unbiased. The filtered radiance is
/// therefore multiplied by the ratio of the means before and after the filter, as far as their
/// difference is significant, as in correct_history. Each block's share of the noise is the squared
/// difference of its own means, so that a single bright sample has no effect. Reflections by rough
/// surfaces are excluded: their detail is finer than the means. What a mirror shows is included,
/// under the guides and the albedo of the virtual image. Source: none; twicing (Tukey, Exploratory
/// Data Analysis, 1977) at one coarse scale.
///
/// Means are computed on the coarse grid of limit_history and by its levels. No state. Border of
/// the full-resolution planes: 1 pixel of guides. Reads 28 and writes 12 bytes per pixel and
/// signal, beside the guides.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/limit_history.h"

namespace stillray {

struct EnergySignal {
  const Image1* accumulated;  ///< luminance before the wavelet
  const Image1* filtered;     ///< luminance after it
  const Image1* length;       ///< history length; pixels of length 0 are skipped
  ComparedPlanes* out;
};

/// One signal, on the coarse grid and at full resolution.
struct RestoredSignal {
  const ComparedPlanes* compared;
  LumaImage3* light;  ///< [in,out] multiplied by the ratio
  /// Only pixels with guides of a virtual image (kRoughnessOfImage) change; nullptr: all.
  const Image1* roughness = nullptr;
};

/// Before the levels: fills `light` and `valid` with the means of the accumulated luminance
/// (luminance) and of the filtered luminance (red) over the pixels of each 2x2 block that lie on
/// the surface of its nearest pixel, and with EnergyNoise (variance).
/// \param coarse  inverse depth, normal and gradient of that surface, per block; border of
///     kComparedBorder
namespace reference {
void MeasureEnergy(std::span<const EnergySignal> signals, const GuidePlanes& guides,
                   GuidePlanes* coarse);
}
namespace cpu {
void MeasureEnergy(std::span<const EnergySignal> signals, const GuidePlanes& guides,
                   GuidePlanes* coarse);
}

/// Between MeasureEnergy's levels and RestoreEnergy: the ratio from the `averaged` planes.
void FindEnergyRatio(const FilterPlanes& averaged, ComparedPlanes* planes);

/// Multiplies each pixel by the ratio, interpolated from the blocks around it with a similar
/// surface.
namespace reference {
void RestoreEnergy(std::span<const RestoredSignal> signals, const GuidePlanes& coarse,
                   const GuidePlanes& guides);
}
namespace cpu {
void RestoreEnergy(std::span<const RestoredSignal> signals, const GuidePlanes& coarse,
                   const GuidePlanes& guides);
}

}  // namespace stillray
