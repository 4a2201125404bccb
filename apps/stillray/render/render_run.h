// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Runs `stillray render`: traces, filters and writes the frames in order.
#pragma once

#include "render/render_options.h"
#include "stillray/scene.h"

namespace stillray {

/// Renders all frames of the options.
/// \param scene    the loaded scene
/// \param threads  number of threads, at least 1
/// \return kCancelled if stopped by the user: finished frames and the history are kept
Status RunFrames(const RenderOptions& options, const Scene& scene, int threads);

}  // namespace stillray
