// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Rejects files that do not fit into memory before they are decoded.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "stillray/aov.h"

namespace stillray {

/// Bytes available to this process: the machine's memory, or the limit on its address space if that
/// is lower. 0: unknown.
int64_t AvailableMemory();

/// Memory of a command for one EXR file, measured and rounded up, including its peak.
struct ExrCost {
  int64_t bytes_per_pixel = 0;
  int64_t bytes_per_channel = 0;  ///< and pixel
};

/// \param bytes  content of the file
/// \return kOutOfMemory naming file, size, and the memory needed; kBadData: the header is damaged
Status CheckExrFits(std::string_view bytes, const std::string& name, const ExrCost& cost);

}  // namespace stillray
