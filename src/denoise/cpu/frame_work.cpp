// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/frame_work.h"

#include <algorithm>
#include <utility>

#include "denoise/copy_image.h"
#include "denoise/stages/follow_light_shared.h"

namespace stillray {
namespace {

/// Copies the guides that reproject reads; copies nothing if sizes or storage of normals differ.
void CopyGuides(const GuidePlanes& from, GuidePlanes* to) {
  if (from.id.width() != to->id.width() || from.id.height() != to->id.height() ||
      from.packs_normals() != to->packs_normals()) {
    return;
  }
  for (int y = 0; y < from.id.height(); ++y) {
    std::copy_n(from.inverse_depth.Row(y), from.id.width(), to->inverse_depth.Row(y));
    std::copy_n(from.id.Row(y), from.id.width(), to->id.Row(y));
  }
  for (int y = 0; y < to->packed_normal.height(); ++y) {
    std::copy_n(from.packed_normal.Row(y), from.id.width(), to->packed_normal.Row(y));
  }
  CopyImage(from.normal, &to->normal);
}

/// Changes the border of a history's colour planes.
void SetBorder(int border, SignalHistory* history) {
  for (LumaImage3* image : {&history->colour, &history->behind}) {
    if (!image->empty() && (*image)[0].border() != border) {
      LumaImage3 other(image->width(), image->height(), border);
      CopyImage(*image, &other);
      *image = std::move(other);
    }
  }
}

bool HasPlanes(const LayerWork& work, int width, int height, const FramePlan& plan) {
  return work.scratch.width() == width && work.scratch.height() == height &&
         work.light.size() == plan.signals.size() &&
         work.spare.compressed.empty() != plan.layout.with_compressed &&
         work.spare.behind.empty() != plan.layout.with_behind;
}

/// Allocates the planes that do not depend on the border.
void MakePlanes(int width, int height, const FramePlan& plan, LayerWork* work) {
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
}

size_t SelectedBytes(const Guides& g) {
  return g.depth.bytes() + g.normal.bytes() + g.motion.bytes() + g.id.bytes() +
         g.roughness.bytes() + g.previous_normal.bytes() + g.specular_albedo.bytes() +
         g.transmission_albedo.bytes();
}

/// Changes the borders of a layer's history to the widths that the wavelet reads.
void FitLayer(int width, int height, int border, bool packs_normals, LayerHistory* layer) {
  const GuidePlanes& guides = layer->guides;
  if (guides.id.width() != width || guides.inverse_depth.border() != border ||
      guides.packs_normals() != packs_normals) {
    GuidePlanes wider(width, height, border, packs_normals);
    CopyGuides(guides, &wider);
    layer->guides = std::move(wider);
  }
  for (SignalHistory& signal : layer->signals) {
    SetBorder(border, &signal);
  }
}

/// Allocates memory for a layer, if necessary.
void MakeLayerRoom(const FramePlan& plan, int width, int height, LayerWork* work) {
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

}  // namespace

size_t LayerWork::bytes() const {
  size_t sum = SelectedBytes(selected) + taps.bytes() + staged.bytes() + spare.bytes() +
               scratch.bytes() + firefly.bytes() + blended.bytes() + detail.bytes() +
               residual.bytes() + coarse.bytes();
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

size_t FrameWork::bytes() const {
  size_t sum = picture.bytes() + motion.bytes() + images.bytes() + refracted_images.bytes() +
               spline.bytes() + albedo.bytes() + albedo_spline.bytes() + albedo_out.bytes() +
               followed_blocks.bytes() + followed.bytes() + ratio.bytes() + fill_guides.bytes();
  for (const LayerWork& layer : layers) {
    sum += layer.bytes();
  }
  return sum;
}

void MakeRoom(const Image1& like, FilterPlanes* planes) {
  if (planes->variance.width() != like.width() || planes->variance.height() != like.height() ||
      planes->variance.border() != like.border()) {
    *planes = FilterPlanes(like.width(), like.height(), like.border());
  }
}

void MakeRoom(const FramePlan& plan, int width, int height, FrameWork* work) {
  work->layers.resize(plan.layers.count);
  for (size_t i = 0; i < plan.layers.count; ++i) {
    LayerWork& layer = work->layers[i];
    layer.border = std::max(layer.border, work->border());
    MakeLayerRoom(PlanOfLayer(plan, plan.layers.layer[i]), width, height, &layer);
  }
  if (work->picture.width() != width || work->picture.height() != height) {
    work->picture = Image3(width, height);
  }
  if (plan.antialias.resampling == kSpline &&
      (work->spline.width() != width || work->spline.height() != height)) {
    work->spline = Image3(width, height);
  }
  if (plan.antialias.clamp_light != 0 &&
      (work->albedo.sum.width() != width || work->albedo.sum.height() != height)) {
    work->albedo = SummedAlbedo(width, height);
    work->albedo_spline = Image3(width, height);
    work->albedo_out = Image3(width, height);
  }
  const bool resized =
      work->ratio.width() != FollowSize(width) || work->ratio.height() != FollowSize(height);
  if (plan.antialias.follow_light != 0 && resized) {
    work->followed_blocks = FollowedBlocks(width, height);
    work->followed = Image1(FollowSize(width), FollowSize(height));
    work->ratio = Image1(FollowSize(width), FollowSize(height));
  }
}

bool FitHistory(const FramePlan& plan, int width, int height, int border, History* history) {
  const bool begins_anew = !history->Fits(width, height, plan.layers, plan.layout);
  if (begins_anew) {
    *history = History(width, height, plan.layers, plan.layout, border);
  }
  for (LayerHistory& layer : history->layers) {
    FitLayer(width, height, border, PacksNormals(plan.normals), &layer);
  }
  if (plan.antialias.clamp_light == 0) {
    history->albedo = Image3();
  } else if (history->albedo.empty()) {
    history->albedo = Image3(width, height);
  }
  if (plan.antialias.follow_light == 0) {
    history->followed = Image1();
  } else if (history->followed.empty()) {
    history->followed = Image1(FollowSize(width), FollowSize(height));
  }
  return begins_anew;
}

}  // namespace stillray
