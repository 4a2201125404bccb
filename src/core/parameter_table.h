// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Conversion of the members of a settings struct to and from text, by their rows in a table.
/// Numbers are decimal, flags on/off/true/false/1/0, choices their names.
#pragma once

#include <charconv>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "stillray/parameter.h"
#include "stillray/status.h"

namespace stillray {

/// A member of any enumeration, by the number of its value.
template <typename S>
struct ChoiceMember {
  int (*get)(const S&);
  void (*set)(S*, int);
};

template <typename S, auto kMember>
ChoiceMember<S> Choice() {
  return {[](const S& s) { return static_cast<int>(s.*kMember); },
          [](S* s, int value) {
            using Enum = std::remove_reference_t<decltype(s->*kMember)>;
            s->*kMember = static_cast<Enum>(value);
          }};
}

/// A value with a syntax of its own.
template <typename S>
struct TextMember {
  std::string (*get)(const S&);
  /// \return false if the text is invalid; the struct is then unchanged
  bool (*set)(S*, std::string_view text, const Parameter&);
  std::string (*expected)(const Parameter&);
};

template <typename S>
using ParameterMember =
    std::variant<float S::*, int S::*, bool S::*, uint64_t S::*, ChoiceMember<S>, TextMember<S>>;

template <typename T>
bool ParseNumber(std::string_view text, T* out) {
  T number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) {
    return false;
  }
  *out = number;
  return true;
}

/// As ParseNumber, within the range of the row. NaN is out of range.
bool ParseInRange(std::string_view text, const Parameter& info, float* out);
bool ParseInRange(std::string_view text, const Parameter& info, int* out);
bool ParseFlag(std::string_view text, bool* out);
/// The spellings of flags are accepted for choices named on and off, so that a flag can become a
/// choice later.
/// \return -1 if there is no such choice
int FindChoice(std::string_view text, const Parameter& info);

std::string NumberText(float value);
/// The name of a choice; for an invalid index, the number as text.
std::string ChoiceText(int value, const Parameter& info);

/// The declarations of all rows of a table, for listings. \tparam Rows  of structs with `info`
template <typename Rows>
std::vector<Parameter> InfosOf(const Rows& rows) {
  std::vector<Parameter> infos;
  for (const auto& row : rows) {
    infos.push_back(row.info);
  }
  return infos;
}

/// "a number from 0 to 1", "on or off", ...; not for rows of a TextMember.
std::string ExpectedText(const Parameter& info);
/// "is 'VALUE', expected ...", to be appended to the name.
std::string BadValueText(const Parameter& info, std::string_view value,
                         const std::string& expected);
/// The parts of "name=value". \return kInvalidArgument with the text if it has no '='
Status SplitAssignment(std::string_view text, std::string_view* name, std::string_view* value);
/// ", did you mean sigma_l?" or nothing.
std::string DidYouMean(std::string_view name, std::span<const Parameter> rows);

template <typename S>
bool SetMember(const Parameter& info, const ParameterMember<S>& member, std::string_view text,
               S* settings) {
  struct Setter {
    const Parameter& info;
    std::string_view text;
    S* settings;

    bool operator()(float S::*m) const { return ParseInRange(text, info, &(settings->*m)); }
    bool operator()(int S::*m) const { return ParseInRange(text, info, &(settings->*m)); }
    bool operator()(bool S::*m) const { return ParseFlag(text, &(settings->*m)); }
    bool operator()(uint64_t S::*m) const { return ParseNumber(text, &(settings->*m)); }
    bool operator()(const ChoiceMember<S>& m) const {
      const int value = FindChoice(text, info);
      if (value >= 0) {
        m.set(settings, value);
      }
      return value >= 0;
    }
    bool operator()(const TextMember<S>& m) const { return m.set(settings, text, info); }
  };
  return std::visit(Setter{info, text, settings}, member);
}

/// Text that SetMember reads back to the same bits.
template <typename S>
std::string GetMember(const Parameter& info, const ParameterMember<S>& member, const S& settings) {
  struct Getter {
    const Parameter& info;
    const S& settings;

    std::string operator()(float S::*m) const { return NumberText(settings.*m); }
    std::string operator()(int S::*m) const { return std::to_string(settings.*m); }
    std::string operator()(bool S::*m) const { return settings.*m ? "on" : "off"; }
    std::string operator()(uint64_t S::*m) const { return std::to_string(settings.*m); }
    std::string operator()(const ChoiceMember<S>& m) const {
      return ChoiceText(m.get(settings), info);
    }
    std::string operator()(const TextMember<S>& m) const { return m.get(settings); }
  };
  return std::visit(Getter{info, settings}, member);
}

/// See BadValueText.
template <typename S>
std::string BadMemberText(const Parameter& info, const ParameterMember<S>& member,
                          std::string_view text) {
  const auto* notation = std::get_if<TextMember<S>>(&member);
  return BadValueText(info, text, notation ? notation->expected(info) : ExpectedText(info));
}

}  // namespace stillray
