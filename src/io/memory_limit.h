// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// What does not fit into memory is refused before it is tried.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "stillray/aov.h"

namespace stillray {

/// Bytes that this process may use: the machine's memory, or the limit on its address space where
/// that is less. 0: unknown.
int64_t AvailableMemory();

/// Memory that a command takes for one EXR file, measured and rounded up; the work of its largest
/// step included.
struct ExrCost {
  int64_t bytes_per_pixel = 0;
  int64_t bytes_per_channel = 0;  ///< and pixel
};

/// \param bytes  of the file
/// \return kOutOfMemory naming file, size, and what it takes; kBadData: the header is damaged
Status CheckExrFits(std::string_view bytes, const std::string& name, const ExrCost& cost);

}  // namespace stillray
