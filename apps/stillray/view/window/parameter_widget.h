// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A widget for any row of a table of settings.
#pragma once

#include <optional>
#include <string>

#include "stillray/parameter.h"

namespace stillray::view {

/// Name, control, and a button that restores the base value if the value differs.
/// \param base_name  name of the base in the tooltip: "preset", "default"
/// \return the new value as text if the user changed it; typed text may be invalid
std::optional<std::string> ParameterWidget(const Parameter& p, const std::string& value,
                                           const char* base_name, const std::string& base);

}  // namespace stillray::view
