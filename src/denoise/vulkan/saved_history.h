// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The history of a denoiser on Vulkan as bytes: a header, the state buffer, then the texels of all
/// images that the next frame reads, in their storage format. The next frame is therefore
/// bit-identical to that without saving.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "denoise/vulkan/frame_pipeline.h"

namespace stillray::vulkan {

/// The content of saved bytes.
struct SavedHistory {
  int width = 0;
  int height = 0;
  bool transmission = false;
  SequenceProgress progress;
  FillGuidesPass::Kinds held;
  std::span<const uint8_t> state_and_texels;  ///< a view of the bytes
};

/// \param pipeline  nullptr: no history yet
/// \return errors of the device
Result<std::vector<uint8_t>> SaveHistory(gpu::Device* device, FramePipeline* pipeline);

/// \return kBadData naming the damage, or the mismatch with settings and storage
Result<SavedHistory> ReadSavedHistory(std::span<const uint8_t> bytes, const Settings& settings,
                                      Storage storage);

/// \param pipeline  must have the saved size and the settings passed to ReadSavedHistory; has no
///     history if this function fails
/// \return errors of the device
Status RestoreHistory(gpu::Device* device, const SavedHistory& saved, FramePipeline* pipeline);

}  // namespace stillray::vulkan
