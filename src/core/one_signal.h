// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Merges the signals of a frame, for renderers with a single signal.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The frame with all radiance in the direct diffuse signal and the sum of all albedos as albedo,
/// so that SumOfLight is unchanged. Roughness is removed. Frames with second moments, which cannot
/// be summed, are copied unchanged.
/// \param frame  its planes must be on the host
/// \param out    planes of the right size are reused
void ToOneSignal(const Frame& frame, Frame* out);

}  // namespace stillray
