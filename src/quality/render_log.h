// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// render.json: the log that `stillray render` writes beside a sequence's images.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stillray/status.h"

namespace stillray::report {

struct RenderLogFrame {
  int64_t number = 0;
  std::optional<double> seconds;
  std::optional<double> render_ms;
  std::optional<double> denoise_ms;
  std::optional<double> write_ms;
  std::vector<std::pair<std::string, double>> stages_ms;  ///< in the file's order
};

/// The file's content in the file's order. Everything is optional.
struct RenderLog {
  std::string version;
  std::string scene;
  std::string preset;
  std::string tonemap;
  double exposure = 0;  ///< stops
  std::optional<int> width;
  std::optional<int> height;
  std::optional<double> fps;
  /// All scalar settings of the top level as text, including those above.
  std::vector<std::pair<std::string, std::string>> settings;
  std::vector<std::pair<std::string, std::string>> parameters;
  std::vector<RenderLogFrame> frames;
  std::vector<std::pair<std::string, int64_t>> memory;  ///< bytes
};

/// Parses the text of a render.json.
/// \param name  the file's name, for messages
/// \return kBadData naming the line (damaged JSON) or the key (unknown, repeated, of the wrong type
///     or out of range), with the value found and the value expected
Result<RenderLog> ParseRenderLog(const std::string& text, const std::string& name);

}  // namespace stillray::report
