// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

#include "bench/bench_frames.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "benchmarks/device_bench.h"
#include "common/device_option.h"
#include "common/memory_table.h"
#include "core/clock.h"
#include "core/median.h"
#include "denoise/backend.h"

namespace stillray {
namespace {

/// Frames per second: mean, slowest frame, fastest frame.
struct Rate {
  double mean = 0;
  double least = 0;
  double most = 0;
};

Rate RateOf(const std::vector<double>& ms) {
  if (ms.empty()) {
    return {};
  }
  const auto [fastest, slowest] = std::minmax_element(ms.begin(), ms.end());
  const double sum = std::accumulate(ms.begin(), ms.end(), 0.0);
  return {1e3 * static_cast<double>(ms.size()) / sum, 1e3 / *slowest, 1e3 / *fastest};
}

/// Memory of a frame, with every plane counted as an image; for a frame in device memory only the
/// bytes are known.
DeviceMemory ImagesOf(const Frame& f) {
  DeviceMemory sum;
  if (f.on_device != nullptr) {
    sum.bytes = f.on_device->bytes();
    return sum;
  }
  const auto add = [&](const auto& plane) {
    if (!plane.empty()) {
      ++sum.resources;
      sum.bytes += plane.bytes();
      sum.largest = std::max<uint64_t>(sum.largest, plane.bytes());
    }
  };
  const auto add_all = [&](const auto& planes) {
    for (const auto& plane : planes.channel) {
      add(plane);
    }
  };
  for (const Signal& signal : f.signals) {
    add_all(signal.radiance);
    add(signal.second_moment);
  }
  const Guides& g = f.guides;
  for (const Image3* image : {&g.normal, &g.albedo, &g.specular_albedo, &g.transmission_albedo,
                              &g.previous_normal, &f.emission, &f.background}) {
    add_all(*image);
  }
  for (const Image1* plane : {&g.depth, &g.roughness, &f.samples}) {
    add(*plane);
  }
  add_all(g.motion);
  add(g.id);
  const VirtualGuides& v = f.reflection;
  add(v.depth);
  add_all(v.normal);
  add_all(v.albedo);
  add_all(v.motion);
  add(v.id);
  return sum;
}

/// Device time of the filter's last frame, excluding the host.
double DeviceTimeOf(const Denoiser& denoiser, const DenoisedFrame& out) {
  double sum = 0;
  for (const StageTime& stage : out.timings) {
    sum += stage.name == kUploadStage ? 0.0 : stage.milliseconds;
  }
  return denoiser.device_memory().allocations > 0 ? sum : 0;
}

std::string Milliseconds(double ms) {
  return ms > 0 ? fmt::format("{:.2f}", ms) : "-";
}

std::string Count(uint32_t count) {
  return count > 0 ? std::to_string(count) : "-";
}

/// Omits unknown values, since 0 would be read as a measurement.
nlohmann::ordered_json KnownMemoryJson(const std::string& name, const DeviceMemory& memory) {
  nlohmann::ordered_json json = {{"name", name}};
  const nlohmann::ordered_json all = DeviceMemoryJson(memory);
  for (const auto& [key, value] : all.items()) {
    if (value.get<uint64_t>() > 0) {
      json[key] = value;
    }
  }
  return json;
}

std::string Megabytes(uint64_t bytes) {
  return bytes > 0 ? fmt::format("{:.1f}", static_cast<double>(bytes) / 1e6) : "-";
}

}  // namespace

double DeviceTimeOf(const DeviceRenderer& renderer) {
  double sum = 0;
  if (renderer.on_device()) {
    const RenderTimings& t = renderer.timings();
    sum = t.primary_ms + t.shade_ms + t.shadow_ms + t.bounce_ms + t.image_ms;
  }
  return sum;
}

void FramesBench::PartTimes::Add(const PartTime& time) {
  wall.push_back(time.wall);
  device.push_back(time.device);
}

Status FramesBench::Add(const std::string& name, const Settings* settings, const Device& device) {
  Entry entry;
  entry.name = name;
  if (settings != nullptr) {
    Result<Denoiser> made = Denoiser::Create(*settings, device);
    STILLRAY_RETURN_IF_ERROR(made.status());
    if (!downloads_) {
      Results kept;
      kept.colour = false;
      made->SetResults(kept);
    }
    entry.denoiser.push_back(std::move(made.value()));
  }
  entries_.push_back(std::move(entry));
  return Status::Ok();
}

Status FramesBench::Run(const Frame& frame, const PartTime& traced, bool record) {
  for (Entry& entry : entries_) {
    const Clock::time_point start = Clock::now();
    if (!entry.denoiser.empty()) {
      STILLRAY_RETURN_IF_ERROR(entry.denoiser.front().Denoise(frame, &entry.out));
    }
    PartTime filtered;
    if (!entry.denoiser.empty()) {
      filtered.wall = MillisecondsSince(start);
      filtered.device = DeviceTimeOf(entry.denoiser.front(), entry.out);
    }
    if (record) {
      entry.frame_ms.push_back(traced.wall + filtered.wall);
      entry.filter.Add(filtered);
    }
  }
  if (record) {
    trace_.Add(traced);
  }
  frame_ = ImagesOf(frame);
  return Status::Ok();
}

std::vector<FramesBench::Part> FramesBench::Parts() const {
  DeviceMemory tracer;
  tracer.bytes = tracer_bytes_;
  std::vector<Part> parts = {{"scene and tracer", tracer}, {"frame", frame_}};
  for (const Entry& entry : entries_) {
    if (!entry.denoiser.empty()) {
      DeviceMemory memory = entry.denoiser.front().device_memory();
      memory.bytes = std::max<uint64_t>(memory.bytes, entry.denoiser.front().memory_bytes());
      parts.push_back({entry.name, memory});
    }
  }
  return parts;
}

std::string FramesBench::Table() const {
  std::string text =
      fmt::format("{:<24}{:>10}{:>20}{:>12}{:>11}{:>12}{:>11}\n", "frames per second", "mean",
                  "min .. max", "trace ms", "on device", "filter ms", "on device");
  for (const Entry& entry : entries_) {
    const Rate rate = RateOf(entry.frame_ms);
    text += fmt::format("{:<24}{:>10.2f}{:>20}{:>12}{:>11}{:>12}{:>11}\n", entry.name, rate.mean,
                        fmt::format("{:.2f} .. {:.2f}", rate.least, rate.most),
                        Milliseconds(Median(trace_.wall)), Milliseconds(Median(trace_.device)),
                        Milliseconds(Median(entry.filter.wall)),
                        Milliseconds(Median(entry.filter.device)));
  }
  text += fmt::format("\n{:<24}{:>12}{:>20}{:>12}{:>14}\n", "memory", "allocations",
                      "images and buffers", "MB", "largest MB");
  for (const Part& part : Parts()) {
    text += fmt::format("{:<24}{:>12}{:>20}{:>12}{:>14}\n", part.name,
                        Count(part.memory.allocations), Count(part.memory.resources),
                        Megabytes(part.memory.bytes), Megabytes(part.memory.largest));
  }
  return text + "\n" + MemoryBlocksTable();
}

nlohmann::ordered_json FramesBench::Json() const {
  auto configurations = nlohmann::ordered_json::array();
  for (const Entry& entry : entries_) {
    const Rate rate = RateOf(entry.frame_ms);
    configurations.push_back(
        {{"name", entry.name},
         {"frames", entry.frame_ms.size()},
         {"fps", {{"mean", rate.mean}, {"min", rate.least}, {"max", rate.most}}},
         {"trace_ms", Median(trace_.wall)},
         {"trace_device_ms", Median(trace_.device)},
         {"filter_ms", Median(entry.filter.wall)},
         {"filter_device_ms", Median(entry.filter.device)}});
  }
  auto memory = nlohmann::ordered_json::array();
  for (const Part& part : Parts()) {
    memory.push_back(KnownMemoryJson(part.name, part.memory));
  }
  return {{"configurations", configurations},
          {"memory", memory},
          {"memory_blocks", MemoryBlocksJson()}};
}

}  // namespace stillray
