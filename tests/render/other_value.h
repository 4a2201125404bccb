// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <string>

#include "stillray/render.h"

namespace stillray::test {

/// A value of a setting that is not its default.
inline std::string OtherValue(const Parameter& p) {
  const std::string by_default = GetRenderParameter({}, p.name).value();
  switch (p.type) {
    case ParameterType::kFlag:
      return by_default == "on" ? "off" : "on";
    case ParameterType::kChoice:
      return by_default == p.choices.back() ? p.choices.front() : p.choices.back();
    case ParameterType::kSeed:
      return "18446744073709551615";
    case ParameterType::kRate:
      return "1/8";
    default:
      break;
  }
  if (std::string(p.name) == "clamp_radiance") {
    return "0.125";  // the largest value limits no light of a test scene
  }
  const std::string most = std::to_string(std::lround(p.max));
  return by_default == most ? std::to_string(std::lround(p.min)) : most;
}

}  // namespace stillray::test
