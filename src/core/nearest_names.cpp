// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/nearest_names.h"

#include <algorithm>
#include <vector>

namespace stillray {
namespace {

constexpr size_t kMostShown = 3;
/// Longer names are not typing errors, and the comparison is quadratic.
constexpr size_t kLongestName = 64;
constexpr size_t kShortestBeginning = 3;

/// Maximum number of edits to a near name, for a name of this length.
int MostEdits(size_t length) {
  return std::max(1, static_cast<int>(length) / 3);
}

int Distance(std::string_view name, std::string_view known) {
  const bool begins = name.size() >= kShortestBeginning && known.substr(0, name.size()) == name;
  return begins ? 1 : EditDistance(name, known);
}

}  // namespace

int EditDistance(std::string_view a, std::string_view b) {
  const size_t columns = b.size() + 1;
  // Rows i - 2, i - 1 and i of the table of distances between prefixes of a and b.
  std::vector<int> before(columns), last(columns), row(columns);
  for (size_t j = 0; j < columns; ++j) {
    last[j] = static_cast<int>(j);
  }
  for (size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j < columns; ++j) {
      const int replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last.back();
}

std::string DidYouMean(std::string_view name, std::span<const std::string_view> names) {
  if (name.empty() || name.size() > kLongestName) {
    return {};
  }
  int least = MostEdits(name.size());
  std::vector<std::string_view> nearest;
  for (const std::string_view known : names) {
    const int distance = Distance(name, known);
    if (distance < least) {
      nearest.clear();
      least = distance;
    }
    if (distance == least && nearest.size() < kMostShown) {
      nearest.push_back(known);
    }
  }
  std::string text;
  for (size_t i = 0; i < nearest.size(); ++i) {
    text += i == 0 ? ", did you mean " : i + 1 < nearest.size() ? ", " : " or ";
    text += nearest[i];
  }
  return text.empty() ? text : text + "?";
}

}  // namespace stillray
