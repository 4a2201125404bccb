// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "json_output.h"

#include <cstdio>

#include "stillray/io.h"

namespace stillray {

std::string JsonText(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

Status WriteJsonOutput(const std::string& path, const std::string& json) {
  if (path != "-") {
    return WriteFileAtomically(path, json.data(), json.size());
  }
  // By name (/dev/stdout) a pipe could not be opened again.
  if (std::fwrite(json.data(), 1, json.size(), stdout) != json.size() || std::fflush(stdout) != 0) {
    return Status::Io("--json -: standard output could not be written");
  }
  return Status::Ok();
}

}  // namespace stillray
