// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The denoisers of one sequence: forward, backward for the future, and those of light passes and
/// alpha. Their histories restart together at cuts and gaps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sequence/alpha.h"
#include "sequence/frames.h"
#include "sequence/future.h"
#include "sequence/passes.h"
#include "stillray/denoise.hpp"
#include "stillray/sequence.h"

namespace stillray {

class SequenceFilter {
 public:
  /// \param view, settings  the objects referred to must outlive the filter
  SequenceFilter(const SequenceView& view, const Settings& settings)
      : view_(view), settings_(settings) {}

  /// Creates the denoisers, all on one device.
  /// \param held  number of frames whose future is held at once; only for Window::kBoth with
  ///     history
  /// \param ahead, step  see FuturePass
  Status Prepare(const Device& device, size_t held, bool ahead, FuturePass::Step step);

  /// Denoises frame options.files[at]. The history is dropped after a gap in the numbers and at a
  /// cut.
  /// \param frame   [in,out] motion is completed; parts are moved from
  /// \param report  its name is used in messages; receives the results
  /// \param layers  [out] light layers with SequenceOptions::passes, alpha with denoise_alpha
  Status Filter(SequenceFrame* frame, size_t at, FrameReport* report, Image3* colour,
                std::vector<NewLayer>* layers);

  /// Sets the predecessor of the next frame; only its guides are kept.
  void SetPrevious(SequenceFrame frame);
  /// Sets the predecessor from a frame as read, whose radiance is already in the history.
  void Skip(SequenceFrame frame);

  /// Number of files whose radiance is in the history.
  size_t frames() const { return frames_; }
  /// The histories of all denoisers.
  Result<std::vector<uint8_t>> SaveHistory() const;
  /// \param frames  number of files whose radiance is in the history
  /// \param name    of the file of the history, for messages
  /// \return kBadData
  Status RestoreHistory(std::span<const uint8_t> bytes, size_t frames, const std::string& name);

  bool has_future() const { return future_.has_value(); }
  bool motion_was_seen() const { return motion_was_seen_; }
  /// Why frames are filtered on the CPU instead; see Denoiser::remark().
  const std::string& remark() const;
  size_t memory_bytes() const;
  DeviceMemory device_memory() const;  ///< the part of memory_bytes() on a device

 private:
  Link LinkFrame(SequenceFrame* frame, FrameReport* report);
  std::string NoteOf(Link link, const Frame& frame) const;

  SequenceView view_;
  const Settings& settings_;
  std::optional<Denoiser> denoiser_;
  std::optional<PassSplitter> splitter_;
  std::optional<AlphaFilter> alpha_;
  std::optional<FuturePass> future_;
  std::optional<SequenceFrame> previous_;  ///< guides only
  DenoisedFrame denoised_;
  size_t frames_ = 0;
  bool motion_was_seen_ = false;
};

}  // namespace stillray
