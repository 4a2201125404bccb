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
  int has_roughness;  // a device's image of it
  float jitter_x;     // where this frame's rays go, from the centres of the pixels
  float jitter_y;
  int wide_signals;  // whose wide change is measured, the first ones
  int fine_signals;  // bit s: change of signal s is searched for within few pixels too
};

// Luminance compressed to 0..1, 1/2 at `scale`, which bounds the influence of one bright sample on
// its neighbourhood.
SHARED_FN float CompressLuminance(float l, float scale) {
  return max(l, 0.0f) / (max(l, 0.0f) + scale);
}

// The compressed luminance under another scale: exact for a single value.
SHARED_FN float RescaleCompressed(float c, float old_scale, float scale) {
  return c * old_scale / max(c * old_scale + (1.0f - c) * scale, 1e-30f);
}

// Variance of compressed single samples whose mean is c, when the samples themselves have mean l
// and this variance: first order about l, and never more than that of a variable in 0..1 with mean
// c (Bhatia and Davis 2000), which sparse bright samples come close to.
SHARED_FN float CompressedVariance(float c, float l, float variance, float scale) {
  // In two steps: after black frames the scale is so small that its square would underflow.
  float s = max(l, 0.0f) + scale;
  float slope = scale / s / s;
  return min(slope * variance * slope, c * (1.0f - c));
}

// The compression scale, which follows the light without changing from frame to frame: the
// history's as long as the mean luminance is within a factor of two of it, else the mean.
SHARED_FN float CompressionScale(float history_scale, float mean_luminance) {
  bool near_by = mean_luminance < 2.0f * history_scale && history_scale < 2.0f * mean_luminance;
  return near_by ? history_scale : max(mean_luminance, 1e-20f);
}

// The history length to which a Kalman filter would reduce a history with this relative bias, which
// is that of BiasOfFrame.
SHARED_FN float LimitedLength(float length, float weights2, float bias, float gain) {
  float limit = 1.0f / max(weights2 + gain * bias, 1e-6f);
  return bias > 0.0f ? min(length, limit) : length;
}

// Geometry weights between the pixels and the coarse grid, and on it. Light is compared at a scale
// of tens of pixels, where shading over a curved surface matters less than samples do.
const float kComparedSigmaN = 16.0f;
const float kComparedTolerance = 0.02f;  // of the plane, in depth

// Weight of a pixel or block whose inverse depth is `found` where `expected` is the plane's.
SHARED_FN float ComparedWeight(float cosine, float expected, float found, float own) {
  return exp(kComparedSigmaN * LogCosine(cosine) -
             abs(expected - found) / (kComparedTolerance * own));
}

// Sums of weights below this are treated as zero.
const float kLeastComparedWeight = 1e-3f;

// Histories below this length have no variance over time.
const float kLengthWithVariance = 4.0f - 1e-3f;

// Light that has been steady for long is less likely to change, and every correction adds noise of
// the present to a history that has little. Long means frames: a history of `length` samples has
// that many of n.
const float kSteadyFrames = 8.0f;
SHARED_FN float ComparisonCaution(float length, float n) {
  return sqrt(max(length / (max(n, 1.0f) * kSteadyFrames), 1.0f));
}

// Expected squared difference between present and history, from n samples and a history with these
// moments; at least the difference itself. It is its own estimate without bias as long as the light
// is the same, and the only one of a short history. Above all it contains rare bright samples that
// the moments have not met: the mean of a neighbourhood that one of them dominates is no change.
// Multiplied by ComparisonCaution.
SHARED_FN float ComparisonNoise(float present, float n, float length, float mean, float variance,
                                float weights2) {
  float single = variance / max(1.0f - weights2, 0.25f);
  float noise = single * (1.0f / max(n, 1.0f) + weights2);
  float d = present - mean;
  return ComparisonCaution(length, n) * max(length >= kLengthWithVariance ? noise : 0.0f, d * d);
}

