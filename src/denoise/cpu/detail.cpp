// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/detail.h"

#include <utility>

#include "denoise/cpu/wavelet.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Fetches the mean residual along the motion; empty if there is none.
void FetchResidual(const CpuPipeline& p, const SignalHistory& residual, const Image1& like,
                   const ReprojectionTaps& taps, SignalHistory* fetched) {
  if (fetched->length.width() != like.width() || fetched->length.height() != like.height()) {
    *fetched = EmptyResidual(like.width(), like.height());
  }
  if (p.plan.runs.reproject && !residual.length.empty()) {
    p.stages.fetch_history(residual, taps, fetched);
  } else {
    *fetched = EmptyResidual(like.width(), like.height());
  }
}

/// Means over the 3x3 pixels on the same surface. Levels with geometry-only weights filter two
/// channels, so the third one is filtered in a second run.
void Blur(const CpuPipeline& p, const GuidePlanes& guides, const Image1& valid, FilterPlanes* from,
          FilterPlanes* to) {
  const AtrousSignal blur = {&from->colour, &from->variance, to, nullptr, &valid};
  p.stages.atrous({&blur, 1}, guides, GeometryLevel(0), p.plan.atrous);
  std::swap(from->colour[0], from->colour[2]);
  std::swap(to->colour[0], to->colour[2]);
  p.stages.atrous({&blur, 1}, guides, GeometryLevel(0), p.plan.atrous);
  std::swap(from->colour[0], from->colour[2]);
  std::swap(to->colour[0], to->colour[2]);
}

void RestoreDetail(const CpuPipeline& p, const GuidePlanes& guides, const NewLight& light,
                   LayerWork* work, WaveletPlanes* planes, SignalHistory* residual) {
  LumaImage3* filtered = ChangeableLight(planes);
  SignalHistory* fetched = &work->residual;
  FetchResidual(p, *residual, planes->valid, work->taps, fetched);
  FilterPlanes* measured = &planes->filter[planes->target];
  FilterPlanes* other = &work->blended;
  FilterPlanes* mean = &work->detail;
  const DetailInput in = {&light, filtered, &planes->history->variance};
  p.stages.begin_detail(in, *fetched, guides, p.plan.restore_detail, measured, &planes->valid);
  Blur(p, guides, planes->valid, measured, mean);
  p.stages.measure_detail(in, *mean, planes->valid, measured);
  p.stages.accumulate_residual(in, p.plan.restore_detail, fetched);
  std::swap(*residual, *fetched);
  for (int level = 0; level < kRestoreDetailLevels; ++level) {
    const AtrousSignal blur = {&measured->colour, &measured->variance, other, nullptr,
                               &planes->valid};
    p.stages.atrous({&blur, 1}, guides, GeometryLevel(level), p.plan.atrous);
    std::swap(measured, other);
  }
  p.stages.restore_detail(*measured, *mean, planes->history->variance, planes->valid, filtered);
}

}  // namespace

void RunRestoreDetail(const CpuPipeline& p, LayerHistory* history, LayerWork* work,
                      DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "restore_detail");
  MakeRoom(work->wavelet.front().valid, &work->blended);
  MakeRoom(work->wavelet.front().valid, &work->detail);
  history->residuals.resize(work->wavelet.size());
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    if ((p.plan.restore_detail.detail_signals >> i & 1) != 0) {
      RestoreDetail(p, history->guides, work->light[i], work, &work->wavelet[i],
                    &history->residuals[i]);
    }
  }
}

}  // namespace stillray
