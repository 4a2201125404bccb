// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

#include "core/shared.h"
#include "render/shared.h"
#include "render/geometry_shared.h"
#include "render/energy_shared.h"
#include "render/ggx_shared.h"
#include "render/film_shared.h"
#include "render/sheen_shared.h"
#include "render/bsdf_shared.h"
#include "render/sampler_shared.h"
#include "render/shading_point_shared.h"
#include "render/vulkan/lights.glsl"
#include "render/medium_shared.h"
#include "render/path_shared.h"
#include "formulas_shared.h"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer Places {
  FormulaPlace places[];
};
layout(std430, set = 0, binding = 1) writeonly buffer Values {
  FormulaValues values[];
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < uint(places.length())) {
    values[i] = ComputeFormulas(places[i]);
  }
}
