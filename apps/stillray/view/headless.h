// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer without a window: writes its images to files.
#pragma once

#include "stillray/status.h"
#include "view/view_options.h"

namespace stillray::view {

/// Renders the frames in order, writes each to FOLDER/view.####.png (unless there is no folder),
/// and prints its time. Deterministic: equal options give equal images.
/// \return kCancelled after Ctrl-C
Status RunHeadless(const ViewOptions& options);

}  // namespace stillray::view
