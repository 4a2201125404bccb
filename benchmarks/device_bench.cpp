// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "benchmarks/device_bench.h"

#include <algorithm>
#include <memory>

#include <fmt/format.h>

#include "core/median.h"

#ifdef STILLRAY_WITH_VULKAN
#include "benchmarks/vulkan_device_bench.h"
#include "denoise/vulkan/host_denoiser.h"
#endif

namespace stillray {

Result<DeviceBenchResult> BenchOnDevice(const std::string& choice,
                                        const DeviceBenchOptions& options) {
  const Result<Device> device = Device::Open(choice);
  STILLRAY_RETURN_IF_ERROR(device.status());
#ifdef STILLRAY_WITH_VULKAN
  const auto backend = std::dynamic_pointer_cast<vulkan::VulkanBackend>(BackendOf(*device));
  if (backend != nullptr) {
    Result<DeviceBenchResult> result = vulkan::RunDeviceBench(backend->device(), options);
    if (result.ok()) {
      result->device = device->description();
    }
    return result;
  }
#else
  static_cast<void>(options);
#endif
  return Status::Unsupported(
      fmt::format("{}: no device with timestamps of its own", device->description()));
}

const std::vector<double>& DeviceBenchResult::copy() const {
  return Median(compute_copy) < Median(transfer_copy) ? compute_copy : transfer_copy;
}

std::string DeviceBenchTable(const DeviceBenchOptions& o, const DeviceBenchResult& r) {
  const auto row = [](const std::string& name, const std::vector<double>& ms) {
    const auto [least, most] = std::minmax_element(ms.begin(), ms.end());
    return ms.empty() ? std::string()
                      : fmt::format("  {:<22}{:>10.3f}{:>10.3f}{:>10.3f}\n", name, Median(ms),
                                    *least, *most);
  };
  std::string text =
      fmt::format("{}\n{}x{}, {} signals, {}, {} inputs, {} x {} frames\n", r.device, o.width,
                  o.height, r.signals, o.precision == DevicePrecision::kFloat ? "floats" : "halves",
                  o.inputs == BenchInputs::kPacked ? "packed" : "float", r.whole.size(),
                  r.frames_of_a_submission);
  if (!r.replaced_shaders.empty()) {
    text +=
        fmt::format("shaders of STILLRAY_SHADER_DIR: {}\n", fmt::join(r.replaced_shaders, ", "));
  }
  text += fmt::format("  {:<22}{:>10}{:>10}{:>10}\n", "ms on the device", "median", "min", "max");
  for (const DeviceBenchResult::Stage& stage : r.stages) {
    text += row(stage.name, stage.ms);
  }
  text += row("whole frame", r.whole);
  text += row("copy, by the driver", r.transfer_copy);
  text += row("copy, by a shader", r.compute_copy);
  const double copy_ms = Median(r.copy());
  text += fmt::format(
      "  {:.2f} times the faster copy of {} bytes per pixel, which ran at {:.1f} GB/s; {:.1f} MB "
      "in {} "
      "allocations, {} images and buffers, the largest {:.1f} MB\n",
      copy_ms > 0 ? Median(r.whole) / copy_ms : 0.0, r.copy_bytes_per_pixel,
      copy_ms > 0 ? static_cast<double>(r.copy_bytes) / copy_ms / 1e6 : 0.0,
      static_cast<double>(r.memory.bytes) / 1e6, r.memory.allocations, r.memory.resources,
      static_cast<double>(r.memory.largest) / 1e6);
  return text;
}

}  // namespace stillray
