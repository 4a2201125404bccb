// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Small widgets of the panels: a name on the left, its control on the right.
#pragma once

namespace stillray::view {

/// Writes the name and extends the next control over the rest of the line.
void LabelFor(const char* name);
/// "(?)" with a tooltip; on the same line.
void HelpMark(const char* text);
/// \param unit  shown behind the value; "" if it has none
/// \return whether the value changed
bool LabelledSlider(const char* name, const char* unit, float* value, float min, float max,
                    const char* format);
bool LabelledCombo(const char* name, int* chosen, const char* const* names, int count);

}  // namespace stillray::view
