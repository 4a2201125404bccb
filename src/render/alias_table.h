// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tables for sampling discrete distributions (alias_shared.h).
#pragma once

#include <cstddef>

#include "render/alias_shared.h"

namespace stillray::render {

/// Fills `table` (of the same size) for the given weights, all >= 0 and finite. Without any
/// positive weight, probabilities are 0 and the table must not be sampled. AliasEntry::item is
/// unchanged.
void FillAliasTable(const float* weights, size_t count, AliasEntry* table);

}  // namespace stillray::render