// The share of a pixel's own squared difference that is noise. Without it a bright sample on a
// surface of few pixels, such as the rim of a ball, is a change of the light, loses its history and
// stays as a speck. With all of it change on thin parts is noise. In virtual images all of it is:
// they show many small parts, move exactly with their guides, and are rarely a change of the light.
// Short histories have no other estimate of the noise, and little to lose: half of it.
const float kShareOfChange = 0.25f;
const float kShareOfShortChange = 0.5f;
// 1 for histories without a variance over time, 0 for those with one; continuous, so that rounding
// decides nothing.
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

// Expected squared difference d between compressed luminances of present and history, `single` the
// variance of single samples; at least ShareOfChange of the difference itself.
// \param spread  SpreadOfDifference
SHARED_FN float CompressedNoise(float d, float single, float spread, float share) {
  return max(single * spread, share * d * d);
}

// Variance of single samples, to which RelativeBias relates the bias. That of short histories is 0
// after one frame, and every difference beyond the noise would end them; the squared difference
// itself has `spread` times the variance as long as the light is the same. A part of it is enough
// for fronts of shadows to be followed, since short histories have little to lose.
const float kSingleOfShortChange = 0.1f;
SHARED_FN float SingleVariance(float d, float single, float length, float spread) {
  return max(single, Shortness(length) * kSingleOfShortChange * (d * d / spread));
}

// Difference of the compressed history from one block to the next, of which `before` and `after`
// are the neighbours along an axis: the smaller one, 0 at an extremum, so that edges are not
// slopes.
SHARED_FN float BlockSlope(float before, float here, float after) {
  float a = here - before;
  float b = after - here;
  return a * b > 0.0f ? (abs(a) < abs(b) ? a : b) : 0.0f;
}

// What jitter changes: rays that miss the centres of the pixels by one offset meet other light than
// the history, which is a mean over many offsets. The offset is the same for all blocks around, so
// that no average removes the difference.
// \param dx, dy  BlockSlope: two pixels' change
SHARED_FN float JitterShift(float dx, float dy, float jitter_x, float jitter_y) {
  return 0.5f * (dx * jitter_x + dy * jitter_y);
}

// Variance of what JitterShift leaves: where light bends, and by the offsets in the history. The
// levels treat it as independent noise.
const float kJitterNoise = 0.4f;
SHARED_FN float JitterNoise(float dx, float dy) {
  return kJitterNoise * (dx * dx + dy * dy);
}

// Where a lamp moves, the light of most of the picture changes; else that of some shadows and
// reflections. So the share of changed blocks in the whole picture estimates the prior probability
// of a change at each of them (empirical Bayes), which a few samples cannot separate from noise. A
// block has changed if present and history differ by more than two deviations, and by a small part
// of the light.
const float kChangedVariances = 4.0f;
const float kLeastMovement = 0.05f;
SHARED_FN bool HasChanged(float present, float history, float noise) {
  float d = present - history;
  float least = kLeastMovement * history;
  return d * d > max(kChangedVariances * noise, least * least);
}

// 0 where the light of a signal is still, 1 where it moves, from the numbers of blocks that have
// changed and of those with present and history. Shadows, and what comes into view, change up to a
// third of the diffuse light even so, and a twelfth of other light (measured; moving lamps 0.43 to
// 0.84, and 0.14 to 0.23). Means are over 27x27 blocks: with fewer than sixteen such neighbourhoods
// the noise of a single one can exceed these shares.
const float kMovementEvidence = 16.0f * 27.0f * 27.0f;
SHARED_FN float MovingLight(float changed, float known, bool is_diffuse) {
  float share = changed / max(known, 1.0f);
  float still = is_diffuse ? 0.3f : 0.1f;
  float moving = is_diffuse ? 0.5f : 0.2f;
  float evidence = min(known / kMovementEvidence, 1.0f);
  return evidence * min(max((share - still) / (moving - still), 0.0f), 1.0f);
}

// Whether MovingLight is measured; it is 0 elsewhere: it needs the levels of correct_history, and
// not in sparse frames.
// \param grows  AtrousParameters::grows, of sparse frames
SHARED_FN bool FindsMovingLight(int correct_history, int grows) {
  return correct_history != 0 && grows == 0;
}

