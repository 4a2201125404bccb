// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What lossy compression of EXR files leaves behind.
#pragma once

#include "stillray/io.h"

namespace stillray::io {

/// Whether a channel was stored with a loss that shows: with DWAA and DWAB those that are called R,
/// G, B, Y, RY or BY, with B44 and B44A halves. PXR24 keeps more bits of a float than a half has.
bool IsLossy(const ExrImage& image, const Channel& channel);

/// Lossy compression rings around bright pixels: negative values down to this part of the largest
/// one nearby are its doing. (Black pixels beside bright ones, measured: DWAA and DWAB at their
/// default level 0.6 %, B44 and B44A 0.3 %.)
inline constexpr float kRinging = 0.02f;

/// Makes light zero where it is negative and within kRinging of the brightest value of the same and
/// the eight neighbouring blocks of 8x8 pixels, farther than the blocks of any codec reach. A
/// firefly hides no negative light elsewhere.
void RemoveRinging(Image3* light);

}  // namespace stillray::io
