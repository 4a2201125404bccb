// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of correct_history and limit_history.
#ifndef STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H
#define STILLRAY_DENOISE_LIMIT_HISTORY_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

#include "denoise/stages/edge_stopping_shared.h"
#include "denoise/stages/light_change_shared.h"
#include "denoise/stages/select_guides_shared.h"

SHARED_BEGIN

SHARED_BLOCK(LimitHistoryParameters) {
  int correct_history;  // 0: the ratio is 1
  float limit_dead;
  float limit_gain;
  int has_roughness;  // 1: the device has an image of the roughness
  float jitter_x;     // offset of this frame's rays from the pixel centres
  float jitter_y;
  int wide_signals;  // number of signals whose wide change is measured, from the first
  int fine_signals;  // bit s: changes of signal s are also measured over few pixels
};

// Luminance compressed to 0..1, 1/2 at `scale`. This bounds the influence of one bright sample on
// its neighbourhood.
SHARED_FN float CompressLuminance(float l, float scale) {
  return max(l, 0.0f) / (max(l, 0.0f) + scale);
}

// The compressed luminance under another scale: exact for a single value.
SHARED_FN float RescaleCompressed(float c, float old_scale, float scale) {
  return c * old_scale / max(c * old_scale + (1.0f - c) * scale, 1e-30f);
}

// Variance of compressed single samples whose mean is c, when the samples themselves have mean l
// and this variance: to first order about l, and at most the largest variance of a variable in 0..1
// with mean c (Bhatia and Davis 2000), which sparse bright samples nearly reach.
SHARED_FN float CompressedVariance(float c, float l, float variance, float scale) {
  // In two steps: after black frames the scale is so small that its square would underflow.
  float s = max(l, 0.0f) + scale;
  float slope = scale / s / s;
  return min(slope * variance * slope, c * (1.0f - c));
}

// The compression scale, which should change rarely: the history's scale while the mean luminance
// is within a factor of two of it, else the mean luminance.
SHARED_FN float CompressionScale(float history_scale, float mean_luminance) {
  bool near_by = mean_luminance < 2.0f * history_scale && history_scale < 2.0f * mean_luminance;
  return near_by ? history_scale : max(mean_luminance, 1e-20f);
}

// The length to which a Kalman filter would reduce a history with this relative bias (BiasOfFrame).
SHARED_FN float LimitedLength(float length, float weights2, float bias, float gain) {
  float limit = 1.0f / max(weights2 + gain * bias, 1e-6f);
  return bias > 0.0f ? min(length, limit) : length;
}

// Geometry weights between pixels and coarse grid, and on the grid. Radiance is compared over tens
// of pixels, where the number of samples matters more than shading over a curved surface.
const float kComparedSigmaN = 16.0f;
const float kComparedTolerance = 0.02f;  // relative distance from the plane, in depth

// Weight of a pixel or block with inverse depth `found`, where that of the plane is `expected`.
SHARED_FN float ComparedWeight(float cosine, float expected, float found, float own) {
  return exp(kComparedSigmaN * LogCosine(cosine) -
             abs(expected - found) / (kComparedTolerance * own));
}

// Sums of weights below this are treated as zero.
const float kLeastComparedWeight = 1e-3f;

// Histories below this length have no variance over time.
const float kLengthWithVariance = 4.0f - 1e-3f;

// Radiance that has been steady for long is less likely to change, and every correction adds noise
// of the present to a history with little noise. The duration is measured in frames: length / n,
// for frames of n samples.
const float kSteadyFrames = 8.0f;
SHARED_FN float ComparisonCaution(float length, float n) {
  return sqrt(max(length / (max(n, 1.0f) * kSteadyFrames), 1.0f));
}

// Expected squared difference between present and history, from n samples and a history with these
// moments; at least the squared difference itself, which is an unbiased estimate while the radiance
// is constant, and the only one for a short history. It also contains rare bright samples that the
// moments do not include: a mean that is dominated by one of them does not count as a change.
// Multiplied by ComparisonCaution.
SHARED_FN float ComparisonNoise(float present, float n, float length, float mean, float variance,
                                float weights2) {
  float single = variance / max(1.0f - weights2, 0.25f);
  float noise = single * (1.0f / max(n, 1.0f) + weights2);
  float d = present - mean;
  return ComparisonCaution(length, n) * max(length >= kLengthWithVariance ? noise : 0.0f, d * d);
}

