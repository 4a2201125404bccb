// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The order of the stages on the CPU.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "denoise/cpu/frame_work.h"
#include "denoise/cpu/fused/fused.h"
#include "denoise/cpu/history.h"
#include "denoise/plan.h"
#include "denoise/stage_table.h"

namespace stillray {

/// Arguments common to all stages of a frame.
struct CpuPipeline {
  const StageTable& stages;
  const FramePlan& plan;
  const Fusion fusion;
  const std::vector<std::string>& outputs;  ///< full names of outputs
};

/// \param future   one history per signal if the plan runs merge_future
/// \param history  [in,out] of the previous frame; updated to this frame, except `progress`
/// \param colour   receives the output image, of the frame's size; nullptr: it is only stored in
///     History::picture
/// \param out      receives everything except `colour`, `display` and `shared`
void RunFrame(const CpuPipeline& pipeline, const Frame& frame,
              std::span<const SignalHistory> future, History* history, FrameWork* work,
              Image3* colour, DenoisedFrame* out);

/// A frame of a sequence that is processed backward: its radiance is accumulated, and no image is
/// made.
/// \param future  receives the history of the later frames, one per signal
void RunBackward(const CpuPipeline& pipeline, const Frame& frame, History* history, FrameWork* work,
                 std::vector<SignalHistory>* future);

}  // namespace stillray
