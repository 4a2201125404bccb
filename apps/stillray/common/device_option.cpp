// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "common/device_option.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "common/console.h"
#include "common/trace_device.h"

namespace stillray {
namespace {

bool Contains(const std::vector<std::string>& list, const std::string& entry) {
  return std::find(list.begin(), list.end(), entry) != list.end();
}

/// Short reason why "auto" chose the CPU.
std::string ReasonForCpu() {
  std::string remark;
  const std::vector<DeviceDescription> devices = ListDevices(&remark);
  if (devices.empty()) {
    return "no Vulkan driver";
  }
  const auto usable = [](const DeviceDescription& d) { return d.usable.ok(); };
  if (std::none_of(devices.begin(), devices.end(), usable)) {
    return "no usable Vulkan device";
  }
  const bool gpu = std::any_of(devices.begin(), devices.end(),
                               [](const DeviceDescription& d) { return d.is_gpu; });
  return gpu ? "the GPU cannot be used" : "no GPU with Vulkan";
}

Result<Device> OpenNamed(const char* option, const std::string& text) {
  Result<Device> opened = Device::Open(text);
  return opened.ok() ? std::move(opened)
                     : Status(opened.status().code(),
                              fmt::format("{}: {}", option, opened.status().message()));
}

void PrintDevice(const Device& device, bool verbose, const std::string& work) {
  if (!device.is_cpu()) {
    PrintTo(stderr, "{} on {}\n", work, device.description());
    return;
  }
  const size_t threads =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  PrintTo(stderr, "{} on the CPU, {} thread{}{}\n", work, threads, threads == 1 ? "" : "s",
          device.remark().empty() ? "" : "; " + ReasonForCpu());
  if (verbose && !device.remark().empty()) {
    PrintTo(stderr, "{}\n", device.remark());
  }
}

}  // namespace

void AddDeviceOption(CLI::App* command, std::string* text, bool* verbose) {
  command
      ->add_option("--device", *text,
                   "Device that traces and denoises: cpu, vulkan, vulkan:N (stillray info "
                   "--devices), or auto: a GPU if there is one, else the CPU")
      ->capture_default_str();
  AddVerboseOption(command, verbose);
}

void AddVerboseOption(CLI::App* command, bool* verbose) {
  command->add_flag("-v,--verbose", *verbose, "Print why --device auto chose the CPU");
}

Result<Device> OpenDeviceOption(const std::string& text, bool verbose, const std::string& work) {
  Result<Device> opened = OpenNamed("--device", text);
  if (opened.ok()) {
    PrintDevice(*opened, verbose, work);
  }
  return opened;
}

void AddTraceDeviceOption(CLI::App* command, std::string* text) {
  command->add_option("--trace-device", *text,
                      "Device that traces, as for --device, which then only denoises; if they "
                      "differ, each frame is traced while the last one is denoised. Default: the "
                      "same device");
}

Result<RenderDevices> OpenRenderDevices(const std::string& device, const std::string& trace_device,
                                        bool verbose) {
  if (trace_device.empty()) {
    const Result<Device> both = OpenDeviceOption(device, verbose, "rendering");
    STILLRAY_RETURN_IF_ERROR(both.status());
    return RenderDevices(*both);
  }
  const Result<Device> filter = OpenNamed("--device", device);
  STILLRAY_RETURN_IF_ERROR(filter.status());
  const Result<Device> tracer = OpenNamed("--trace-device", trace_device);
  STILLRAY_RETURN_IF_ERROR(tracer.status());
  const RenderDevices devices(*filter, *tracer);
  if (!devices.differ()) {
    PrintDevice(*filter, verbose, "rendering");
    return RenderDevices(*filter);  // one device for both, opened once
  }
  PrintDevice(*filter, verbose, "denoising");
  PrintDevice(*tracer, verbose, "tracing");
  return devices;
}

void TellFallBack(const Denoiser& denoiser, bool* told) {
  if (!*told && !denoiser.remark().empty()) {
    *told = true;
    PrintTo(stderr, "denoising on the CPU after all: {}\n", denoiser.remark());
  }
}

std::string DeviceMemoryLine(const DeviceMemory& memory) {
  return memory.allocations == 0
             ? std::string()
             : fmt::format(
                   "  memory on the device: {:.1f} MB in {} allocations, {} images and "
                   "buffers, the largest {:.1f} MB\n",
                   static_cast<double>(memory.bytes) / 1e6, memory.allocations, memory.resources,
                   static_cast<double>(memory.largest) / 1e6);
}

nlohmann::ordered_json DeviceMemoryJson(const DeviceMemory& memory) {
  return {{"allocations", memory.allocations},
          {"images_and_buffers", memory.resources},
          {"bytes", memory.bytes},
          {"largest_bytes", memory.largest}};
}

std::string DevicesText() {
  std::string remark;
  std::string text = "cpu\n";
  const std::vector<std::string> tracing = RayTracingDevices();
  for (const DeviceDescription& d : ListDevices(&remark)) {
    text += fmt::format("{}  {}, {}, {}, {:.1f} GB{}{}\n", d.choice, d.name, d.kind, d.driver,
                        static_cast<double>(d.memory_bytes) / 1e9,
                        Contains(tracing, d.choice) ? ", ray tracing" : "",
                        d.usable.ok() ? "" : "; not usable: " + d.usable.message());
  }
  if (!remark.empty()) {
    text += "no others: " + remark + "\n";
  }
  return text;
}

nlohmann::ordered_json DevicesJson() {
  using Json = nlohmann::ordered_json;
  std::string remark;
  Json list = Json::array();
  const std::vector<std::string> tracing = RayTracingDevices();
  for (const DeviceDescription& d : ListDevices(&remark)) {
    list.push_back({{"device", d.choice},
                    {"name", d.name},
                    {"kind", d.kind},
                    {"driver", d.driver},
                    {"memory_bytes", d.memory_bytes},
                    {"is_gpu", d.is_gpu},
                    {"ray_tracing", Contains(tracing, d.choice)},
                    {"usable", d.usable.ok()},
                    {"missing", d.usable.message()}});
  }
  return {{"devices", list}, {"remark", remark}};
}

}  // namespace stillray
