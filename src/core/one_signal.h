// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of several signals as a renderer that knows only one would give them.
#pragma once

#include "stillray/frame.h"

namespace stillray {

/// The same frame with all light as direct diffuse light and all albedos as one: what a filter of
/// one signal makes of it is the same. Roughness is left out. Frames with second moments, which do
/// not add up, are copied as they are.
/// \param frame  with its planes on the host
/// \param out    planes of the right size are kept
void ToOneSignal(const Frame& frame, Frame* out);

}  // namespace stillray
