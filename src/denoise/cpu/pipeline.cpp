// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// clang-format off
// The order of the stages. One frame:
//
//   stage                border   reads                          writes               history
//   fill_guides          pyramid  depth, ..., samples            completed guides     known guides   (only where some are unknown)
//   per layer (the surface, and reflections or refractions with virtual guides):
//   select_guides        -        guides of surface and image    guides               (not for the surface)
//   prepare_guides       1        depth, normal, id              guides               kept for the next frame
//   reproject            -        guides of both frames, motion  taps                                        (hold the confidence and the normals of the last frame, if given)
//   per signal:
//     demodulate         -        lights, albedo, samples        new light
//     suppress_fireflies 1        new light                      new light
//     limit_history      wavelet  new light, taps, last history  ratio, bias          (all signals at once, at half the resolution)
//     accumulate         -        new light, taps, last history  history              colour, moments, length
//     merge_future       -        history, later frames          merged history       (only where the future is known)
//   estimate_variance    3        histories, guides              variances
//   smooth_variance      1        variance                       variance             (signal by signal; prefilter_variance=once)
//   per level:
//     atrous (pilot)     1, 2     colour, variance, guides       pilot                (first and second level)
//     prefilter_variance 1        luminance, variance            luminance factors    (signal by signal)
//     atrous             wavelet  colour, variance, guides       colour, variance     colour of the feedback level
//   clip_outliers        1        colour, variance               colour
//   restore_energy     grid       colour before, colour          colour               (at half the resolution)
//   keep_samples         wavelet  new light, colour, history     colour               (only frames of several samples)
//   keep_mirrors         wavelet  new light, colour, roughness   colour               (only where a surface is smooth)
//   restore_detail       3x3 + 7  new light, colour, residual    colour               mean residual, length  (only if on)
//   remodulate           -        colours, albedo, unfiltered    image
//   fxaa                 9        image, length                  image
//   sum_albedo           8        albedos, images                albedo, range        (its antialiased sum is kept for the next frame)
//   spline_coefficients  4        last image, last albedo        coefficients         (only with motion and taa_filter=spline)
//   follow_light         blocks   light, guides, motion          ratio                light per block      (not before the second image)
//   antialias            4x4      image, coefficients, motion    image                kept for the next frame
//
// Stages that run together (fused/fused.h) count as the later one in the timings.
// clang-format on
#include "denoise/cpu/pipeline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/negative_limit.h"
#include "core/pixels.h"
#include "denoise/copy_image.h"
#include "denoise/cpu/detail.h"
#include "denoise/cpu/energy.h"
#include "denoise/cpu/mirrors.h"
#include "denoise/cpu/outputs.h"
#include "denoise/cpu/samples.h"
#include "denoise/cpu/signals.h"
#include "denoise/cpu/wavelet.h"
#include "denoise/picture_motion.h"
#include "denoise/stage_timer.h"

