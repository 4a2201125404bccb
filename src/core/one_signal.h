// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Merges the signals of a frame, as a renderer with a single signal would deliver it.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The same frame with all light as direct diffuse light and all albedos in one, so that its sum of
/// light times albedo is unchanged. Roughness is left out. Frames with second moments, which cannot
/// be summed, are copied unchanged.
/// \param frame  its planes must be on the host
/// \param out    planes of the right size are reused
void ToOneSignal(const Frame& frame, Frame* out);

}  // namespace stillray
