// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Ctrl-C and a polite kill, as a question that long work asks now and then.
#pragma once

namespace stillray {

/// From here on SIGINT and SIGTERM only set a flag; a second one ends the program at once.
void CatchInterrupts();

/// Whether SIGINT or SIGTERM came since CatchInterrupts().
bool Interrupted();

}  // namespace stillray
