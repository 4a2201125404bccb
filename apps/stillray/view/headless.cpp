// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/headless.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "common/console.h"
#include "common/interrupt.h"
#include "common/output_folder.h"
#include "core/median.h"
#include "stillray/io.h"
#include "view/split.h"
#include "view/view_session.h"

namespace stillray::view {
namespace {

void Summarise(const ViewFrame& last, const std::vector<FrameCost>& costs) {
  std::vector<double> trace;
  std::vector<double> filter;
  std::vector<double> total;
  for (const FrameCost& cost : costs) {
    trace.push_back(cost.trace_ms);
    filter.push_back(cost.filter_ms);
    total.push_back(cost.total());
  }
  PrintTo(
      stdout,
      "{} frames of {}x{} at {} samples per pixel: median {:.1f} ms (tracing {:.1f}, filter and "
      "pictures {:.1f}), slowest {:.1f} ms\n",
      costs.size(), last.width, last.height, ToText(last.rate), Median(total), Median(trace),
      Median(filter), *std::max_element(total.begin(), total.end()));
  for (size_t i = 0; i < last.panes.size(); ++i) {
    if (const ViewRange& range = last.ranges[i]; range.top > 0) {
      PrintTo(stdout, "{}: colours from 0 to {:.4g} {}{}\n", last.panes[i], range.top, range.unit,
              range.logarithmic ? ", logarithmic" : "");
    }
  }
}

}  // namespace

Status RunHeadless(const ViewOptions& options) {
  if (!options.folder.empty()) {
    STILLRAY_RETURN_IF_ERROR(MakeOutputFolder(options.folder));
  }
  CatchInterrupts();
  Result<LoadedScene> loaded = LoadForView(
      options.request, options.settings, [](const LoadPhase&) { return !Interrupted(); },
      options.devices.tracer);
  if (!loaded.ok()) {
    return loaded.status();
  }
  const size_t cameras = loaded->scene->cameras.size();
  if (static_cast<size_t>(options.settings.camera) >= cameras) {
    return Status::InvalidArgument(fmt::format("--camera is {}, the scene's are numbered 0 to {}",
                                               options.settings.camera, cameras - 1));
  }
  ViewSession session(std::move(loaded.value()), options.devices);
  for (const std::string& warning : session.scene().warnings) {
    PrintTo(stderr, "note: {}\n", warning);
  }
  const RenderProgress keep_going = [](double) { return !Interrupted(); };
  ViewFrame frame;
  std::vector<FrameCost> costs;
  for (int n = 1; n <= options.headless_frames; ++n) {
    STILLRAY_RETURN_IF_ERROR(
        session.RenderNext(options.settings, 1 / options.settings.fps, keep_going, &frame));
    if (!frame.note.empty()) {
      PrintTo(stderr, "note: {}\n", frame.note);
    }
    STILLRAY_RETURN_IF_ERROR(session.RefineReference(keep_going));
    costs.push_back(frame.cost);
    if (!options.folder.empty()) {
      const std::string pattern =
          (std::filesystem::path(options.folder) / "view.####.png").string();
      STILLRAY_RETURN_IF_ERROR(WritePng(FrameFileName(pattern, n),
                                        ComposePanes(frame.pictures, options.settings.dividers)));
    }
  }
  Summarise(frame, costs);
  return Status::Ok();
}

}  // namespace stillray::view