// The dead zone of limit_history, which is narrower where light moves.
const float kMovingDead = 0.6f;
SHARED_FN float DeadZone(float dead, float moving) {
  return dead + moving * (min(dead, kMovingDead) - dead);
}

// How many expected variances of the difference count as noise in the ratio, and its bounds.
const float kRatioNoise = 1.75f;
const float kMovingRatioNoise = 1.0f;
const float kMostRatio = 2.0f;
SHARED_FN float RatioNoise(float moving) {
  return kRatioNoise + moving * (kMovingRatioNoise - kRatioNoise);
}

// Ratio of two means over a neighbourhood, shrunk towards 1 as far as their difference is explained
// by noise (James and Stein 1961).
// \param noise  what counts as noise: a multiple of the variance of the difference
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

// The change over the wide surroundings of a block is the mean over 5x5 neighbourhoods of
// HistoryRatio, this many blocks apart, as far as they are of the same surface ...
const int kWideStep = 13;
// ... of which more than this many are there. Neighbourhoods are 27 blocks wide, and overlap: this
// many are worth an independent one.
const float kWideKnown = 8.5f;
const float kWideOverlap = 27.0f * 27.0f / float(kWideStep * kWideStep);
// What counts as noise: variances of the mean by the scatter of the changes, which is large where
// the light changes differently in places; by the noise of the neighbourhoods, of which scatter
// shows little on small surfaces; and a mean of this size.
const float kWideScatter = 3.0f;
const float kWideNoise = 1.0f;
const float kWideLeast = 0.003f;

// Variance of the change of a neighbourhood.
// \param noise  expected squared difference of present and history
SHARED_FN float ChangeVariance(float noise, float history) {
  float deviation = min(sqrt(max(noise, 0.0f)) / max(history, 1e-20f), kMostChange);
  return deviation * deviation;
}

// \param mean, square  of the changes and their squares
// \param variance      ChangeVariance at the block
// \param weights2      sum of the squares of their weights
// \return the ratio of present to history
SHARED_FN float WideRatio(float mean, float square, float variance, float weights2) {
  float known = 1.0f / max(weights2, 1e-3f);
  float scatter = kWideScatter * VarianceOfChange(mean, square, known);
  float noise = kWideNoise * variance / max(known, 1.0f);
  float change = ShrunkenChange(mean, kWideOverlap * max(scatter, noise) + kWideLeast * kWideLeast);
  return known >= kWideKnown ? exp(change) : 1.0f;
}

// Ratio of present to history, from that of the wide surroundings and what is left of it.
SHARED_FN float CorrectedRatio(float present, float history, float noise, float wide,
                               float moving) {
  return wide * HistoryRatio(present, history * wide, noise, moving);
}

// The compressed luminance of light times a ratio: exact for a single value.
SHARED_FN float ScaledCompressed(float c, float ratio) {
  return c * ratio / max(c * ratio + 1.0f - c, 1e-30f);
}

// Far above what shortens a history to one frame.
const float kMostBias = 1000.0f;

// Squared bias of a history relative to the variance of single samples: what the squared difference
// d exceeds its expected noise by.
SHARED_FN float RelativeBias(float d, float noise, float variance, float dead) {
  float excess = max(0.0f, d * d - (1.0f + dead) * noise);
  return min(excess / max(variance, 1e-8f), kMostBias);
}

// Trails of highlights and fronts of shadows may be narrower than the neighbourhood of
// limit_history, and be lost in it. So what the first of its levels leaves counts too, where direct
// light is in the signal: fewer pixels have more noise, and a dead zone that is wider by this
// factor. Indirect light has no such fronts, but few bright samples.
const float kFineDead = 2.0f;

// The same relative to the variance of the mean of this frame's n samples. By LimitedLength in
// samples a Kalman filter would not have the factor; it is measured (docs/denoiser.md): the less
// noise a frame has, the more of its error is lag.
SHARED_FN float BiasOfFrame(float bias, float n) {
  return min(bias * max(n, 1.0f), kMostBias);
}

SHARED_END

#endif
