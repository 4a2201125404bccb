// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The history of a denoiser on Vulkan as bytes: a header, the state that lies in a buffer, then
/// the texels of all images that the next frame reads, as they are stored. So the next frame has
/// the same bits as if nothing had come between.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "denoise/vulkan/frame_pipeline.h"

namespace stillray::vulkan {

/// What saved bytes hold.
struct SavedHistory {
  int width = 0;
  int height = 0;
  bool transmission = false;
  SequenceProgress progress;
  FillGuidesPass::Kinds held;
  std::span<const uint8_t> state_and_texels;  ///< of the bytes that were read
};

/// \param pipeline  nullptr: there is no history yet
/// \return what failed on the device
Result<std::vector<uint8_t>> SaveHistory(gpu::Device* device, FramePipeline* pipeline);

/// \return kBadData saying what is damaged or does not fit to settings and storage
Result<SavedHistory> ReadSavedHistory(std::span<const uint8_t> bytes, const Settings& settings,
                                      Storage storage);

/// \param pipeline  of the saved size and the settings that the history was checked with; has no
///                  history if this fails
/// \return what failed on the device
Status RestoreHistory(gpu::Device* device, const SavedHistory& saved, FramePipeline* pipeline);

}  // namespace stillray::vulkan
