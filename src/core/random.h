// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Uniform numbers from the hashes of core/random_shared.h.
#pragma once

#include <cstdint>

#include "core/random_shared.h"

namespace stillray {

/// Uniform in [0, 1): the top 24 bits, so that the result is exact and never rounds up to 1.
inline float UniformFloat(uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1p-24f;
}

}  // namespace stillray
