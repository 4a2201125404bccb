// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The individual metrics. docs/metrics.md defines them; papers and formulas are cited there and in
/// the sources.
#pragma once

#include <vector>

#include "quality/picture_pair.h"

namespace stillray::quality {

/// Sums over channels of (test - reference)^2 on CompressValue.
struct SquaredErrors {
  std::vector<double> pixels;  ///< row by row; 0 at invalid pixels
  double sum = 0;
};
SquaredErrors FindSquaredErrors(const PicturePair& pair);

/// Peak signal-to-noise ratio in dB on CompressValue, peak 1; +infinity for equal images.
double Psnr(const PicturePair& pair, const SquaredErrors& errors);

/// Mean over valid pixels and channels of (test - reference)^2 / (reference^2 + 0.01).
double RelativeMse(const PicturePair& pair);
/// The mean over channels at each pixel, valid or not.
Image1 RelativeSquaredErrorMap(const PicturePair& pair);

/// 1 - SSIM for each pixel; in 0..2.
Image1 SsimErrorMap(const PicturePair& pair);

/// Mean luminance of test / mean luminance of reference; 1 if both are black, +infinity if only the
/// reference is.
double BrightnessRatio(const PicturePair& pair);

/// Numbers of specks per 10000 valid pixels, 0..10000.
struct SpeckShares {
  double bright = 0;
  double dark = 0;
};
/// Counts pixels whose luminance on CompressValue is farther from the median of their 3x3
/// neighbourhood than in the reference, in the same direction.
SpeckShares FindSpecks(const PicturePair& pair);

/// Fraction of the sum of errors in the 1 % of the valid pixels with the largest errors; 0 for
/// equal images.
double WorstShare(const PicturePair& pair, SquaredErrors errors);

struct BrightnessRange {
  double lowest = 1;
  double highest = 1;
};
/// Range of BrightnessRatio over the cells of a grid; 1 if the reference is black.
BrightnessRange RegionBrightness(const PicturePair& pair);

/// The exposure and tone mapping of a pair's display images.
struct Exposure {
  bool tonemap = false;  ///< false: already display images
  double stops = 0;
};

/// The exposures of HDR-FLIP, from the first to the last, ascending, at least two.
std::vector<Exposure> HdrFlipExposures(const PicturePair& pair);
/// The exposure of LDR-FLIP: none for display images, else the middle of the range of
/// HdrFlipExposures.
Exposure LdrFlipExposure(const PicturePair& pair);

/// For each pixel the largest LDR-FLIP error over the exposures; in 0..1.
Image1 FlipErrorMap(const PicturePair& pair, const std::vector<Exposure>& exposures);

/// Mean of a map over the pair's valid pixels.
double MeanOfMap(const PicturePair& pair, const Image1& map);

}  // namespace stillray::quality
