// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// All includes of the path tracer's shaders, in the required order.
#include "render/vulkan/scene.glsl"
#include "render/vulkan/material_lookup.glsl"
#include "render/shading_point_shared.h"
#include "render/vulkan/lights.glsl"
#include "render/medium_shared.h"
#include "render/path_shared.h"
#include "render/light_candidates_shared.h"
#include "render/sampler_shared.h"
#include "render/vulkan/trace.glsl"
#include "render/vulkan/path_state.glsl"
