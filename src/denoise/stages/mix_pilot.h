// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// mix_pilot: the end of the pilot estimate, which the luminance weights of the first levels
/// compare in place of single pixels. Mixes the pixel's own light into the mean of its
/// neighbourhood, more of it for longer histories (PilotShare, PilotVariance). Source: none. No
/// state, no border. Reads 20, writes 8 bytes per pixel and signal.
#pragma once

#include "denoise/planes.h"
#include "denoise/stages/estimate_variance_shared.h"

namespace stillray {

struct MixPilotInput {
  const Image1* luminance;  ///< of the pixels
  const Image1* variance;   ///< of it
  const Image1* length;     ///< of the histories
};

/// \param full  length up to which the pilot is the mean alone
/// \param luminance, variance  of the mean; become those of the pilot
namespace reference {
void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance);
}  // namespace reference
namespace cpu {
void MixPilot(const MixPilotInput& in, float full, Image1* luminance, Image1* variance);
}  // namespace cpu

}  // namespace stillray
