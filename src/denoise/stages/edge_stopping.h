// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Parameters of the edge-stopping weights, common to the stages that use them.
#pragma once

namespace stillray {

/// See edge_stopping_shared.h for the formulas.
struct EdgeStopping {
  float sigma_n = 128;
  bool plane = true;  ///< depth by distance from the plane at p; else by the slope
  float sigma_z = 1;
  float plane_tolerance = 0.01f;
  float depth_epsilon = 0.001f;
  float max_slope = 0;
};

}  // namespace stillray