namespace stillray {
namespace {

/// Guides, emission and background of the frame, completed by fill_guides if some are unknown.
FrameInput InputOf(const CpuPipeline& p, const Frame& frame, HeldGuides* held, FillGuidesWork* work,
                   DenoisedFrame* out) {
  float negative_limit = 0;
  {
    const StageTimer timer(&out->timings, "demodulate");
    negative_limit = NegativeLimitOf(frame, p.plan.is_sparse);
  }
  if (!p.plan.runs.fill_guides) {
    if (!held->empty()) {
      *held = HeldGuides();
    }
    return {frame,
            frame.guides,
            frame.guides,
            frame.emission,
            frame.background,
            frame.guides.roughness,
            frame.guides.previous_normal,
            negative_limit};
  }
  const StageTimer timer(&out->timings, "fill_guides");
  FillGuides(frame, p.stages, held, work);
  return {frame,
          held->guides,
          held->guides,
          held->emission,
          held->background,
          frame.guides.roughness,
          frame.guides.previous_normal,
          negative_limit};
}

/// The input of a layer of reflected or refracted light.
FrameInput RunSelectGuides(const CpuPipeline& p, const FrameInput& in, GuideSource source,
                           Guides* selected, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "select_guides");
  const SelectGuidesInput given = {&in.guides, &ImageOf(in.frame, source), &in.roughness,
                                   &SurfaceAlbedoOf(in.guides, source), &in.previous_normal};
  p.stages.select_guides(given, p.plan.select_guides, selected,
                         &SurfaceAlbedoOf(*selected, source));
  return {in.frame,
          *selected,
          in.surface,
          in.emission,
          in.background,
          selected->roughness,
          selected->previous_normal,
          in.negative_limit};
}

int64_t CountNan(const Image1& plane) {
  int64_t count = 0;
  for (int y = 0; y < plane.height(); ++y) {
    const float* row = plane.Row(y);
    count += std::count_if(row, row + plane.width(), [](float v) { return std::isnan(v); });
  }
  return count;
}

/// \param history  [in,out] its guides are replaced by those of this frame
void FindTaps(const CpuPipeline& p, const FrameInput& in, int border, LayerHistory* history,
              ReprojectionTaps* taps, DenoisedFrame* out) {
  std::swap(history->guides, history->previous_guides);
  GuidePlanes& guides = history->guides;
  const bool packs_normals = PacksNormals(p.plan.normals);
  if (guides.inverse_depth.border() != border || guides.id.empty() ||
      guides.packs_normals() != packs_normals) {
    guides = GuidePlanes(in.frame.width, in.frame.height, border, packs_normals);
  }
  const bool with_turn2 = p.plan.atrous.edges.curvature > 0;
  if (with_turn2 == guides.turn2.empty()) {
    guides.turn2 = with_turn2 ? Image1(in.frame.width, in.frame.height) : Image1();
  }
  const Guides& g = in.guides;
  const PrepareGuidesInput given = {&g.depth, &g.normal, g.id.empty() ? nullptr : &g.id};
  const Image1& confidence = in.frame.confidence;
  taps->confidence = confidence.empty() ? nullptr : &confidence;
  taps->previous_normal = in.previous_normal.empty() ? nullptr : &in.previous_normal;
  out->bad_guides += CountNan(confidence);
  const StageTimer timer(&out->timings, p.plan.runs.reproject ? "reproject" : "prepare_guides");
  if (p.fusion.prepare_and_find_taps) {
    out->bad_guides += cpu::PrepareAndFindTaps(given, history->previous_guides, g.motion,
                                               p.plan.reproject, &guides, taps);
    return;
  }
  out->bad_guides += p.stages.prepare_guides(given, &guides);
  if (p.plan.runs.reproject) {
    p.stages.find_taps(guides, history->previous_guides, g.motion, p.plan.reproject, taps);
  }
}

/// Calls then(i) for each signal once its new samples and the limit of its history are computed.
template <typename Then>
void ForEachSignal(const CpuPipeline& p, const FrameInput& in, LayerHistory* history,
                   LayerWork* work, FrameOutputs* outputs, DenoisedFrame* out, const Then& then) {
  const size_t count = p.plan.signals.size();
  const bool together = p.plan.runs.limit_history;
  for (size_t i = 0; together && i < count; ++i) {
    GatherLight(p, in, i, history, work, outputs, out);
  }
  if (together) {
    RunLimitHistory(p, in, *history, work, outputs, out);
  }
  for (size_t i = 0; i < count; ++i) {
    if (!together) {
      GatherLight(p, in, i, history, work, outputs, out);
    }
    then(i);
  }
}

/// All stages of a layer from its guides to its filtered signals.
/// \param future  one history per signal of the layer
void FilterLayer(const CpuPipeline& p, const FrameInput& in, std::span<const SignalHistory> future,
                 LayerHistory* history, LayerWork* work, FrameOutputs* outputs,
                 DenoisedFrame* out) {
  FindTaps(p, in, work->border, history, &work->taps, out);
  ForEachSignal(p, in, history, work, outputs, out, [&](size_t i) {
    RunAccumulate(p, i, history, work, out);
    KeepAlpha(p, i, *history, *work, outputs);
    SignalHistory* known = &history->signals[i];
    if (p.plan.runs.merge_future) {
      known = RunMergeFuture(p, i, *known, future[i], work, out);
    }
    BeginFilter(p, in, i, known, work, outputs);
  });
  if (p.plan.runs.wavelet) {
    RunWavelet(p, in, history->guides, work, outputs, out);
    RunRestoreEnergy(p, in, history->guides, work, out);
  }
  if (p.plan.runs.keep_samples) {
    RunKeepSamples(p, history->guides, work, out);
  }
  if (p.plan.runs.keep_mirrors) {
    RunKeepMirrors(p, in, history->guides, work, out);
  }
  if (p.plan.runs.restore_detail) {
    RunRestoreDetail(p, history, work, out);
  } else {
    history->residuals.clear();
  }
  for (size_t i = 0; i < work->wavelet.size(); ++i) {
    outputs->KeepLight("filtered", p.plan.signals[i], *work->wavelet[i].light);
  }
}

/// Calls run(layer, pipeline, in) for each layer, with the pipeline of the layer's signals and its
/// input.
template <typename Run>
void ForEachLayer(const CpuPipeline& p, const FrameInput& in, FrameWork* work, DenoisedFrame* out,
                  const Run& run) {
  for (size_t i = 0; i < p.plan.layers.count; ++i) {
    const PlannedLayer& layer = p.plan.layers.layer[i];
    const FramePlan plan = PlanOfLayer(p.plan, layer);
    const CpuPipeline of_layer = {p.stages, plan, p.fusion, p.outputs};
    if (layer.guides == GuideSource::kSurface) {
      run(i, of_layer, in);
    } else {
      run(i, of_layer, RunSelectGuides(of_layer, in, layer.guides, &work->layers[i].selected, out));
    }
  }
}

/// The terms of the output image: filtered signals, emission and background.
struct Picture {
  std::array<SignalLight, kMostGroups> filtered;
  std::array<const Image3*, 2> unfiltered = {};
  PictureParts parts;
};

/// The guides of a layer.
const Guides& GuidesOf(const FramePlan& plan, const FrameInput& in, const FrameWork& work,
                       size_t layer) {
  return plan.layers.layer[layer].guides == GuideSource::kSurface ? in.guides
                                                                  : work.layers[layer].selected;
}

/// Adds the filtered signals of a layer.
void AddLayer(const CpuPipeline& p, const Guides& guides, const PlannedLayer& layer,
              LayerWork* work, Picture* picture) {
  for (size_t i = 0; i < layer.count; ++i) {
    WaveletPlanes& planes = work->wavelet[i];
    LumaImage3* light = planes.light;
    if (p.plan.runs.compress_light) {
      LumaImage3* expanded = &planes.filter[planes.target].colour;
      CopyImage(*light, expanded);
      p.stages.expand_light(expanded);
      light = expanded;
    }
    picture->filtered[layer.first + i] = {
        light, AlbedosOf(p.plan.demodulate, p.plan.signals[layer.first + i], guides)};
  }
}

void FindParts(const CpuPipeline& p, const FrameInput& in, FrameWork* work, Picture* picture) {
  size_t unfiltered = 0;
  for (const Image3* image : {&in.emission, &in.background}) {
    if (!image->empty()) {
      picture->unfiltered[unfiltered++] = image;
    }
  }
  for (size_t i = 0; i < p.plan.layers.count; ++i) {
    AddLayer(p, GuidesOf(p.plan, in, *work, i), p.plan.layers.layer[i], &work->layers[i], picture);
  }
  picture->parts = {{picture->filtered.data(), p.plan.signals.size()},
                    {picture->unfiltered.data(), unfiltered},
                    {p.plan.demodulate.luminance_rec601 != 0, /*add=*/false}};
}

void RunRemodulate(const CpuPipeline& p, const PictureParts& parts, FrameOutputs* outputs,
                   Image3* picture, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "remodulate");
  out->non_finite +=
      p.stages.remodulate(parts.signals, parts.unfiltered, parts.remodulate, picture);
  outputs->AddUnfiltered(parts.unfiltered);
}

