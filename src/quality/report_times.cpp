// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "quality/report_times.h"

#include <algorithm>
#include <iterator>
#include <list>
#include <map>
#include <numeric>

namespace stillray::report {
namespace {

std::optional<StepTimes> Summarise(const std::string& name, std::vector<double> values) {
  if (values.empty()) {
    return std::nullopt;
  }
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  StepTimes times;
  times.name = name;
  times.frames = static_cast<int>(values.size());
  times.median_ms =
      values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  times.min_ms = values.front();
  times.max_ms = values.back();
  times.sum_ms = std::accumulate(values.begin(), values.end(), 0.0);
  return times;
}

}  // namespace

TimeTable MakeTimeTable(const std::vector<RenderLogFrame>& frames) {
  std::list<std::string> order;
  std::map<std::string, std::vector<double>> stages;
  std::vector<double> render;
  std::vector<double> denoise;
  std::vector<double> write;
  for (const RenderLogFrame& frame : frames) {
    if (frame.render_ms) {
      render.push_back(*frame.render_ms);
    }
    if (frame.denoise_ms) {
      denoise.push_back(*frame.denoise_ms);
    }
    if (frame.write_ms) {
      write.push_back(*frame.write_ms);
    }
    auto previous = order.end();
    for (const auto& [stage, ms] : frame.stages_ms) {
      std::vector<double>& values = stages[stage];
      if (values.empty()) {
        const auto after = previous == order.end() ? order.begin() : std::next(previous);
        previous = order.insert(after, stage);
      } else {
        previous = std::find(order.begin(), order.end(), stage);
      }
      values.push_back(ms);
    }
  }
  TimeTable table;
  table.render = Summarise("render", render);
  table.denoise = Summarise("denoise", denoise);
  table.write = Summarise("write", write);
  double total = 0;
  for (const std::string& stage : order) {
    table.stages.push_back(*Summarise(stage, stages[stage]));
    total += table.stages.back().sum_ms;
  }
  for (StepTimes& stage : table.stages) {
    stage.share = total > 0 ? stage.sum_ms / total : 0;
  }
  return table;
}

}  // namespace stillray::report
