// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Choice among many in constant time: Vose (1991), "A linear algorithm for generating random
/// numbers with a given distribution".
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stillray::render {

struct AliasEntry {
  float keep = 1.0f;         ///< probability of the entry itself, given its column
  uint32_t other = 0;        ///< what the column gives otherwise
  float probability = 0.0f;  ///< of this entry, over all
};

/// Fills `table` (of the same size) for the given weights, all >= 0 and finite. Without any
/// positive weight, probabilities are 0 and nothing must be drawn.
void FillAliasTable(const float* weights, size_t count, AliasEntry* table);

struct AliasChoice {
  uint32_t index;
  float rest;  ///< u again uniform in [0, 1), given the index
};

/// \param u  in [0, 1)
AliasChoice ChooseByAlias(const AliasEntry* table, size_t count, float u);

}  // namespace stillray::render