void KeepDisocclusion(const CpuPipeline& p, const GuidePlanes& guides, const ReprojectionTaps& taps,
                      DenoisedFrame* out) {
  Image1 mask(guides.id.width(), guides.id.height());
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      const bool surface = guides.inverse_depth(x, y) > 0;
      const bool found = p.plan.runs.reproject && taps.HasHistory(x, y);
      mask(x, y) = surface && !found ? 1.0f : 0.0f;
    }
  }
  out->images.push_back({"disocclusion", {std::move(mask)}});
}

void RunFxaa(const CpuPipeline& p, const Image1& length, Image3* picture, Image3* scratch,
             DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "fxaa");
  p.stages.fxaa(*picture, p.plan.fxaa.fxaa_sparse != 0 ? &length : nullptr, scratch);
  std::swap(*picture, *scratch);
}

Image1* ImagesOf(GuideSource source, FrameWork* work) {
  return source == GuideSource::kReflection ? &work->images : &work->refracted_images;
}

/// Finds the pixels with virtual images.
void FindShownImages(const FramePlan& plan, const FrameInput& in, FrameWork* work) {
  for (size_t i = 0; i < plan.layers.count; ++i) {
    const GuideSource source = plan.layers.layer[i].guides;
    if (source != GuideSource::kSurface) {
      FindImages(in.guides, work->layers[i].selected, SurfaceAlbedoOf(in.guides, source),
                 OtherAlbedoOf(in.guides, source), ImagesOf(source, work));
    }
  }
}

