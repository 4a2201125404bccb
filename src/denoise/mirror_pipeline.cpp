// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// keep_mirrors and the wavelet in it: what is seen in mirrors, after the filter.
#include <atomic>

#include "core/parallel.h"
#include "denoise/denoiser_impl.h"
#include "denoise/filter_parameters.h"
#include "denoise/stage_timer.h"
#include "denoise/stages/keep_mirrors_shared.h"

namespace stillray {
namespace {

/// Whether any pixel shows a mirror.
bool HasMirrors(const Image1& roughness, const Image1& surface, float limit) {
  std::atomic<bool> any = false;
  ParallelRows(roughness.height(), 32, [&](int y0, int y1) {
    bool found = false;
    for (int y = y0; y < y1 && !any; ++y) {
      const float* r = roughness.Row(y);
      const float* i = surface.Row(y);
      for (int x = 0; x < roughness.width(); ++x) {
        found = found || IsMirror(i[x], 1.0f, r[x], limit);
      }
    }
    if (found) {
      any = true;
    }
  });
  return any;
}

}  // namespace

/// A level of a wavelet that stops at edges of the guides alone.
AtrousParameters Denoiser::Impl::GeometryLevel(int level) const {
  AtrousParameters p;
  p.weights = AtrousWeights::kGeometry;
  p.radius = kLimitHistoryRadius;
  p.step = 1 << level;
  p.edges = EdgesOf(settings);
  return p;
}

/// The finished light of a signal, where it may be changed: not where it is the history as well.
Image3* Denoiser::Impl::FinishedLight(size_t signal) {
  WaveletPlanes& planes = wavelet[signal];
  if (planes.light == &planes.history->colour) {
    Image3* room = &planes.filter[planes.target].colour;
    CopyImage(*planes.light, room);
    planes.light = room;
    planes.target ^= 1;
  }
  return planes.light;
}

void Denoiser::Impl::KeepMirrors(size_t signal) {
  WaveletPlanes& planes = wavelet[signal];
  Image3* filtered = FinishedLight(signal);
  FilterPlanes* measured = &planes.filter[planes.target];
  FilterPlanes* other = &mirror_work;
  const KeepMirrorsInput in = {&light[signal],
                               filtered,
                               &state.guides,
                               &frame->guides.roughness,
                               HasHistory() ? &guides->motion : nullptr,
                               settings.mirror_roughness};
  stages->measure_mirrors(in, measured, &planes.present);
  for (int level = 0; level < kKeepMirrorsLevels; ++level) {
    const AtrousSignal blur = {&measured->colour, &measured->variance, other, nullptr,
                               &planes.present};
    stages->atrous({&blur, 1}, state.guides, GeometryLevel(level));
    std::swap(measured, other);
  }
  stages->keep_mirrors(*measured, planes.present, light[signal], filtered);
}

void Denoiser::Impl::RunKeepMirrors() {
  if (!MayKeepMirrors() ||
      !HasMirrors(frame->guides.roughness, state.guides.inverse_depth, settings.mirror_roughness)) {
    return;
  }
  const StageTimer timer(&out->timings, "keep_mirrors");
  const Image1& like = wavelet.front().present;
  if (mirror_work.variance.width() != like.width() ||
      mirror_work.variance.height() != like.height() ||
      mirror_work.variance.border() != like.border()) {
    mirror_work = FilterPlanes(like.width(), like.height(), like.border());
  }
  for (size_t i = 0; i < groups.size(); ++i) {
    if (ReflectsOrRefracts(groups[i], *frame)) {
      KeepMirrors(i);
    }
  }
}

}  // namespace stillray
