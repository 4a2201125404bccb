// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Plans the memory of a sequence from the header of a file, before any of it is allocated.
#pragma once

#include <cstddef>
#include <string>

#include "denoise/future_blocks.h"
#include "stillray/aov.h"
#include "stillray/sequence.h"

namespace stillray {

/// \return kOutOfMemory, with need and limit, if a frame of this size does not fit into
///         options.memory
Status CheckMemory(const ExrExtent& extent, const SequenceOptions& options,
                   const std::string& name);

/// Checks that one frame can be read and another written while a third of this size is filtered,
/// within the memory limit.
/// \return kOutOfMemory, with need and limit
Status OverlapFits(const ExrExtent& extent, const SequenceOptions& options);

/// Whether the estimated motion of all frames that are linked more than once fits in addition to
/// all other data, with Window::kBoth.
bool MotionFits(const ExrExtent& extent, const SequenceOptions& options);
/// Number of those frames.
inline constexpr size_t kLinkedFrames = kFutureBlock + kLookAhead + 1;

/// Number of frames of this size whose future fits into the memory limit in addition to all other
/// data; 1..kFutureBlock.
/// \return kOutOfMemory if not even one fits
Result<size_t> FuturesThatFit(const ExrExtent& extent, const SequenceOptions& options,
                              const std::string& name);

/// Adds the memory of another denoiser on the same device.
void AddDeviceMemory(const DeviceMemory& memory, DeviceMemory* sum);

}  // namespace stillray
