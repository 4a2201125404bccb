// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Converts Ctrl-C and SIGTERM to a flag that is polled by long-running work.
#pragma once

namespace stillray {

/// Installs handlers by which SIGINT and SIGTERM set a flag; a second signal terminates the program
/// immediately.
void CatchInterrupts();

/// Whether SIGINT or SIGTERM was received since CatchInterrupts().
bool Interrupted();

}  // namespace stillray
