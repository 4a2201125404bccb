// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The name that was meant by one that is not known.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace stillray {

/// Edits that make `a` of `b`: a character inserted, left out, replaced, or two neighbours swapped.
/// Source: F. J. Damerau, "A technique for computer detection and correction of spelling errors",
/// 1964; as optimal string alignment: no part is edited twice.
int EditDistance(std::string_view a, std::string_view b);

/// ", did you mean sigma_l?" with the nearest of the names (up to three as near as each other), or
/// nothing if all are far: more than one edit for three characters of the name. A name of which
/// `name` is the beginning is near as well.
std::string DidYouMean(std::string_view name, std::span<const std::string_view> names);

}  // namespace stillray
