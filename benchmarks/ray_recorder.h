// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Records the rays of an Accel.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "benchmarks/ray_bench.h"
#include "render/accel.h"

namespace stillray::render {

/// Rays of one phase, batch after batch.
struct RayLog {
  struct Batch {
    size_t first = 0;
    int count = 0;
  };
  std::vector<Batch> batches;
  /// Origin x, y, z, direction x, y, z and end of all rays, padded by a packet.
  std::array<std::vector<float>, 7> values;

  size_t count() const { return batches.empty() ? 0 : batches.back().first + batches.back().count; }
};

using RayLogs = std::array<RayLog, kRayPhaseCount>;

/// An Accel that forwards all calls to `inner` and records the rays in `logs`, which must outlive
/// it. Not thread-safe.
std::unique_ptr<Accel> MakeRecordingAccel(std::unique_ptr<Accel> inner, RayLogs* logs);

}  // namespace stillray::render
