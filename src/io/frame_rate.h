// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// The range of frame rates, common to sequences, videos, logs and reports.
#pragma once

namespace stillray {

inline constexpr double kMinFps = 0.001;  ///< one frame in 17 minutes
inline constexpr double kMaxFps = 1000;

}  // namespace stillray
