// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// merge_future: where the whole sequence is known, light accumulated from its end backward is
/// merged with that accumulated forward, each by the inverse of its noise. Ours; the papers only
/// look back. The forward history itself stays free of the future, so that no sample counts twice.
/// Pixel by pixel, in place allowed. Reads 56, writes 28 bytes per pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// \param history  past and present
/// \param future   light of later frames at this frame's pixels, this frame's own not included;
///                 already shortened where it does not resemble the present
/// \param out      colour, moments, length, weights2 of all together; `compressed` stays as it is
namespace reference {
void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out);
}
namespace cpu {
void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out);
}

}  // namespace stillray
