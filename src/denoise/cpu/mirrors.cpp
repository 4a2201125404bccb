// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/mirrors.h"

#include <atomic>

#include "core/parallel.h"
#include "denoise/cpu/samples.h"
#include "denoise/cpu/wavelet.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Whether any pixel is a mirror.
bool HasMirrors(const Image1& roughness, const Image1& surface, float mirror_roughness) {
  std::atomic<bool> any = false;
  ParallelRows(roughness.height(), 32, [&](int y0, int y1) {
    bool found = false;
    for (int y = y0; y < y1 && !any; ++y) {
      const float* r = roughness.Row(y);
      const float* i = surface.Row(y);
      for (int x = 0; x < roughness.width(); ++x) {
        found = found || IsMirror(i[x], 1.0f, r[x], mirror_roughness);
      }
    }
    if (found) {
      any = true;
    }
  });
  return any;
}

void KeepMirrors(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                 const NewLight& light, WaveletPlanes* planes, FilterPlanes* other) {
  LumaImage3* filtered = ChangeableLight(planes);
  FilterPlanes* measured = &planes->filter[planes->target];
  const KeepMirrorsInput mirrors = {&light, filtered, &guides, &in.roughness,
                                    p.plan.runs.reproject ? &in.guides.motion : nullptr};
  p.stages.measure_mirrors(mirrors, p.plan.keep_mirrors, measured, &planes->valid);
  BlendSamples(p, guides, light, planes->valid, measured, other, filtered);
}

}  // namespace

void RunKeepMirrors(const CpuPipeline& p, const FrameInput& in, const GuidePlanes& guides,
                    LayerWork* work, DenoisedFrame* out) {
  if (!HasMirrors(in.roughness, guides.inverse_depth, p.plan.keep_mirrors.mirror_roughness)) {
    return;
  }
  const StageTimer timer(&out->timings, "keep_mirrors");
  MakeRoom(work->wavelet.front().valid, &work->blended);
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((p.plan.keep_mirrors.mirror_signals >> i & 1) != 0) {
      KeepMirrors(p, in, guides, work->light[i], &work->wavelet[i], &work->blended);
    }
  }
}

}  // namespace stillray