// The share of a pixel's own squared difference that counts as noise. With 0, a bright sample on a
// surface of few pixels, such as the rim of a ball, would count as a change, reset the history and
// stay as a speck. With 1, changes on thin parts would count as noise. Virtual images use 1: they
// have many small parts, move exactly with their guides, and rarely change in radiance. Short
// histories have no other estimate of the noise, and little to lose: they use 1/2.
const float kShareOfChange = 0.25f;
const float kShareOfShortChange = 0.5f;
// 1 for histories without a temporal variance, 0 for longer ones; continuous, so that rounding has
// no visible effect.
SHARED_FN float Shortness(float length) {
  return min(max(kLengthWithVariance - length, 0.0f), 1.0f);
}
SHARED_FN float ShareOfChange(float roughness, float length) {
  float share = kShareOfChange + Shortness(length) * (kShareOfShortChange - kShareOfChange);
  return roughness >= kRoughnessOfImage ? 1.0f : share;
}

// Variance of the difference between n samples and a history, in variances of a single sample.
SHARED_FN float SpreadOfDifference(float n, float weights2) {
  return 1.0f / max(n, 1.0f) + weights2;
}

// Expected square of the difference d between compressed luminances of present and history; at
// least the share `share` of d^2 itself (ShareOfChange).
// \param single  variance of single samples
// \param spread  SpreadOfDifference
SHARED_FN float CompressedNoise(float d, float single, float spread, float share) {
  return max(single * spread, share * d * d);
}

// Variance of single samples, the divisor of RelativeBias. It is 0 for histories of one frame,
// which any difference beyond the noise would then end. While the radiance is constant, the
// expected squared difference is `spread` times the variance, so that d^2 / spread estimates it. A
// part of this estimate is enough for shadow fronts to be followed, since short histories have
// little to lose.
const float kSingleOfShortChange = 0.1f;
SHARED_FN float SingleVariance(float d, float single, float length, float spread) {
  return max(single, Shortness(length) * kSingleOfShortChange * (d * d / spread));
}

// Slope of the compressed history per block, from the neighbours `before` and `after` along an
// axis: the smaller of the two differences, 0 at an extremum, so that edges do not count as slopes.
SHARED_FN float BlockSlope(float before, float here, float after) {
  float a = here - before;
  float b = after - here;
  return a * b > 0.0f ? (abs(a) < abs(b) ? a : b) : 0.0f;
}

// The difference due to jitter: the rays of a frame have one common offset from the pixel centres,
// while the history is a mean over many offsets. All blocks around have this offset, so that
// averaging does not remove the difference.
// \param dx, dy  BlockSlope: change over two pixels
SHARED_FN float JitterShift(float dx, float dy, float jitter_x, float jitter_y) {
  return 0.5f * (dx * jitter_x + dy * jitter_y);
}

// Variance of the error of JitterShift, due to curvature of the radiance and to the offsets in the
// history. The levels treat it as independent noise.
const float kJitterNoise = 0.4f;
SHARED_FN float JitterNoise(float dx, float dy) {
  return kJitterNoise * (dx * dx + dy * dy);
}

// A moving lamp changes the radiance in most of the image, a moving object only some shadows and
// reflections. The share of changed blocks in the whole image therefore estimates the prior
// probability of a change at each block (empirical Bayes), which a few samples cannot separate from
// noise. A block has changed if present and history differ by more than two standard deviations,
// and by a small fraction of the radiance.
const float kChangedVariances = 4.0f;
const float kLeastMovement = 0.05f;
SHARED_FN bool HasChanged(float present, float history, float noise) {
  float d = present - history;
  float least = kLeastMovement * history;
  return d * d > max(kChangedVariances * noise, least * least);
}

// 0 for static lighting of a signal, 1 for moving lights, from the number of changed blocks and the
// number of blocks with present and history. Under static lights, shadows and new surfaces change
// up to a third of the blocks of diffuse light, and a twelfth of other light (measured; with moving
// lamps 0.43 to 0.84, and 0.14 to 0.23). Means are over 27x27 blocks: with fewer than sixteen such
// neighbourhoods, the noise of a single one can exceed these shares.
const float kMovementEvidence = 16.0f * 27.0f * 27.0f;
SHARED_FN float MovingLight(float changed, float known, bool is_diffuse) {
  float share = changed / max(known, 1.0f);
  float still = is_diffuse ? 0.3f : 0.1f;
  float moving = is_diffuse ? 0.5f : 0.2f;
  float evidence = min(known / kMovementEvidence, 1.0f);
  return evidence * min(max((share - still) / (moving - still), 0.0f), 1.0f);
}

// Whether MovingLight is measured, else it is 0: it needs the levels of correct_history, and is not
// used for sparse frames.
// \param grows  AtrousParameters::grows, of sparse frames
SHARED_FN bool FindsMovingLight(int correct_history, int grows) {
  return correct_history != 0 && grows == 0;
}

