// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The run of `stillray render`: frames traced, filtered and written, one after the other.
#pragma once

#include "render/render_options.h"
#include "stillray/scene.h"

namespace stillray {

/// Renders all frames that the options ask for.
/// \param scene    loaded for them
/// \param threads  of the run, at least 1
/// \return kCancelled where the user stopped it: finished frames and the history are kept
Status RunFrames(const RenderOptions& options, const Scene& scene, int threads);

}  // namespace stillray
