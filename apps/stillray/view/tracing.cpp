// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/tracing.h"

#include <algorithm>

#include "core/clock.h"

namespace stillray::view {
namespace {

/// Wall time of a phase: CPU times are summed over threads, device times are timestamp queries.
double ShareOfWall(const RenderTimings& t, bool on_device, double wall_ms) {
  if (on_device) {
    return 1;
  }
  const double sum =
      t.clear_ms + t.primary_ms + t.bounce_ms + t.shadow_ms + t.shade_ms + t.image_ms;
  return sum > 0 ? std::max(wall_ms - t.update_ms, 0.0) / sum : 0;
}

void AddTracerStages(const DeviceRenderer& renderer, double wall_ms,
                     std::vector<StageTime>* stages) {
  const RenderTimings& t = renderer.timings();
  const double share = ShareOfWall(t, renderer.on_device(), wall_ms);
  stages->push_back({"update scene", t.update_ms});
  if (t.clear_ms > 0) {
    stages->push_back({"choose pixels", t.clear_ms * share});
  }
  stages->push_back({"primary rays", t.primary_ms * share});
  stages->push_back({"bounces", t.bounce_ms * share});
  stages->push_back({"shadow rays", t.shadow_ms * share});
  stages->push_back({"shading", t.shade_ms * share});
  if (t.image_ms > 0) {
    stages->push_back({"virtual guides", t.image_ms * share});
  }
  if (renderer.on_device()) {
    stages->push_back({"copy to the frame", t.copy_ms});
  }
}

/// Time independent of the samples: guides, if computed for all pixels.
double FixedTime(const DeviceRenderer& renderer, double wall_ms) {
  const RenderTimings& t = renderer.timings();
  const RenderSettings& settings = renderer.settings();
  const bool sparse = settings.guides == GuideCoverage::kSparse && settings.cycle > 1;
  const double fixed = t.clear_ms + (sparse ? 0 : t.primary_ms + t.copy_ms);
  return t.update_ms + ShareOfWall(t, renderer.on_device(), wall_ms) * fixed;
}

}  // namespace

Status TraceFrame(const RenderSettings& settings, const RenderMoment& moment,
                  const RenderProgress& keep_going, DeviceRenderer* renderer, Frame* frame,
                  Tracing* tracing) {
  const Clock::time_point start = Clock::now();
  STILLRAY_RETURN_IF_ERROR(renderer->SetSettings(settings));
  STILLRAY_RETURN_IF_ERROR(renderer->RenderFrame(moment, frame, keep_going));
  tracing->milliseconds = MillisecondsSince(start);
  tracing->fixed_ms = FixedTime(*renderer, tracing->milliseconds);
  tracing->stages.clear();
  AddTracerStages(*renderer, tracing->milliseconds, &tracing->stages);
  tracing->memory_bytes = renderer->memory_bytes();
  tracing->place = renderer->place();
  tracing->remark = renderer->TakeRemark();
  return Status::Ok();
}

}  // namespace stillray::view