// The dead zone of limit_history, which is narrower under moving lights.
const float kMovingDead = 0.6f;
SHARED_FN float DeadZone(float dead, float moving) {
  return dead + moving * (min(dead, kMovingDead) - dead);
}

// The multiple of the difference's expected variance that counts as noise in the ratio, and the
// largest ratio.
const float kRatioNoise = 1.75f;
const float kMovingRatioNoise = 1.0f;
const float kMostRatio = 2.0f;
SHARED_FN float RatioNoise(float moving) {
  return kRatioNoise + moving * (kMovingRatioNoise - kRatioNoise);
}

// Ratio of two means over a neighbourhood, shrunk towards 1 as far as noise explains their
// difference (James and Stein 1961).
// \param noise  a multiple of the variance of the difference
SHARED_FN float ShrunkenRatio(float present, float before, float noise) {
  float d = present - before;
  float significance = max(1.0f - noise / max(d * d, 1e-30f), 0.0f);
  float ratio = 1.0f + significance * d / max(before, 1e-20f);
  return before > 1e-20f ? min(max(ratio, 1.0f / kMostRatio), kMostRatio) : 1.0f;
}

// Ratio of present to history. \param moving  MovingLight
SHARED_FN float HistoryRatio(float present, float history, float noise, float moving) {
  return ShrunkenRatio(present, history, RatioNoise(moving) * noise);
}

// The change over the wide surroundings of a block is the mean over those of 5x5 neighbourhoods (of
// HistoryRatio), this many blocks apart, that lie on its surface ...
const int kWideStep = 13;
// ... if there are more than this many. Neighbourhoods are 27 blocks wide and overlap: kWideOverlap
// of them count as one independent neighbourhood.
const float kWideKnown = 8.5f;
const float kWideOverlap = 27.0f * 27.0f / float(kWideStep * kWideStep);
// The noise of the mean change: a multiple of its variance from the scatter of the changes, which
// is large where the radiance changes by different factors; a multiple of its variance from the
// noise of the neighbourhoods, which the scatter underestimates on small surfaces; and a least
// change.
const float kWideScatter = 3.0f;
const float kWideNoise = 1.0f;
const float kWideLeast = 0.003f;

// Variance of the change of a neighbourhood.
// \param noise  expected squared difference of present and history
SHARED_FN float ChangeVariance(float noise, float history) {
  float deviation = min(sqrt(max(noise, 0.0f)) / max(history, 1e-20f), kMostChange);
  return deviation * deviation;
}

// \param mean, square  means of the changes and of their squares
// \param variance      ChangeVariance at the block
// \param weights2      sum of the squared weights of the changes
// \return the ratio of present to history
SHARED_FN float WideRatio(float mean, float square, float variance, float weights2) {
  float known = 1.0f / max(weights2, 1e-3f);
  float scatter = kWideScatter * VarianceOfChange(mean, square, known);
  float noise = kWideNoise * variance / max(known, 1.0f);
  float change = ShrunkenChange(mean, kWideOverlap * max(scatter, noise) + kWideLeast * kWideLeast);
  return known >= kWideKnown ? exp(change) : 1.0f;
}

// Ratio of present to history: the ratio of the wide surroundings times the remaining local ratio.
SHARED_FN float CorrectedRatio(float present, float history, float noise, float wide,
                               float moving) {
  return wide * HistoryRatio(present, history * wide, noise, moving);
}

// The compressed luminance after multiplication by a ratio: exact for a single value.
SHARED_FN float ScaledCompressed(float c, float ratio) {
  return c * ratio / max(c * ratio + 1.0f - c, 1e-30f);
}

// Upper bound of the bias, far above the value that shortens a history to one frame.
const float kMostBias = 1000.0f;

// Squared bias of a history, relative to the variance of single samples: the excess of the squared
// difference d^2 over its expected noise.
SHARED_FN float RelativeBias(float d, float noise, float variance, float dead) {
  float excess = max(0.0f, d * d - (1.0f + dead) * noise);
  return min(excess / max(variance, 1e-8f), kMostBias);
}

// Trails of highlights and shadow fronts may be narrower than the neighbourhood of limit_history,
// and be lost in it. For signals with direct light, the output of the first level counts as well:
// it averages fewer pixels, so that its noise is larger and its dead zone wider by this factor.
// Indirect light has no sharp fronts, but few bright samples.
const float kFineDead = 2.0f;

// Squared bias relative to the variance of the mean of this frame's n samples. A Kalman filter with
// lengths in samples would not have the factor n; it was found by measurement (docs/denoiser.md):
// the less noise a frame has, the larger is the share of lag in its error.
SHARED_FN float BiasOfFrame(float bias, float n) {
  return min(bias * max(n, 1.0f), kMostBias);
}

SHARED_END

#endif
