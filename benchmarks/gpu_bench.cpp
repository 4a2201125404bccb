// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The denoiser on a GPU, beside a copy of the least bytes that it must touch: a table for each size
// and setting.
//   gpu_bench [DEVICE, default vulkan] [FRAMES, default 100] [SIZE ..., default 1920x1080
//   3840x2160]
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "benchmarks/device_bench.h"

namespace stillray {
namespace {

struct Subject {
  const char* name;
  const char* preset;
  std::vector<std::pair<const char*, const char*>> changes;
};

Status Measure(const std::string& device, int frames, const std::string& size) {
  int width = 0;
  int height = 0;
  if (std::sscanf(size.c_str(), "%dx%d", &width, &height) != 2) {
    return Status::InvalidArgument(fmt::format("size is '{}', expected such as 1920x1080", size));
  }
  const Subject subjects[] = {
      {"svgf, one signal, 5x5", "svgf", {{"signals", "single"}}},
      {"svgf, direct and indirect, 5x5", "svgf", {{"signals", "direct_indirect"}}},
      {"default, 5x5", "default", {}},
      {"temporal stage alone, one signal", "temporal", {{"signals", "single"}}},
  };
  for (const Subject& subject : subjects) {
    Settings settings = PresetSettings(subject.preset).value();
    for (const auto& [name, value] : subject.changes) {
      STILLRAY_RETURN_IF_ERROR(SetParameter(&settings, name, value));
    }
    const DeviceBenchOptions options = {settings, width, height, frames, DevicePrecision::kHalf};
    const Result<DeviceBenchResult> result = BenchOnDevice(device, options);
    STILLRAY_RETURN_IF_ERROR(result.status());
    fmt::print("{}\n{}\n", subject.name, DeviceBenchTable(options, *result));
    std::fflush(stdout);
  }
  return Status::Ok();
}

}  // namespace
}  // namespace stillray

int main(int argc, char** argv) {
  const std::string device = argc > 1 ? argv[1] : "vulkan";
  const int frames = argc > 2 ? std::atoi(argv[2]) : 100;
  std::vector<std::string> sizes(argv + (argc > 3 ? 3 : argc), argv + argc);
  if (sizes.empty()) {
    sizes = {"1920x1080", "3840x2160"};
  }
  if (frames < 1) {
    fmt::print(stderr, "error: frames is '{}', expected 1 or more\n", argv[2]);
    return 2;
  }
  for (const std::string& size : sizes) {
    const stillray::Status status = stillray::Measure(device, frames, size);
    if (!status.ok()) {
      fmt::print(stderr, "error: {}\n", status.message());
      return 2;
    }
  }
  return 0;
}
