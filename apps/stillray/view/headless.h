// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The viewer without a window: writes its pictures to files.
#pragma once

#include "stillray/status.h"
#include "view/view_options.h"

namespace stillray::view {

/// Renders the frames one by one, writes each to FOLDER/view.####.png (none without a folder), and
/// prints its time. The same options give the same pictures.
/// \return kCancelled after Ctrl-C
Status RunHeadless(const ViewOptions& options);

}  // namespace stillray::view
