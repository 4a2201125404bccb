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

double GigabytesPerSecond(const DeviceBenchResult& r) {
  return static_cast<double>(r.copy_bytes) / std::max(Median(r.copy()), 1e-9) / 1e6;
}

Json SubjectJson(const DeviceSubject& subject, const DeviceBenchResult& r) {
  Json stages = Json::object();
  for (const DeviceBenchResult::Stage& stage : r.stages) {
    stages[stage.name] = TimesJson(stage.ms);
  }
  Json copy = TimesJson(r.copy());
  copy["bytes_per_pixel"] = r.copy_bytes_per_pixel;
  copy["gigabytes_per_second"] = GigabytesPerSecond(r);
  copy["by_driver"] = TimesJson(r.transfer_copy);
  copy["by_shader"] = TimesJson(r.compute_copy);
  const bool is_float = subject.options.precision == DevicePrecision::kFloat;
  return {{"preset", subject.preset},
          {"kernel", subject.kernel},
          {"width", subject.options.width},
          {"height", subject.options.height},
          {"precision", is_float ? "float" : "half"},
          {"inputs", subject.options.inputs == BenchInputs::kPacked ? "packed" : "float"},
          {"signals", r.signals},
          {"submissions", r.whole.size()},
          {"frames_of_a_submission", r.frames_of_a_submission},
          {"whole", TimesJson(r.whole)},
          {"copy", copy},
          {"times_copy", Median(r.whole) / std::max(Median(r.copy()), 1e-9)},
          {"replaced_shaders", r.replaced_shaders},
          {"stages", stages},
          {"memory", DeviceMemoryJson(r.memory)}};
}

}  // namespace

Status BenchSubjectsOnDevice(const std::string& device, const std::vector<DeviceSubject>& subjects,
                             const std::function<Status(const Json&)>& save) {
  Json list = Json::array();
  for (const DeviceSubject& subject : subjects) {
    const Result<DeviceBenchResult> result = BenchOnDevice(device, subject.options);
    if (!result.ok()) {
      return Status(result.status().code(), "--device: " + result.status().message());
    }
    WriteText(stdout, fmt::format("{}, {}: {}\n", subject.preset, subject.kernel,
                                  DeviceBenchTable(subject.options, *result)));
    list.push_back(SubjectJson(subject, *result));
    STILLRAY_RETURN_IF_ERROR(
        save({{"stillray", STILLRAY_VERSION}, {"device", result->device}, {"subjects", list}}));
  }
  return Status::Ok();
}

}  // namespace stillray
