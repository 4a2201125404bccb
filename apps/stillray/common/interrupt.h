// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Handles Ctrl-C and SIGTERM as a flag that long work polls.
#pragma once

namespace stillray {

/// From here on SIGINT and SIGTERM only set a flag; a second one ends the program at once.
void CatchInterrupts();

/// Whether SIGINT or SIGTERM was received since CatchInterrupts().
bool Interrupted();

}  // namespace stillray
