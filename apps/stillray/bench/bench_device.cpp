// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "bench/bench_device.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/console.h"
#include "common/device_option.h"
#include "core/median.h"

namespace stillray {
namespace {

using Json = nlohmann::ordered_json;

Json TimesJson(const std::vector<double>& ms) {
  const auto [least, most] = std::minmax_element(ms.begin(), ms.end());
  return ms.empty() ? Json::object()
                    : Json{{"median_ms", Median(ms)}, {"min_ms", *least}, {"max_ms", *most}};
}

Json SubjectJson(const DeviceSubject& subject, const DeviceBenchResult& r) {
  Json stages = Json::object();
  for (const DeviceBenchResult::Stage& stage : r.stages) {
    stages[stage.name] = TimesJson(stage.ms);
  }
  Json copy = TimesJson(r.copy);
  copy["bytes_per_pixel"] = r.copy_bytes_per_pixel;
  return {{"preset", subject.preset},
          {"kernel", subject.kernel},
          {"width", subject.options.width},
          {"height", subject.options.height},
          {"signals", r.signals},
          {"frames", r.whole.size()},
          {"whole", TimesJson(r.whole)},
          {"copy", copy},
          {"stages", stages},
          {"memory", DeviceMemoryJson(r.memory)}};
}

}  // namespace

Result<Json> BenchSubjectsOnDevice(const std::string& device,
                                   const std::vector<DeviceSubject>& subjects) {
  Json list = Json::array();
  std::string description;
  for (const DeviceSubject& subject : subjects) {
    const Result<DeviceBenchResult> result = BenchOnDevice(device, subject.options);
    if (!result.ok()) {
      return Status(result.status().code(), "--device: " + result.status().message());
    }
    WriteText(stdout, fmt::format("{}, {}: {}\n", subject.preset, subject.kernel,
                                  DeviceBenchTable(subject.options, *result)));
    list.push_back(SubjectJson(subject, *result));
    description = result->device;
  }
  return Json{{"stillray", STILLRAY_VERSION}, {"device", description}, {"subjects", list}};
}

}  // namespace stillray
