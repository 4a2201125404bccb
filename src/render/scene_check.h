// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Checks what the path tracer takes for granted about a scene: scenes may be built by hand.
#pragma once

#include "stillray/render.h"

namespace stillray::render {

/// \return kInvalidArgument naming the element, what was found and what was expected
Status CheckScene(const Scene& scene);

/// \return kInvalidArgument naming the setting, its value and its range
Status CheckSettings(const RenderSettings& settings);

/// \return kInvalidArgument naming the member, its value and its range
Status CheckMoment(const Scene& scene, const RenderMoment& moment);

}  // namespace stillray::render
