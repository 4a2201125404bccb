// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Suggestions for misspelt names.
#pragma once

#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace stillray {

/// The number of edits that turn `a` into `b`: insertions, deletions, replacements and swaps of
/// neighbouring characters. Source: F. J. Damerau, "A technique for computer detection and
/// correction of spelling errors", 1964; as optimal string alignment: no part is edited twice.
int EditDistance(std::string_view a, std::string_view b);

/// ", did you mean sigma_l?" with the nearest names (up to three at equal distance), or an empty
/// string if all need more than one edit per three characters of the name. A name that starts with
/// `name` also counts as near.
std::string DidYouMean(std::string_view name, std::span<const std::string_view> names);

/// As above, for any container of names.
template <typename Names>
std::string DidYouMeanOneOf(std::string_view name, const Names& names) {
  const std::vector<std::string_view> views(std::begin(names), std::end(names));
  return DidYouMean(name, views);
}

}  // namespace stillray
