// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Settings as a small text file: `name=value` lines with the names of --set, `preset=NAME` before
/// them, and `render.spp`, `render.guides`, `render.bounces`, `render.sampler`, `render.regularise`
/// for the path tracer. Lines that start with '#' and empty ones do not count.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stillray/denoise.hpp"

namespace stillray {

/// What of the path tracer a file may set, as text that the command line takes too.
struct RenderLines {
  std::optional<std::string> spp;      ///< "4", "1/8"
  std::optional<std::string> guides;   ///< "full", "sparse"
  std::optional<int> bounces;          ///< 1..32
  std::optional<std::string> sampler;  ///< "sobol", "halton16"
  std::optional<bool> regularise;
};

struct SettingsFile {
  std::string preset = "default";
  Settings denoise;
  RenderLines render;
};

/// \return kNotFound, kIo, kUnsupported (far too large); kBadData naming file, line, what stands
///         there and what was expected
Result<SettingsFile> ReadSettingsFile(const std::string& path);
/// The same from memory; `name` stands for the path in messages. Safe on any bytes.
Result<SettingsFile> ParseSettingsFile(std::string_view text, const std::string& name);

/// A settings file as the options that say the same: the preset, and what it changes of it, put
/// before what is in `set`. Errors as ReadSettingsFile.
Status SettingsFileAsOptions(const std::string& path, std::string* preset,
                             std::vector<std::string>* set, RenderLines* render);

/// Text that reads back to the same settings: the preset, and what differs from it.
/// \return kInvalidArgument if there is no such preset or the settings are not valid
Result<std::string> FormatSettingsFile(const SettingsFile& settings);
Status WriteSettingsFile(const std::string& path, const SettingsFile& settings);

}  // namespace stillray
