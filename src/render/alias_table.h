// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Tables for the choice among many (alias_shared.h).
#pragma once

#include <cstddef>

#include "render/alias_shared.h"

namespace stillray::render {

/// Fills `table` (of the same size) for the given weights, all >= 0 and finite. Without any
/// positive weight, probabilities are 0 and nothing must be drawn. Items are left as they are.
void FillAliasTable(const float* weights, size_t count, AliasEntry* table);

}  // namespace stillray::render
