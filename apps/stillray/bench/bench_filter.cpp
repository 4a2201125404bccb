// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_filter.h"

#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include "core/clock.h"
#include "core/median.h"
#include "core/one_signal.h"
#include "denoise/level_names.h"

namespace stillray {
namespace {

/// Minimum memory traffic of a fused filter with half precision storage in bytes per pixel: albedo,
/// depth, normal, motion 16, the previous frame's depth and normal 8, its image 8, the new image 8;
/// and per signal its radiance 8, history and moments 12 read and 12 written.
constexpr size_t kSharedBytes = 40;
constexpr size_t kSignalBytes = 32;

/// Multiply-adds per tap of the wavelet for one signal; several signals are counted separately.
constexpr double kTapWork = 15.5;

Times& Find(std::vector<Times>* table, std::string_view name) {
  const auto at =
      std::find_if(table->begin(), table->end(), [&](const Times& t) { return t.name == name; });
  if (at != table->end()) {
    return *at;
  }
  table->push_back({std::string(name), {}});
  return table->back();
}

size_t SignalsOf(const Settings& settings) {
  switch (settings.signals) {
    case SignalGrouping::kSingle:
      return 1;
    case SignalGrouping::kSplit:
    case SignalGrouping::kChannels:
      return 3;
    default:
      return 2;
  }
}

std::string Ratio(double value) {
  return value > 0 ? fmt::format("{:.1f}", value) : "-";
}

std::string Label(const FilterSubject& s) {
  return fmt::format("{} {}", s.name, s.kernel);
}

}  // namespace

double Times::Min() const {
  return ms.empty() ? 0 : *std::min_element(ms.begin(), ms.end());
}

double Times::Median() const {
  return stillray::Median(ms);
}

Status FilterBench::Add(const FilterSubject& subject) {
  Result<Denoiser> denoiser = Denoiser::Create(subject.settings, subject.backend);
  if (!denoiser.ok()) {
    return denoiser.status();
  }
  entries_.push_back({subject,
                      std::move(denoiser.value()),
                      std::make_unique<tbb::task_arena>(subject.threads),
                      {},
                      {"whole", {}},
                      {"wavelet", {}},
                      {},
                      0,
                      SignalsOf(subject.settings)});
  return Status::Ok();
}

Status FilterBench::RunEntry(const Frame& frame, bool record, Entry* entry) {
  Status status = Status::Ok();
  const Clock::time_point start = Clock::now();
  entry->arena->execute([&] { status = entry->denoiser.Denoise(frame, &entry->out); });
  const double whole = MillisecondsSince(start);
  STILLRAY_RETURN_IF_ERROR(status);
  if (!record) {
    return status;
  }
  entry->whole.ms.push_back(whole);
  double wavelet = 0;
  for (const StageTime& stage : entry->out.timings) {
    Find(&entry->stages, stage.name).ms.push_back(stage.milliseconds);
    wavelet += IsLevelName(stage.name) ? stage.milliseconds : 0;
  }
  entry->wavelet.ms.push_back(wavelet);
  entry->bytes = entry->denoiser.memory_bytes();
  return status;
}

Status FilterBench::Run(const Frame& frame, bool record) {
  pixels_ = static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height);
  if (!copy_) {
    copy_ = std::make_unique<CopyTest>(pixels_ * (kSharedBytes + kSignalBytes));
  }
  if (std::any_of(entries_.begin(), entries_.end(),
                  [](const Entry& e) { return e.subject.one_signal; })) {
    ToOneSignal(frame, &one_signal_);
  }
  for (Entry& entry : entries_) {
    const bool scalar = entry.subject.backend == Backend::kReference;
    if (!scalar || frames_ % 4 == 0) {
      const Frame& given = entry.subject.one_signal ? one_signal_ : frame;
      STILLRAY_RETURN_IF_ERROR(RunEntry(given, record, &entry));
    }
    if (record) {
      copy_times_.ms.push_back(copy_->Run());
    }
  }
  if (record) {
    peak_ = std::max(peak_, MultiplyAddsPerSecond());
  }
  ++frames_;
  return Status::Ok();
}

double FilterBench::CopyMs(size_t signals) const {
  const size_t bytes = kSharedBytes + signals * kSignalBytes;
  return copy_times_.Median() * static_cast<double>(bytes) /
         static_cast<double>(kSharedBytes + kSignalBytes);
}

double FilterBench::ScalarMs(const FilterSubject& subject) const {
  for (const Entry& entry : entries_) {
    if (entry.subject.backend == Backend::kReference && entry.subject.name == subject.name &&
        entry.subject.kernel == subject.kernel) {
      return entry.whole.Min();
    }
  }
  return 0;
}

