// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Formulas of sum_albedo.
#ifndef STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H
#define STILLRAY_DENOISE_SUM_ALBEDO_SHARED_H

#ifdef __cplusplus
#include "core/shared.h"
#endif

SHARED_BEGIN

// The range of the albedo is that of blocks of this many pixels a side, with the blocks next to
// them.
const int kAlbedoBlock = 4;
SHARED_FN int AlbedoBlocks(int size) {
  return (size + kAlbedoBlock - 1) / kAlbedoBlock;
}

SHARED_END

#endif
