// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// restore_energy: filtered indirect diffuse light becomes as bright as the light that was
/// filtered, over some fifty pixels of the same surface. Its samples are few and bright: the
/// wavelet's luminance weights refuse them, and clip_outliers removes what is left of them, so that
/// the picture gets darker, by 5 to 20 % of this light on the built-in scenes. The mean of the
/// samples has no such bias. So the filtered light is multiplied by the ratio of both means, as far
/// as their difference is significant, in the manner of correct_history. Each block's share of the
/// noise is the squared difference of its own means, so that a single bright sample changes
/// nothing. Reflections are left out: their detail is finer than the means. Source: none; twicing
/// (Tukey, Exploratory Data Analysis, 1977) at one coarse scale.
///
/// Means are computed on the coarse grid of limit_history and by its levels. No state. Border of
/// the full planes: 1 pixel of guides. Reads 28 and writes 12 bytes per pixel and signal, beside
/// the guides.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/limit_history.h"

namespace stillray {

struct EnergySignal {
  const Image1* accumulated;  ///< luminance of the light before the wavelet
  const Image1* filtered;     ///< and after it
  const Image1* length;       ///< of the history; only pixels with samples have energy
  ComparedPlanes* out;
};

/// One signal on the coarse grid and the pixels.
struct RestoredSignal {
  const ComparedPlanes* compared;
  LumaImage3* light;  ///< is multiplied by the ratio
};

/// Before the levels: fills `light` and `valid` with the means of the accumulated light (luminance)
/// and of the filtered light (red) over the pixels of each 2x2 block that lie on the surface of its
/// nearest pixel, and with EnergyNoise (variance).
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

/// Between levels and pixels: the ratio from the `averaged` light.
void FindEnergyRatio(const FilterPlanes& averaged, ComparedPlanes* planes);

/// Multiplies the light by the ratio, interpolated from the blocks around each pixel with a similar
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