/// The motion of each pixel's visible surface or virtual image, after FindShownImages.
const Image2& PictureMotion(const FramePlan& plan, const FrameInput& in, FrameWork* work) {
  if (plan.layers.count == 1) {
    return in.guides.motion;
  }
  work->motion = in.guides.motion;
  for (size_t i = 0; i < plan.layers.count; ++i) {
    const GuideSource source = plan.layers.layer[i].guides;
    if (source != GuideSource::kSurface) {
      FollowImages(*ImagesOf(source, work), in.guides, work->layers[i].selected.motion,
                   &work->motion);
    }
  }
  return work->motion;
}

/// The history length of each pixel's visible surface or virtual image, after FindShownImages.
const Image1& PictureLength(const FramePlan& plan, const History& history, FrameWork* work) {
  const Image1& of_surface = history.layers.front().signals.front().length;
  if (plan.antialias.image_length == 0) {
    return of_surface;
  }
  work->length = of_surface;
  for (size_t i = 0; i < plan.layers.count; ++i) {
    const GuideSource source = plan.layers.layer[i].guides;
    if (source != GuideSource::kSurface) {
      TakeLengths(*ImagesOf(source, work), history.layers[i].signals.front().length, &work->length);
    }
  }
  return work->length;
}

/// Whether any pixel has motion.
bool Moves(const Image2& motion) {
  return AnyPixel(motion, [](float v) { return v != 0; });
}

/// The albedo of reflected light; where virtual images are visible, times that of the reflected
/// surface.
const Image3& ReflectedAlbedo(const CpuPipeline& p, const Guides& guides, const FrameWork& work) {
  for (size_t i = 0; p.plan.antialias.image_albedo != 0 && i < p.plan.layers.count; ++i) {
    if (p.plan.layers.layer[i].guides == GuideSource::kReflection) {
      return work.layers[i].selected.specular_albedo;
    }
  }
  return guides.specular_albedo;
}

/// Runs sum_albedo, after FindShownImages.
void RunSumAlbedo(const CpuPipeline& p, const Guides& guides, FrameWork* work) {
  std::array<const Image3*, 3> given = {};
  size_t count = 0;
  for (const Image3* albedo :
       {&guides.albedo, &ReflectedAlbedo(p, guides, *work), &guides.transmission_albedo}) {
    if (!albedo->empty()) {
      given[count++] = albedo;
    }
  }
  const Image1* images = p.plan.antialias.image_albedo != 0 ? &work->images : nullptr;
  p.stages.sum_albedo({given.data(), count}, images, &work->albedo);
}

/// \return the ratio of the radiance to that of the last frame, per block
const Image1* RunFollowLight(const CpuPipeline& p, const FrameInput& in, const PictureParts& parts,
                             const Image2& picture_motion, History* history, FrameWork* work) {
  const LayerHistory& surface = history->layers.front();
  const FollowLightInput given = {parts,
                                  static_cast<size_t>(p.plan.antialias.follow_light),
                                  in.guides.motion,
                                  picture_motion,
                                  surface.guides,
                                  surface.signals.front().length,
                                  in.frame.samples.empty() ? nullptr : &in.frame.samples,
                                  p.plan.has_followed ? &history->followed : nullptr};
  CompareBlocks(given, &work->followed_blocks, &work->followed);
  p.stages.follow_light(work->followed_blocks, &work->ratio);
  std::swap(history->followed, work->followed);
  return &work->ratio;
}

