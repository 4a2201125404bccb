// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "common/machine.h"

#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <thread>

#include <fmt/format.h>

#include "io/text.h"

namespace stillray {
namespace {

/// Processor name from /proc/cpuinfo on x86, the architecture on other systems.
std::string ProcessorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) {
      return io::OneLine(line.substr(colon + 2), 100);
    }
  }
  utsname system{};
  return ::uname(&system) == 0 ? system.machine : "unknown processor";
}

}  // namespace

std::string MachineName() {
  return fmt::format("{}, {} threads", ProcessorName(), std::thread::hardware_concurrency());
}

std::string UtcNow() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char text[32] = "";
  if (::gmtime_r(&now, &utc) == nullptr ||
      std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc) == 0) {
    return "unknown";
  }
  return text;
}

}  // namespace stillray
