// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Resampled importance sampling of lights (Talbot, Cline, Egbert 2005, "Importance Resampling for
// Global Illumination"): a surface draws several candidates by SampleLights. One candidate is
// selected for the shadow ray, in proportion to its unoccluded contribution w, and its contribution
// is weighted by sum(w) / (n w). The expected value over the selection is the mean of all
// candidates, hence the estimator is unbiased for any w that is positive wherever the contribution
// is.
#ifndef STILLRAY_RENDER_LIGHT_CANDIDATES_SHARED_H
#define STILLRAY_RENDER_LIGHT_CANDIDATES_SHARED_H

#ifdef __cplusplus
#include "core/colour_shared.h"
#include "render/path_shared.h"
#endif

STILLRAY_RENDER_BEGIN

// Fractions of the R2 sequence (M. Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
// Sequences").
const float kCandidateStepX = 0.7548776662f;
const float kCandidateStepY = 0.5698402910f;

// Random numbers of candidate i of n: the numbers of candidate 0, shifted modulo 1, which keeps
// them uniform. Light choices are stratified, positions on the light follow the R2 sequence.
SHARED_FN vec4 CandidateNumbers(vec4 u, int i, int n) {
  vec3 shift = vec3(kCandidateStepX, kCandidateStepY, 1.0f / float(n)) * float(i);
  return vec4(min(fract(vec3(u.x, u.y, u.z) + shift), vec3(kBelowOne)), u.w);
}

// Number of candidates per surface. Path vertices after the first draw half as many, since they
// contribute less to the image at equal cost. A single light without extent needs one candidate.
// \param wanted  RenderSettings::light_candidates
SHARED_FN int CandidateCount(LIGHTS_IN int wanted, bool first) {
  int count = first ? wanted : (wanted + 1) / 2;
  return lights.is_one_point != 0 ? 1 : count;
}

// State of weighted reservoir sampling (Chao 1982) over a stream of candidates.
struct CandidateChoice {
  float sum;     // sum of the weights so far
  float weight;  // weight of the chosen candidate; 0: none yet
  float u;       // random number in [0, 1), independent of the choice
};

SHARED_FN CandidateChoice NoCandidate(float u) {
  CandidateChoice none;
  none.sum = 0.0f;
  none.weight = 0.0f;
  none.u = u;
  return none;
}

// Whether the next candidate replaces the chosen one. \param weight  weight of the next, > 0
SHARED_FN bool TakesCandidate(SHARED_INOUT(CandidateChoice) choice, float weight) {
  choice.sum += weight;
  float probability = weight / choice.sum;
  bool takes = choice.u < probability;
  choice.u = takes ? choice.u / probability : (choice.u - probability) / (1.0f - probability);
  choice.u = clamp(choice.u, 0.0f, kBelowOne);
  choice.weight = takes ? weight : choice.weight;
  return takes;
}

// Weight of the chosen candidate's contribution. \param n  number of all candidates, including
// those without contribution
SHARED_FN float FactorOfChosen(SHARED_IN(CandidateChoice) choice, int n) {
  return choice.sum / (float(n) * choice.weight);
}

// Reservoir weight of a candidate with this contribution.
SHARED_FN float CandidateWeight(SHARED_IN(FoundLight) found) {
  vec3 light = found.diffuse + found.specular;
  return Luminance709(light.x, light.y, light.z);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LIGHT_CANDIDATES_SHARED_H
