// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "denoise/cpu/history.h"
#include "stillray/denoise.hpp"
#include "stillray/status.h"

namespace stillray {

/// Magic numbers of saved histories, of the CPU and of other devices.
inline constexpr char kHistoryMagic[8] = {'s', 't', 'i', 'l', 'l', 'r', 'a', 'y'};
inline constexpr char kDeviceHistoryMagic[8] = {'s', 't', 'i', 'l', 'l', 'g', 'p', 'u'};
inline constexpr uint32_t kHistoryByteOrder = 0x01020304;

/// Properties of the history that settings require.
struct KeptHistory {
  size_t least = 1;  ///< signals of frames without transmission
  size_t most = 1;   ///< signals of frames with transmission
  HistoryLayout layout;
  bool by_channel = false;  ///< each signal is one channel of colour
};
KeptHistory KeptBy(const Settings& settings);

/// The fields of a saved history's header, not yet validated.
struct HistoryClaims {
  int32_t width = 0;
  int32_t height = 0;
  size_t signals = 0;
  HistoryLayout layout;
  float feedback_progress = 0;
  bool by_channel = false;
};

/// \return kBadData naming the field that is out of range or does not match the settings
Status CheckClaims(const HistoryClaims& claims, const KeptHistory& kept);

/// \return kBadData if the saved history and this denoiser store normals in different formats
Status CheckNormals(bool saved_octahedral, bool octahedral);

/// Whether the bytes start with the magic number of HistoryToBytes.
bool IsHistoryOfCpu(std::span<const uint8_t> bytes);

/// The state as bytes: a header (magic, version, sizes, flags, checksum), then all planes row by
/// row, in the byte order of the machine. Equal states give equal bytes.
std::vector<uint8_t> HistoryToBytes(const History& state);

/// \return kBadData naming the mismatch or damage
Result<History> HistoryFromBytes(std::span<const uint8_t> bytes, const Settings& settings);

}  // namespace stillray