double FilterBench::PeakMs(const Entry& entry) const {
  const double taps = entry.subject.kernel == "3x3" ? 8 : 24;
  const double work = taps * entry.subject.settings.steps.count * kTapWork *
                      static_cast<double>(pixels_ * entry.signals);
  return peak_ > 0 ? work / peak_ * 1e3 : 0;
}

std::string FilterBench::Table() const {
  std::string text =
      fmt::format("{:<30}{:>8}{:>10}{:>11}{:>9}{:>10}{:>15}{:>11}\n", "whole frame", "threads",
                  "min ms", "median ms", "x copy", "scalar x", "atrous x peak", "bytes/px");
  for (const Entry& e : entries_) {
    const bool scalar = e.subject.backend == Backend::kReference;
    const std::string label = Label(e.subject) + (scalar ? ", scalar" : "");
    const double peak = e.subject.threads == 1 && !scalar ? e.wavelet.Min() / PeakMs(e) : 0;
    text += fmt::format("{:<30}{:>8}{:>10.2f}{:>11.2f}{:>9}{:>10}{:>15}{:>11.0f}\n", label,
                        e.subject.threads, e.whole.Min(), e.whole.Median(),
                        Ratio(e.whole.Median() / CopyMs(e.signals)),
                        scalar ? "-" : Ratio(ScalarMs(e.subject) / e.whole.Min()), Ratio(peak),
                        static_cast<double>(e.bytes) / static_cast<double>(pixels_));
  }
  text += fmt::format(
      "copy of {} bytes per pixel, all threads: {:.2f} ms (min {:.2f}); {}, peak {:.1f} thousand "
      "million multiply-adds per second and thread\n\n",
      kSharedBytes + kSignalBytes, copy_times_.Median(), copy_times_.Min(), InstructionSet(),
      peak_ / 1e9);
  int most = 0;
  for (const Entry& e : entries_) {
    most = std::max(most, e.subject.threads);
  }
  std::vector<std::string> names;
  for (const Entry& e : entries_) {
    for (const Times& t : e.stages) {
      if (std::find(names.begin(), names.end(), t.name) == names.end()) {
        names.push_back(t.name);
      }
    }
  }
  std::string head = fmt::format("{:<22}", "median ms of a stage");
  std::map<std::string, std::string> rows;
  for (const Entry& e : entries_) {
    if (e.subject.threads != most || e.subject.backend == Backend::kReference) {
      continue;
    }
    const std::string label = Label(e.subject);
    const int width = static_cast<int>(std::max<size_t>(label.size(), 7)) + 2;
    head += fmt::format("{:>{}}", label, width);
    for (const std::string& name : names) {
      const auto at = std::find_if(e.stages.begin(), e.stages.end(),
                                   [&](const Times& t) { return t.name == name; });
      const std::string cell = at == e.stages.end() ? "-" : fmt::format("{:.2f}", at->Median());
      rows[name] += fmt::format("{:>{}}", cell, width);
    }
  }
  text += head + "\n";
  for (const std::string& name : names) {
    text += fmt::format("{:<22}{}\n", name, rows[name]);
  }
  return text;
}

nlohmann::ordered_json FilterBench::Json() const {
  using Json = nlohmann::ordered_json;
  Json subjects = Json::array();
  for (const Entry& e : entries_) {
    Json stages = Json::object();
    for (const Times& t : e.stages) {
      stages[t.name] = {{"min_ms", t.Min()}, {"median_ms", t.Median()}};
    }
    subjects.push_back(
        {{"name", e.subject.name},
         {"kernel", e.subject.kernel},
         {"threads", e.subject.threads},
         {"scalar", e.subject.backend == Backend::kReference},
         {"signals", e.signals},
         {"levels", e.subject.settings.steps.count},
         {"whole", {{"min_ms", e.whole.Min()}, {"median_ms", e.whole.Median()}}},
         {"wavelet", {{"min_ms", e.wavelet.Min()}, {"median_ms", e.wavelet.Median()}}},
         {"stages", stages},
         {"bytes", e.bytes}});
  }
  return {{"pixels", pixels_},
          {"subjects", subjects},
          {"copy",
           {{"bytes_per_pixel", kSharedBytes + kSignalBytes},
            {"median_ms", copy_times_.Median()},
            {"min_ms", copy_times_.Min()}}},
          {"instruction_set", InstructionSet()},
          {"multiply_adds_per_second_and_thread", peak_}};
}

}  // namespace stillray
