// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The layout of the window, in pixels.
#pragma once

#include <algorithm>

namespace stillray::view {

struct Rect {
  float x = 0;
  float y = 0;
  float width = 0;
  float height = 0;
};

struct Layout {
  Rect picture;
  Rect panel;
  Rect bar;
};

/// \param width, height  size of the window
/// \param menu_height    height of the menu bar
/// \param line_height    height of a line of text with its frame
/// \param font_size      font size in pixels, which determines the width of the panel at any
///     display scaling; the panel is never wider than the image
inline Layout MakeLayout(float width, float height, float menu_height, float line_height,
                         float font_size, bool show_panel) {
  const float wanted = std::clamp(width * 0.29f, 22 * font_size, 30 * font_size);
  const float panel = show_panel ? std::min(wanted, width / 2) : 0;
  const float bar = line_height + 14;
  Layout layout;
  layout.picture = {0, menu_height, std::max(width - panel, 16.0f),
                    std::max(height - menu_height - bar, 16.0f)};
  layout.panel = {width - panel, menu_height, panel, std::max(height - menu_height, 16.0f)};
  layout.bar = {0, height - bar, std::max(width - panel, 16.0f), bar};
  return layout;
}

}  // namespace stillray::view
