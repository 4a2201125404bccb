// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "view/reference.h"

#include "core/parallel.h"

namespace stillray::view {
namespace {

/// Seeds of passes, disjoint from the seeds of frames.
constexpr uint64_t kFirstSeed = 0x5eed0000'00000000;

void Mix(const Image3& pass, float weight, Image3* mean) {
  ParallelRows(pass.height(), kRowsPerTask, [&](int y0, int y1) {
    for (int c = 0; c < 3; ++c) {
      for (int y = y0; y < y1; ++y) {
        const float* from = pass[c].Row(y);
        float* to = (*mean)[c].Row(y);
        for (int x = 0; x < pass.width(); ++x) {
          to[x] += (from[x] - to[x]) * weight;
        }
      }
    }
  });
}

}  // namespace

Status ReferenceAccumulator::AddPass(const RenderMoment& moment, Renderer* renderer,
                                     const RenderProgress& keep_going) {
  const RenderSettings own = renderer->settings();
  RenderSettings settings = own;
  settings.seed = kFirstSeed + static_cast<uint64_t>(spp_);
  STILLRAY_RETURN_IF_ERROR(renderer->SetSettings(settings));
  const Status rendered = renderer->RenderReference(moment, 1, &pass_, keep_going);
  STILLRAY_RETURN_IF_ERROR(renderer->SetSettings(own));
  STILLRAY_RETURN_IF_ERROR(rendered);
  if (spp_ == 0) {
    mean_ = pass_;
  } else {
    Mix(pass_, 1.0f / static_cast<float>(spp_ + 1), &mean_);
  }
  ++spp_;
  return Status::Ok();
}

}  // namespace stillray::view
