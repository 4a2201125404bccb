// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/json_output.h"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include <fmt/format.h>

#include "io/atomic_file.h"
#include "stillray/io.h"

namespace stillray {

std::string JsonText(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

nlohmann::ordered_json JsonNumber(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

Status CheckJsonOutput(const std::string& path) {
  if (path.empty() || path == "-") {
    return Status::Ok();
  }
  const Result<io::AtomicTarget> target = io::PrepareAtomicTarget(path);
  if (!target.ok()) {
    return Status(target.status().code(), "--json " + target.status().message());
  }
  // A regular file is replaced by a new one in its folder; other files are written directly.
  const std::filesystem::path folder = std::filesystem::path(target->final_path).parent_path();
  const std::string written = target->temp_path.empty() ? target->final_path
                              : folder.empty()          ? std::string(".")
                                                        : folder.string();
  if (::access(written.c_str(), W_OK) != 0) {
    return Status::Io(fmt::format("--json {}: could not be written: {}", path,
                                  std::generic_category().message(errno)));
  }
  return Status::Ok();
}

Status WriteJsonOutput(const std::string& path, const std::string& json) {
  if (path != "-") {
    return WriteFileAtomically(path, json.data(), json.size());
  }
  // A pipe cannot be reopened by name (/dev/stdout).
  if (std::fwrite(json.data(), 1, json.size(), stdout) != json.size() || std::fflush(stdout) != 0) {
    return Status::Io("--json -: standard output could not be written");
  }
  return Status::Ok();
}

}  // namespace stillray
