// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// docs/render_settings.md is generated from the table. STILLRAY_UPDATE_DOCS=1 updates it.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "stillray/render.h"

namespace stillray {
namespace {

std::string Values(const Parameter& p) {
  switch (p.type) {
    case ParameterType::kFlag:
      return "on, off";
    case ParameterType::kChoice:
    case ParameterType::kText:
      return fmt::format("{}", fmt::join(p.choices, ", "));
    case ParameterType::kSeed:
      return "64 bits";
    case ParameterType::kRate:
      return fmt::format("1 to {}, 1/2 to 1/{}", p.max, 1 / p.min);
    default:
      return fmt::format("{} to {}", p.min, p.max);
  }
}

std::string OptionOf(const Parameter& p) {
  std::string name = p.name;
  std::replace(name.begin(), name.end(), '_', '-');
  return p.type == ParameterType::kFlag ? fmt::format("`--{}`, `--no-{}`", name, name)
                                        : fmt::format("`--{}`", name);
}

std::string MakeDocument() {
  std::string text =
      "<!-- SPDX-FileCopyrightText: the stillray developers\n"
      "     SPDX-License-Identifier: Apache-2.0 -->\n"
      "# Settings of the path tracer\n\n"
      "Options of `stillray render`, `view` and `bench`, lines `render.NAME=VALUE` of settings "
      "files\n"
      "([viewer.md](viewer.md#settings-files)), members of `RenderSettings` in "
      "`stillray/render.h`. "
      "Made from the\ntable in `src/render/settings.cpp`; a test keeps the two the same.\n\n"
      "| setting | meaning | values | default | option |\n|---|---|---|---|---|\n";
  for (const Parameter& p : RenderParameters()) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, p.help, Values(p),
                        GetRenderParameter({}, p.name).value(), OptionOf(p));
  }
  return text;
}

TEST(RenderParameters, DocumentIsThatOfTheTable) {
  const std::string path = STILLRAY_SOURCE_DIR "/docs/render_settings.md";
  const std::string expected = MakeDocument();
  if (std::getenv("STILLRAY_UPDATE_DOCS") != nullptr) {
    std::ofstream(path) << expected;
  }
  std::ifstream file(path);
  std::stringstream found;
  found << file.rdbuf();
  EXPECT_EQ(found.str(), expected)
      << "run this test with STILLRAY_UPDATE_DOCS=1 to write docs/render_settings.md anew";
}

}  // namespace
}  // namespace stillray
