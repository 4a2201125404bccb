// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The colour scale of views that show numbers.
#pragma once

#include <vector>

namespace stillray::view {

/// The range of a colour scale: 0 to `top`.
struct ViewRange {
  float top = 0;             ///< the value of the last colour; 0: the view has no scale
  bool logarithmic = false;  ///< colours follow log(1 + value); else the value
  bool motion = false;       ///< brightness with a hue for the direction; else the heat scale
  const char* unit = "";     ///< of the values

  /// Position of a value >= 0 on the scale; 1 and more: at its end.
  float At(float value) const;
};

/// The smallest power of two that at most one finite value in a hundred exceeds, at least 1/4096:
/// the scale follows the picture, but is stable under small changes.
/// \param values  >= 0 where finite; reordered
float FittedTop(std::vector<float>* values);

}  // namespace stillray::view
