// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/samples.h"

#include <utility>

#include "denoise/cpu/wavelet.h"
#include "denoise/stage_timer.h"

namespace stillray {

void BlendSamples(const CpuPipeline& p, const GuidePlanes& guides, const NewLight& light,
                  const Image1& valid, FilterPlanes* measured, FilterPlanes* other,
                  LumaImage3* filtered) {
  for (int level = 0; level < kKeepSamplesLevels; ++level) {
    const AtrousSignal blur = {&measured->colour, &measured->variance, other, nullptr, &valid};
    p.stages.atrous({&blur, 1}, guides, GeometryLevel(level), p.plan.atrous);
    std::swap(measured, other);
  }
  p.stages.keep_samples(*measured, valid, light, p.plan.keep_samples.kept_reach, filtered);
}

void RunKeepSamples(const CpuPipeline& p, const GuidePlanes& guides, LayerWork* work,
                    DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "keep_samples");
  MakeRoom(work->wavelet.front().valid, &work->blended);
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((p.plan.keep_samples.kept_signals >> i & 1) == 0) {
      continue;
    }
    const NewLight& light = work->light[i];
    WaveletPlanes& planes = work->wavelet[i];
    LumaImage3* filtered = ChangeableLight(&planes);
    FilterPlanes* measured = &planes.filter[planes.target];
    p.stages.measure_samples({&light, filtered, &planes.history->variance, &guides.inverse_depth},
                             measured, &planes.valid);
    BlendSamples(p, guides, light, planes.valid, measured, &work->blended, filtered);
  }
}

}  // namespace stillray
