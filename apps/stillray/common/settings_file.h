// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Settings as a small text file: `name=value` lines with the names of --set, `preset=NAME` before
/// them, and `render.NAME=VALUE` with the names of RenderParameters(). Empty lines and lines that
/// start with '#' are ignored.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "stillray/denoise.hpp"
#include "stillray/render.h"

namespace stillray {

/// A parameter of RenderParameters() and its value as text.
struct RenderLine {
  std::string name;
  std::string value;
};
using RenderLines = std::vector<RenderLine>;

struct SettingsFile {
  std::string preset = "default";
  Settings denoise;
  RenderLines render;  ///< valid, in the order of the file
};

/// \return kNotFound, kIo, kUnsupported (far too large); kBadData naming file, line, the actual and
///     the expected text
Result<SettingsFile> ReadSettingsFile(const std::string& path);
/// Parses a settings file in memory; `name` is used as the path in messages. Safe on any bytes.
Result<SettingsFile> ParseSettingsFile(std::string_view text, const std::string& name);

/// \return kInvalidArgument naming the first invalid line
Status ApplyRenderLines(const RenderLines& lines, RenderSettings* settings);

/// Names of the denoiser's parameters that differ from the preset.
/// \return kInvalidArgument if the preset does not exist or the settings are invalid
Result<std::vector<std::string>> ChangedParameters(const SettingsFile& settings);

/// Text that is parsed to the same settings: the preset, and the changes to it.
/// \return kInvalidArgument if the preset does not exist or the settings are invalid
Result<std::string> FormatSettingsFile(const SettingsFile& settings);
Status WriteSettingsFile(const std::string& path, const SettingsFile& settings);

}  // namespace stillray
