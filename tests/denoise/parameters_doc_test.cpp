// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// docs/parameters.md is generated from the parameter table. STILLRAY_UPDATE_DOCS=1 updates it.
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "stillray/denoise.hpp"

namespace stillray::parameters_doc_test {
namespace {

std::string Range(const Parameter& p) {
  switch (p.type) {
    case ParameterType::kFlag:
      return "on, off";
    case ParameterType::kChoice:
      return fmt::format("{}", fmt::join(p.choices, ", "));
    case ParameterType::kSteps:
      return fmt::format("up to {} of {} to {}", kMaxLevels, p.min, p.max);
    default:
      return fmt::format("{} to {}", p.min, p.max);
  }
}

std::string MakeDocument() {
  std::string text =
      "<!-- SPDX-FileCopyrightText: the stillray developers\n"
      "     SPDX-License-Identifier: Apache-2.0 -->\n"
      "# Parameters of the denoiser\n\n"
      "Made from the table in `src/denoise/settings.cpp`; a test keeps the two the same. Set them "
      "with\n`stillray render --set name=value`, or with `SetParameter` of "
      "`stillray/denoise.hpp`.\n"
      "[denoiser.md](denoiser.md) explains the stages.\n\n";
  std::string header = "| parameter | meaning | unit | values |";
  std::string rule = "|---|---|---|---|";
  for (const std::string_view preset : PresetNames()) {
    header += fmt::format(" `{}` |", preset);
    rule += "---|";
  }
  std::string group;
  for (const Parameter& p : Parameters()) {
    if (group != p.group) {
      group = p.group;
      text += fmt::format("## {}\n\n{}\n{}\n", group, header, rule);
    }
    const std::string symbol = *p.symbol != 0 ? fmt::format(" ({})", p.symbol) : "";
    const std::string resets =
        *p.resets_history != 0 ? fmt::format(" Restarts the history {}.", p.resets_history) : "";
    text += fmt::format("| `{}`{} | {}{} | {} | {} |", p.name, symbol, p.help, resets, p.unit,
                        Range(p));
    for (const std::string_view preset : PresetNames()) {
      text += fmt::format(" {} |", GetParameter(PresetSettings(preset).value(), p.name).value());
    }
    text += "\n";
    const Parameter* next = &p + 1;
    const bool last = next == Parameters().data() + Parameters().size();
    if (!last && group != next->group) {
      text += "\n";
    }
  }
  return text;
}

TEST(Parameters, DocumentIsThatOfTheTable) {
  const std::string path = STILLRAY_SOURCE_DIR "/docs/parameters.md";
  const std::string expected = MakeDocument();
  if (std::getenv("STILLRAY_UPDATE_DOCS") != nullptr) {
    std::ofstream(path) << expected;
  }
  std::ifstream file(path);
  std::stringstream found;
  found << file.rdbuf();
  EXPECT_EQ(found.str(), expected)
      << "run this test with STILLRAY_UPDATE_DOCS=1 to write docs/parameters.md again";
}

}  // namespace
}  // namespace stillray::parameters_doc_test
