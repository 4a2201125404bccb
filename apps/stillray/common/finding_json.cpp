// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/finding_json.h"

#include <cmath>
#include <limits>

#include "io/text.h"

namespace stillray {
namespace {

double ParseNumber(const nlohmann::ordered_json& json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

}  // namespace

nlohmann::ordered_json FiniteNumberJson(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json FindingJson(const Finding& finding) {
  nlohmann::ordered_json json = {{"name", finding.name},
                                 {"frames", finding.frames},
                                 {"what", finding.what},
                                 {"cure", finding.cure},
                                 {"measured", FiniteNumberJson(finding.measured)},
                                 {"expected", FiniteNumberJson(finding.expected)}};
  if (!finding.aov.empty()) {
    json["aov"] = io::OneLine(finding.aov);
  }
  return json;
}

Finding ParseFinding(const nlohmann::ordered_json& json) {
  Finding finding;
  finding.name = json.at("name").get<std::string>();
  finding.frames = json.at("frames").get<std::vector<int64_t>>();
  finding.what = json.at("what").get<std::string>();
  finding.cure = json.at("cure").get<std::string>();
  finding.measured = ParseNumber(json.at("measured"));
  finding.expected = ParseNumber(json.at("expected"));
  finding.aov = json.value("aov", std::string());
  return finding;
}

}  // namespace stillray
