// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// shaders.json and frames.json of a shader pack, see docs/gpu.md.
#pragma once

#include <nlohmann/json.hpp>

#include "denoise/shader_pack.h"

namespace stillray {

nlohmann::ordered_json TableJson(const ShaderTable& table);

/// \param settings  settings as text, to reproduce the pack
nlohmann::ordered_json ScheduleJson(const FrameSchedule& schedule, const ScheduleOptions& options,
                                    const ShaderTable& table, const std::string& preset);

}  // namespace stillray
