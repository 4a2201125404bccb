// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The random numbers of many paths at once: PathSampler::Get in SIMD, with the same bits.
#pragma once

#include <cstdint>

#include "render/accel.h"
#include "render/sampler.h"

namespace stillray::render {

/// The inputs of PathSampler::Get for each path, as structure of arrays.
struct SamplerBatch {
  SamplerKind kind = SamplerKind::kSobol;  ///< common to all paths
  int count = 0;
  alignas(64) uint32_t index[kBatchCapacity];
  alignas(64) uint32_t seed[kBatchCapacity];
  alignas(64) uint32_t set[kBatchCapacity];

  void Push(const PathSampler& sampler, uint32_t dimensions) {
    const int i = count++;
    kind = sampler.kind;
    index[i] = sampler.index;
    seed[i] = sampler.seed;
    set[i] = dimensions;
  }
};

/// Four numbers in [0, 1) for each path.
struct NumberBatch {
  alignas(64) float u[4][kBatchCapacity];

  vec4 Get(int i) const { return {u[0][i], u[1][i], u[2][i], u[3][i]}; }
};

/// Sets numbers->Get(i) to the numbers of the sampler of path i for set[i] + offset.
void DrawNumbers(const SamplerBatch& samplers, uint32_t offset, NumberBatch* numbers);

}  // namespace stillray::render
