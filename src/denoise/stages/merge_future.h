// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// merge_future: where the whole sequence is known, the signal accumulated backward from its end is
/// merged with the signal accumulated forward, each weighted by its inverse variance. Source: none;
/// the papers use past frames only. The forward history itself contains no later frames, so that no
/// sample counts twice. Pixel by pixel, in place allowed. Reads 56, writes 28 bytes per pixel.
#pragma once

#include "denoise/planes.h"

namespace stillray {

/// \param history  past and present
/// \param future   history of the later frames at this frame's pixels, this frame not included;
///                 already shortened where it differs from the present
/// \param out      colour, moments, length, weights2 of the merged history; `compressed` is not
///     written
namespace reference {
void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out);
}
namespace cpu {
void MergeFuture(const SignalHistory& history, const SignalHistory& future, SignalHistory* out);
}

}  // namespace stillray
