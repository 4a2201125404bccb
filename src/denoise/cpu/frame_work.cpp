// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/frame_work.h"

#include <algorithm>
#include <utility>

#include "denoise/copy_image.h"

namespace stillray {
namespace {

/// Copies the guides that reproject reads; nothing if \p from has another size.
void CopyGuides(const GuidePlanes& from, GuidePlanes* to) {
  if (from.id.width() != to->id.width() || from.id.height() != to->id.height()) {
    return;
  }
  for (int y = 0; y < from.id.height(); ++y) {
    std::copy_n(from.inverse_depth.Row(y), from.id.width(), to->inverse_depth.Row(y));
    std::copy_n(from.id.Row(y), from.id.width(), to->id.Row(y));
  }
  CopyImage(from.normal, &to->normal);
}

/// Changes the border of a history's light.
void SetBorder(int border, SignalHistory* history) {
  for (LumaImage3* image : {&history->colour, &history->behind}) {
    if (!image->empty() && (*image)[0].border() != border) {
      LumaImage3 other(image->width(), image->height(), border);
      CopyImage(*image, &other);
      *image = std::move(other);
    }
  }
}

bool HasPlanes(const FrameWork& work, int width, int height, const FramePlan& plan) {
  return work.picture.width() == width && work.picture.height() == height &&
         work.light.size() == plan.signals.size() &&
         work.spare.compressed.empty() != plan.layout.with_compressed &&
         work.spare.behind.empty() != plan.layout.with_behind;
}

/// Allocates the planes that do not depend on the border.
void MakePlanes(int width, int height, const FramePlan& plan, FrameWork* work) {
  work->taps = ReprojectionTaps(width, height);
  work->staged = StagedHistory(width, height);
  work->light.clear();
  while (work->light.size() < plan.signals.size()) {
    work->light.push_back({LumaImage3(width, height), Image1(width, height), Image1()});
  }
  work->spare = SignalHistory(width, height, plan.layout.with_compressed, plan.layout.with_behind,
                              work->border);
  work->spare_is_empty = true;
  work->scratch = Image3(width, height);
  work->picture = Image3(width, height);
}

}  // namespace

size_t FrameWork::bytes() const {
  size_t sum = taps.bytes() + staged.bytes() + spare.bytes() + scratch.bytes() + picture.bytes() +
               fill_guides.bytes() + firefly.bytes() + mirror.bytes() + coarse.bytes();
  for (const ComparedPlanes& planes : compared) {
    sum += planes.bytes();
  }
  for (const NewLight& of_signal : light) {
    sum += of_signal.bytes();
  }
  for (const SignalHistory& signal : merged) {
    sum += signal.bytes();
  }
  for (const WaveletPlanes& planes : wavelet) {
    sum += planes.bytes();
  }
  return sum;
}

void MakeRoom(const FramePlan& plan, int width, int height, FrameWork* work) {
  const int before = work->border;
  work->border = std::max(plan.border, before);
  const bool has_planes = HasPlanes(*work, width, height, plan);
  if (!has_planes) {
    MakePlanes(width, height, plan, work);
  }
  if (!has_planes || before != work->border) {
    work->wavelet.clear();
    while (work->wavelet.size() < plan.signals.size()) {
      work->wavelet.emplace_back(width, height, work->border);
    }
  }
  const bool with_factors = plan.layout.with_compressed || plan.runs.estimate_variance;
  for (WaveletPlanes& planes : work->wavelet) {
    if (with_factors == planes.luminance_factor.empty()) {
      planes.luminance_factor = with_factors ? Image1(width, height, work->border) : Image1();
    }
  }
  SetBorder(work->border, &work->spare);
}

bool FitHistory(const FramePlan& plan, int width, int height, int border, History* history) {
  const size_t signals = plan.signals.size();
  const bool begins_anew = !history->Fits(width, height, signals, plan.layout);
  if (begins_anew) {
    *history = History(width, height, signals, plan.layout, border);
  }
  const GuidePlanes& guides = history->guides;
  if (guides.id.width() != width || guides.inverse_depth.border() != border) {
    GuidePlanes wider(width, height, border);
    CopyGuides(guides, &wider);
    history->guides = std::move(wider);
  }
  for (SignalHistory& signal : history->signals) {
    SetBorder(border, &signal);
  }
  return begins_anew;
}

}  // namespace stillray
