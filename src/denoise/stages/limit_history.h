// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// correct_history and limit_history: adapt the history where the lighting itself has changed.
/// Source: none; PSVGF (section 7) proposes a stage for this purpose, without a formula.
///
/// Most change is smooth: a lamp comes nearer, a wall gets brighter, and the detail of the history
/// stays correct up to a factor. correct_history multiplies the history by the ratio of present to
/// history, both averaged over some fifty pixels of the same surface, as far as their difference is
/// significant. A dimming lamp changes its wide surroundings by a common factor, which is less than
/// the noise of fifty pixels in each frame: the change is therefore averaged over 160 pixels first,
/// and its significance is judged by the scatter of the averaged changes. limit_history treats the
/// remaining changes, above all at shadow fronts: it compares the compressed luminances of present
/// and corrected history over some twenty pixels; the excess of their squared difference over its
/// expected noise estimates the squared bias, from which a Kalman gain determines the effective
/// number of samples of the history. For signals with direct light the comparison is repeated over
/// some six pixels, since trails of highlights are narrower. The history holds the mean of
/// compressed samples, not the compressed mean: a mean of few bright samples compresses to a higher
/// value than the mean of the compressed samples, so that sparse samples would always appear as a
/// change.
///
/// All averages are computed on a grid of half the resolution, by geometry-only wavelet levels with
/// kernels of equal weights. Border of the full-resolution planes: as for the wavelet.
#pragma once

#include <span>

#include "denoise/planes.h"
#include "denoise/stages/atrous.h"
#include "denoise/stages/limit_history_shared.h"

namespace stillray {

/// Levels on the coarse grid of correct_history and of limit_history: equal weights over 27x27 and
/// 9x9 blocks. With wider kernels in limit_history, changes of the light are detected later, which
/// outweighs the lower noise.
inline constexpr int kCorrectHistoryLevels = 3;
inline constexpr int kLimitHistoryLevels = 2;
inline constexpr int kComparedSteps[kCorrectHistoryLevels] = {1, 3, 9};
inline AtrousLevel ComparedLevel(int level) {
  return {kAtrousGeometry, 1, kComparedSteps[level], /*box=*/true};
}
/// The level that averages the changes over the wide surroundings.
inline constexpr AtrousLevel kWideLevel = {kAtrousGeometry, 2, kWideStep, /*box=*/true};
inline constexpr int kComparedBorder = kWideLevel.radius * kWideStep;

/// Pixels of the coarse grid along a side.
constexpr int CoarseSize(int size) {
  return (size + 1) / 2;
}

/// Present and history of one signal on the coarse grid; borders of kComparedBorder.
struct ComparedPlanes {
  /// Luminance: present, red: history; variance: expected noise of their difference.
  FilterPlanes light;
  /// Luminance: compressed present, red: compressed history, blue: variance of single compressed
  /// samples; variance: expected noise of the difference.
  FilterPlanes compressed;
  FilterPlanes work;
  FilterPlanes wide;  ///< LogChange (luminance) and its square (red); variance: that of the weights
  Image1 valid;       ///< 1 where a pixel of the block has both, else 0
  Image1 ratio;       ///< HistoryRatio; 1 if present or history is missing
  Image1 bias;        ///< RelativeBias; 0 if present or history is missing
  float moving = 0;   ///< MovingLight; 0: static lighting

  ComparedPlanes() = default;
  ComparedPlanes(int width, int height)
      : light(width, height, kComparedBorder),
        compressed(width, height, kComparedBorder),
        work(width, height, kComparedBorder),
        wide(width, height, kComparedBorder),
        valid(width, height, kComparedBorder),
        ratio(width, height, kComparedBorder),
        bias(width, height, kComparedBorder) {}
  size_t bytes() const {
    return light.bytes() + compressed.bytes() + work.bytes() + wide.bytes() + valid.bytes() +
           ratio.bytes() + bias.bytes();
  }
};

/// The planes of one signal. `before` is the history of the last frame, to be fetched along the
/// taps.
struct ComparedSignal {
  const NewLight* light;
  const SignalHistory* before;
  ComparedPlanes* out;
};

/// Converts the compressed luminances of a history to another scale.
void RescaleHistory(float scale, SignalHistory* history);

/// Before the levels of correct_history: fills `light`, `compressed` and `valid` with the means
/// over the pixels of each 2x2 block that lie on the surface of its nearest pixel.
/// \param roughness  kRoughnessOfImage where the guides are those of a virtual image; empty:
///     nowhere
/// \param coarse     inverse depth, normal and gradient of that surface, per block; border of
///     kComparedBorder
namespace reference {
void CompareWithHistory(std::span<const ComparedSignal> signals, const ReprojectionTaps& taps,
                        const GuidePlanes& guides, const Image1& roughness, GuidePlanes* coarse);
}
namespace cpu {
void CompareWithHistory(std::span<const ComparedSignal> signals, const ReprojectionTaps& taps,
                        const GuidePlanes& guides, const Image1& roughness, GuidePlanes* coarse);
}

/// After the levels of correct_history: computes the input of kWideLevel, in `light`, from the
/// `averaged` planes.
namespace reference {
void MeasureChange(const FilterPlanes& averaged, ComparedPlanes* planes);
}
namespace cpu {
void MeasureChange(const FilterPlanes& averaged, ComparedPlanes* planes);
}

/// After the levels of correct_history: computes MovingLight from the `averaged` planes.
/// \param is_diffuse  the signal has diffuse light
/// \return MovingLight
float FindMovingLight(const FilterPlanes& averaged, bool is_diffuse, const ComparedPlanes& planes);

/// Between the levels: computes the ratio from the `averaged` planes and the `wide` change (1 if
/// the parameters turn it off), and, in `light`, the input of limit_history's levels: compressed
/// present minus corrected history (luminance), variance of single samples (red) and noise of the
/// difference.
namespace reference {
void CorrectHistory(const FilterPlanes& averaged, const LimitHistoryParameters& parameters,
                    ComparedPlanes* planes);
}
namespace cpu {
void CorrectHistory(const FilterPlanes& averaged, const LimitHistoryParameters& parameters,
                    ComparedPlanes* planes);
}

/// After the levels of limit_history: the bias, the larger estimate of the two levels.
/// \param blurred  output of the last level
/// \param fine     output of the first level; nullptr: only `blurred` counts
void MeasureBias(const FilterPlanes& blurred, const FilterPlanes* fine,
                 const LimitHistoryParameters& parameters, ComparedPlanes* planes);

/// One signal, on the coarse grid and at full resolution.
struct LimitedSignal {
  const ComparedPlanes* compared;
  const Image1* samples;  ///< of this frame
  Image1* ratio;          ///< result: HistoryRatio of pixels with samples, else 1
  Image1* bias;           ///< result: BiasOfFrame of pixels with samples, else 0
};

/// Interpolates ratio and bias from the blocks with a similar surface to the pixels. From the bias,
/// accumulate computes the limit of the history length.
namespace reference {
void LimitHistory(std::span<const LimitedSignal> signals, const GuidePlanes& coarse,
                  const GuidePlanes& guides);
}
namespace cpu {
void LimitHistory(std::span<const LimitedSignal> signals, const GuidePlanes& coarse,
                  const GuidePlanes& guides);
}

}  // namespace stillray
