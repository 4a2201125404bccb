// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Adds the name of the file, option or part to an error message.
#pragma once

#include <string>

#include "stillray/status.h"

namespace stillray {

/// \param status  not ok
/// \return the code of `status`, and the message "prefix: message"
inline Status PrefixStatus(const std::string& prefix, const Status& status) {
  return {status.code(), prefix + ": " + status.message()};
}

}  // namespace stillray
