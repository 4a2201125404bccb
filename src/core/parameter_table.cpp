// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_table.h"

#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "core/nearest_names.h"

namespace stillray {
namespace {

/// Whether the text is a number that rounds to 0 as a float.
bool IsTooSmall(std::string_view text) {
  float as_float = 0;
  double as_double = 0;
  const char* end = text.data() + text.size();
  const auto narrow = std::from_chars(text.data(), end, as_float);
  const auto wide = std::from_chars(text.data(), end, as_double);
  return narrow.ec == std::errc::result_out_of_range && wide.ec == std::errc() && wide.ptr == end &&
         std::abs(as_double) < 1;
}

}  // namespace

bool ParseInRange(std::string_view text, const Parameter& info, float* out) {
  float number = 0;
  if (!ParseNumber(text, &number) ||
      !(number >= static_cast<float>(info.min) && number <= static_cast<float>(info.max))) {
    return false;
  }
  *out = number;
  return true;
}

bool ParseInRange(std::string_view text, const Parameter& info, int* out) {
  int number = 0;
  if (!ParseNumber(text, &number) || number < info.min || number > info.max) {
    return false;
  }
  *out = number;
  return true;
}

bool ParseFlag(std::string_view text, bool* out) {
  const bool on = text == "on" || text == "true" || text == "1";
  const bool off = text == "off" || text == "false" || text == "0";
  *out = on || (!off && *out);
  return on || off;
}

int FindChoice(std::string_view text, const Parameter& info) {
  for (size_t i = 0; i < info.choices.size(); ++i) {
    if (text == info.choices[i]) {
      return static_cast<int>(i);
    }
  }
  bool on = false;
  const std::string_view name = !ParseFlag(text, &on) ? "" : on ? "on" : "off";
  return !name.empty() && name != text ? FindChoice(name, info) : -1;
}

std::string NumberText(float value) {
  return fmt::format("{}", value);
}

std::string ChoiceText(int value, const Parameter& info) {
  const bool known = value >= 0 && value < static_cast<int>(info.choices.size());
  return known ? info.choices[static_cast<size_t>(value)] : fmt::format("{}", value);
}

std::string ExpectedText(const Parameter& info) {
  switch (info.type) {
    case ParameterType::kFlag:
      return "on or off";
    case ParameterType::kChoice:
      return info.choices.size() == 2 ? fmt::format("{} or {}", info.choices[0], info.choices[1])
                                      : fmt::format("one of {}", fmt::join(info.choices, ", "));
    case ParameterType::kInt:
      return fmt::format("a whole number from {} to {}", info.min, info.max);
    case ParameterType::kSeed:
      return fmt::format("a whole number from 0 to {}", std::numeric_limits<uint64_t>::max());
    default:
      return fmt::format("a number from {} to {}", info.min, info.max);
  }
}

std::string BadValueText(const Parameter& info, std::string_view value,
                         const std::string& expected) {
  if (info.type == ParameterType::kFloat && IsTooSmall(value)) {
    return fmt::format("is '{}', which is too near to 0 for a 32-bit float", value);
  }
  const bool named = info.type == ParameterType::kChoice;
  return fmt::format("is '{}', expected {}{}", value, expected,
                     named ? DidYouMeanOneOf(value, info.choices) : "");
}

Status SplitAssignment(std::string_view text, std::string_view* name, std::string_view* value) {
  constexpr size_t kMostShown = 80;
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return Status::InvalidArgument(
        fmt::format("'{}' has no '=', expected name=value", text.substr(0, kMostShown)));
  }
  *name = text.substr(0, equals);
  *value = text.substr(equals + 1);
  return Status::Ok();
}

std::string DidYouMean(std::string_view name, std::span<const Parameter> rows) {
  std::vector<std::string_view> names;
  for (const Parameter& row : rows) {
    names.push_back(row.name);
  }
  return DidYouMean(name, names);
}

}  // namespace stillray
