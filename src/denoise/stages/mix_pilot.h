// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// mix_pilot: the last step of the pilot estimate, which the luminance weights of the first levels
/// compare in place of single pixels. Mixes the pixel's own value into the mean of its
/// neighbourhood, with a share that grows with the history length (PilotShare, PilotVariance).
/// Source: none. No state, no border. Reads 20, writes 8 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray {

struct MixPilotInput {
  const Image1* luminance;  ///< of single pixels
  const Image1* variance;   ///< of `luminance`
  const Image1* length;     ///< of the histories
};

/// \param full  history length up to which the pilot is the mean alone
/// \param luminance, variance  [in,out] of the mean; replaced by those of the pilot
namespace reference {
void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance);
}  // namespace reference
namespace cpu {
void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance);
}  // namespace cpu

}  // namespace stillray
