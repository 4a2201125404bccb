// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Resampled importance sampling of lights (Talbot, Cline, Egbert 2005, "Importance Resampling for
// Global Illumination"): a surface draws several candidates by SampleLights. One of them gets the
// shadow ray, chosen in proportion to the light w that it would add if nothing were in the way, and
// counts for the mean of all: its light times sum(w) / (n w). The mean over all choices is that of
// the candidates, so any w that is positive where there is light is unbiased.
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

// The numbers of candidate i of n: those of candidate 0, shifted modulo 1, so that each candidate's
// are uniform. Choices of the light are stratified, positions on it follow the R2 sequence.
SHARED_FN vec4 CandidateNumbers(vec4 u, int i, int n) {
  vec3 shift = vec3(kCandidateStepX, kCandidateStepY, 1.0f / float(n)) * float(i);
  return vec4(min(fract(vec3(u.x, u.y, u.z) + shift), vec3(kBelowOne)), u.w);
}

// How many candidates a surface draws. Light of surfaces after the first one is a smaller part of
// the picture, for the same cost: they draw half as many. All candidates of a single light without
// extent are equal.
// \param wanted  RenderSettings::light_candidates
SHARED_FN int CandidateCount(LIGHTS_IN int wanted, bool first) {
  int count = first ? wanted : (wanted + 1) / 2;
  return lights.is_one_point != 0 ? 1 : count;
}

// Chooses one of a stream of candidates (weighted reservoir sampling, Chao 1982).
struct CandidateChoice {
  float sum;     // of the weights so far
  float weight;  // of the chosen candidate; 0: none yet
  float u;       // uniform in [0, 1), independent of the choice
};

SHARED_FN CandidateChoice NoCandidate(float u) {
  CandidateChoice none;
  none.sum = 0.0f;
  none.weight = 0.0f;
  none.u = u;
  return none;
}

// Whether the next candidate takes the place of the chosen one. \param weight  > 0
SHARED_FN bool TakesCandidate(SHARED_INOUT(CandidateChoice) choice, float weight) {
  choice.sum += weight;
  float probability = weight / choice.sum;
  bool takes = choice.u < probability;
  choice.u = takes ? choice.u / probability : (choice.u - probability) / (1.0f - probability);
  choice.u = clamp(choice.u, 0.0f, kBelowOne);
  choice.weight = takes ? weight : choice.weight;
  return takes;
}

// Factor of the chosen candidate's light. \param n  all candidates, those without light included
SHARED_FN float FactorOfChosen(SHARED_IN(CandidateChoice) choice, int n) {
  return choice.sum / (float(n) * choice.weight);
}

// The weight of a candidate that would add this light.
SHARED_FN float CandidateWeight(SHARED_IN(FoundLight) found) {
  vec3 light = found.diffuse + found.specular;
  return Luminance709(light.x, light.y, light.z);
}

STILLRAY_RENDER_END

#endif  // STILLRAY_RENDER_LIGHT_CANDIDATES_SHARED_H
