// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The scale of views that show numbers as colours.
#pragma once

#include <vector>

namespace stillray::view {

/// What the ends of a colour scale stand for: 0 and `top`.
struct ViewRange {
  float top = 0;             ///< the value of the last colour; 0: the view has no such scale
  bool logarithmic = false;  ///< colours go with log(1 + value); else with the value
  bool motion = false;       ///< brightness with a hue for the direction; else the heat scale
  const char* unit = "";     ///< of the values

  /// Where a value >= 0 lies on the scale; 1 and more: at its end.
  float At(float value) const;
};

/// The smallest power of two that only one finite value in a hundred exceeds, at least 1/4096: the
/// scale follows the picture, and stays where it is while little changes.
/// \param values  >= 0 where finite; their order is changed
float FittedTop(std::vector<float>* values);

}  // namespace stillray::view