/// Stores the antialiased image in the history.
void RunAntialias(const CpuPipeline& p, const FrameInput& in, const PictureParts& parts,
                  History* history, FrameWork* work, Image3* colour, DenoisedFrame* out) {
  const StageTimer timer(&out->timings, "antialias");
  const LayerHistory& surface = history->layers.front();
  Image3* scratch = &work->layers.front().scratch;
  FindShownImages(p.plan, in, work);
  AntialiasInput antialias = {history->picture, PictureMotion(p.plan, in, work), surface.guides};
  const bool resamples = p.plan.antialias.resampling == kSpline && Moves(antialias.motion);
  if (resamples) {
    p.stages.spline_coefficients(history->picture, &work->spline);
    antialias.spline = &work->spline;
  }
  AntialiasTexture texture = {.albedo = work->albedo, .out = &work->albedo_out};
  if (p.plan.antialias.clamp_light != 0) {
    RunSumAlbedo(p, in.guides, work);
    antialias.texture = &texture;
  }
  if (p.plan.has_albedo) {
    texture.before = &history->albedo;
    texture.depth_before = &surface.previous_guides.inverse_depth;
    if (resamples) {
      p.stages.spline_coefficients(history->albedo, &work->albedo_spline);
      texture.spline = &work->albedo_spline;
    }
  }
  if (p.plan.antialias.follow_light != 0) {
    antialias.ratio = RunFollowLight(p, in, parts, antialias.motion, history, work);
  }
  if (p.plan.antialias.weigh_by_length != 0) {
    antialias.length = &PictureLength(p.plan, *history, work);
    antialias.samples = in.frame.samples.empty() ? nullptr : &in.frame.samples;
    antialias.confidence = in.frame.confidence.empty() ? nullptr : &in.frame.confidence;
  }
  antialias.copy = colour;
  if (p.fusion.antialias_parts) {
    out->non_finite += cpu::AntialiasParts(parts, antialias, p.plan.antialias, scratch);
  } else {
    p.stages.antialias(work->picture, antialias, p.plan.antialias, scratch);
  }
  std::swap(history->picture, *scratch);
  if (p.plan.antialias.clamp_light != 0) {
    std::swap(history->albedo, work->albedo_out);
  }
}

}  // namespace

void RunFrame(const CpuPipeline& p, const Frame& frame, std::span<const SignalHistory> future,
              History* history, FrameWork* work, Image3* colour, DenoisedFrame* out) {
  const FramePlan& plan = p.plan;
  FrameOutputs outputs(p.outputs, p.stages, plan.demodulate, out);
  out->bad_guides = 0;
  const FrameInput in = InputOf(p, frame, &history->held, &work->fill_guides, out);
  ForEachLayer(
      p, in, work, out, [&](size_t i, const CpuPipeline& of_layer, const FrameInput& layer_in) {
        const PlannedLayer& layer = plan.layers.layer[i];
        const auto known = future.empty() ? future : future.subspan(layer.first, layer.count);
        FilterLayer(of_layer, layer_in, known, &history->layers[i], &work->layers[i], &outputs,
                    out);
      });
  const LayerHistory& surface = history->layers.front();
  LayerWork& surface_work = work->layers.front();
  Picture picture;
  FindParts(p, in, work, &picture);
  if (!p.fusion.antialias_parts) {
    RunRemodulate(p, picture.parts, &outputs, &work->picture, out);
  }
  if (outputs.Wants("disocclusion")) {
    KeepDisocclusion(p, surface.guides, surface_work.taps, out);
  }
  outputs.KeepPicture("aliased", work->picture);
  if (plan.runs.fxaa) {
    RunFxaa(p, surface.signals.front().length, &work->picture, &surface_work.scratch, out);
  }
  if (plan.has_picture) {
    RunAntialias(p, in, picture.parts, history, work, colour, out);
  } else {
    std::swap(history->picture, work->picture);
    if (plan.after.has_albedo) {
      const StageTimer timer(&out->timings, "antialias");
      FindShownImages(plan, in, work);
      RunSumAlbedo(p, in.guides, work);
      std::swap(history->albedo, work->albedo.sum);
    }
    if (colour != nullptr) {
      CopyImage(history->picture, colour);
    }
  }
  outputs.Finish();
}

void RunBackward(const CpuPipeline& p, const Frame& frame, History* history, FrameWork* work,
                 std::vector<SignalHistory>* future) {
  DenoisedFrame unused;
  FrameOutputs outputs(p.outputs, p.stages, p.plan.demodulate, &unused);
  const FrameInput in = InputOf(p, frame, &history->held, &work->fill_guides, &unused);
  ForEachLayer(
      p, in, work, &unused, [&](size_t i, const CpuPipeline& of_layer, const FrameInput& layer_in) {
        LayerHistory* of_signals = &history->layers[i];
        LayerWork* layer = &work->layers[i];
        FindTaps(of_layer, layer_in, layer->border, of_signals, &layer->taps, &unused);
        ForEachSignal(of_layer, layer_in, of_signals, layer, &outputs, &unused, [&](size_t signal) {
          future->push_back(ShortenedHistory(of_layer, signal, *of_signals, *layer));
          RunAccumulate(of_layer, signal, of_signals, layer, &unused);
        });
      });
}

}  // namespace stillray
