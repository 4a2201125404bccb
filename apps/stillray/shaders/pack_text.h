// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// README.md of a shader pack: the content of its JSON files as text.
#pragma once

#include <string>

#include "denoise/shader_pack.h"

namespace stillray {

std::string PackText(const ShaderTable& table, const FrameSchedule& schedule,
                     const ScheduleOptions& options, const std::string& preset);

}  // namespace stillray
