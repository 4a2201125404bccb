// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Common code of the shaders of layer_passes.h, which read the images of a frame: one thread per
// pixel, floats in all images.
#extension GL_EXT_samplerless_texture_functions : require

#include "core/shared.h"
#include "core/colour_shared.h"

layout(local_size_x = 16, local_size_y = 8) in;
