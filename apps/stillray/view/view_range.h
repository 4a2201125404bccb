// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The colour scale of views of scalar values.
#pragma once

#include <vector>

namespace stillray::view {

/// The range of a colour scale: 0 to `top`.
struct ViewRange {
  float top = 0;             ///< the value of the last colour; 0: the view has no scale
  bool logarithmic = false;  ///< colours follow log(1 + value) instead of the value
  bool motion = false;       ///< motion colours (hue for the direction) instead of the heat map
  const char* unit = "";     ///< unit of the values

  /// Position of a value >= 0 on the scale; 1 or more at its end.
  float At(float value) const;
};

/// The smallest power of two, at least 1/4096, that is exceeded by at most 1% of the finite values:
/// the scale adapts to the image, but is stable under small changes.
/// \param values  >= 0 where finite; reordered
float FittedTop(std::vector<float>* values);

}  // namespace stillray::view
