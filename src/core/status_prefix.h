// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Names the file, option or part that an error is about.
#pragma once

#include <string>

#include "stillray/status.h"

namespace stillray {

/// \param status  not ok
/// \return the same code, and the message "prefix: message"
inline Status PrefixStatus(const std::string& prefix, const Status& status) {
  return {status.code(), prefix + ": " + status.message()};
}

}  // namespace stillray
