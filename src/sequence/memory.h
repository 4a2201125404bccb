// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Plans the memory of a sequence from the header of a file, before any allocation.
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

/// Checks that the memory limit allows one frame to be read and another to be written while a third
/// is filtered, all of this size.
/// \return kOutOfMemory, with need and limit
Status OverlapFits(const ExrExtent& extent, const SequenceOptions& options);

/// Whether, with Window::kBoth, the estimated motion of all frames that are linked more than once
/// fits into memory in addition to all other data.
bool MotionFits(const ExrExtent& extent, const SequenceOptions& options);
/// Number of frames that are linked more than once.
inline constexpr size_t kLinkedFrames = kFutureBlock + kLookAhead + 1;

/// Number of frames of this size whose future fits into the memory limit in addition to all other
/// data; 1..kFutureBlock.
/// \return kOutOfMemory if no frame fits
Result<size_t> FuturesThatFit(const ExrExtent& extent, const SequenceOptions& options,
                              const std::string& name);

/// Adds the memory of another denoiser on the same device.
void AddDeviceMemory(const DeviceMemory& memory, DeviceMemory* sum);

}  // namespace stillray
