// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// JSON representation of the doctor's findings, common to all commands.
#pragma once

#include <nlohmann/json.hpp>

#include "stillray/doctor.h"

namespace stillray {

/// JSON has no infinity and no NaN: both become null.
nlohmann::ordered_json FiniteNumberJson(double value);

nlohmann::ordered_json FindingJson(const Finding& finding);
/// Parses the output of FindingJson(). Throws the JSON library's exceptions on other input.
Finding ParseFinding(const nlohmann::ordered_json& json);

}  // namespace stillray
