// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Palette PNG files in memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stillray/status.h"

namespace stillray::report {

using Rgb8 = std::array<uint8_t, 3>;

/// The bytes of a PNG file with one palette index per pixel, rows from the top.
/// \param indices  width * height, each below 256
/// \return kInternal if the library fails
Result<std::string> EncodePalettePng(int width, int height, const std::vector<uint8_t>& indices,
                                     const std::array<Rgb8, 256>& palette);

}  // namespace stillray::report
