// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "denoise/denoiser_state.h"
#include "stillray/status.h"

namespace stillray {

/// What histories may hold beside colour and moments.
struct HistoryKinds {
  bool compressed = false;  ///< limit_history is on
  bool behind = false;      ///< feedback is blended in
};

/// The state as bytes: a header (magic, version, sizes, flags), then all planes row by row, in the
/// byte order of the machine. Equal states give equal bytes.
std::vector<uint8_t> HistoryToBytes(const DenoiserState& state);

/// \param least, most    signals that the history may have: those of frames without and with
///                       transmission
/// \param kinds         what the settings keep beside colour and moments
/// \param border        border of the guides
/// \return kBadData saying what does not fit
Result<DenoiserState> HistoryFromBytes(std::span<const uint8_t> bytes, size_t least, size_t most,
                                       const HistoryKinds& kinds, int border);

}  // namespace stillray
