// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Lets a header of formulas compile both as C++ and as GLSL. Such headers hold plain functions of
// float, int, uint and vec2..vec4, marked SHARED_FN, and blocks of parameters, marked SHARED_BLOCK,
// whose members are float, int, uint and parameter blocks. A block has the same bytes in C++ as in
// a std140 uniform block, where structures begin at multiples of 16 bytes and fill them.
#ifndef STILLRAY_CORE_SHARED_H
#define STILLRAY_CORE_SHARED_H

#ifdef __cplusplus
#include <cmath>

#include "stillray/vec.h"

#define SHARED_FN inline
#define SHARED_BLOCK(Name) struct alignas(16) Name
#define SHARED_BEGIN namespace stillray {
#define SHARED_END }

namespace stillray {
using uint = unsigned int;
using glm::abs;
using glm::clamp;
using glm::dot;
using glm::exp;
using glm::floor;
using glm::log;
using glm::max;
using glm::min;
using glm::pow;
using glm::sqrt;
}  // namespace stillray
#else
#define SHARED_FN
#define SHARED_BLOCK(Name) struct Name
#define SHARED_BEGIN
#define SHARED_END
#endif

#endif  // STILLRAY_CORE_SHARED_H
