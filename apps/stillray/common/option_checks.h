// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Validators of options. Their messages contain the actual value and the expected values, like the
/// messages of CheckNumbers: "--fps: found '0', expected 0.001 to 1000".
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "core/nearest_names.h"

namespace stillray {

/// Accepts numbers in low..high, inclusive.
inline CLI::Validator InRange(double low, double high) {
  const auto check = [low, high](std::string& text) {
    double number = 0;
    const bool inside = CLI::detail::lexical_cast(text, number) && number >= low && number <= high;
    return inside ? std::string() : fmt::format("found '{}', expected {} to {}", text, low, high);
  };
  return CLI::Validator(check, "");
}

/// Accepts one of two or more names. The validator's name lists them, for shell completion.
inline CLI::Validator OneOf(std::vector<std::string> names) {
  const std::string list = fmt::format("{}", fmt::join(names, "|"));
  const auto check = [names = std::move(names)](std::string& text) {
    if (std::find(names.begin(), names.end(), text) != names.end()) {
      return std::string();
    }
    return fmt::format("found '{}', expected {} or {}{}", text,
                       fmt::join(names.begin(), names.end() - 1, ", "), names.back(),
                       DidYouMeanOneOf(text, names));
  };
  return CLI::Validator(check, "", list);
}

}  // namespace stillray
