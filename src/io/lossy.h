// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Artefacts of lossy compression in EXR files.
#pragma once

#include "stillray/io.h"

namespace stillray::io {

/// Whether a channel was stored with visible loss: with DWAA and DWAB the channels R, G, B, Y, RY
/// and BY, with B44 and B44A halves. PXR24 keeps more bits of a float than a half has.
bool IsLossy(const ExrImage& image, const Channel& channel);

/// Lossy compression rings around bright pixels: negative values down to this fraction of the
/// largest value nearby are artefacts. (Black pixels beside bright ones, measured: DWAA and DWAB at
/// their default level 0.6 %, B44 and B44A 0.3 %.)
inline constexpr float kRinging = 0.02f;

/// Sets light to zero where it is negative and within kRinging of the brightest value of the same
/// and the eight neighbouring blocks of 8x8 pixels, which covers the blocks of all codecs. A
/// firefly does not hide negative radiance elsewhere.
void RemoveRinging(Image3* light);

}  // namespace stillray::io
