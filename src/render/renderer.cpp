// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/render.h"

#include <algorithm>
#include <new>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "core/colour.h"
#include "render/base_colour.h"
#include "render/create_renderer.h"
#include "render/frame_store.h"
#include "render/lens_guides_shared.h"
#include "render/moment.h"
#include "render/pixel_order.h"
#include "render/previous_normals.h"
#include "render/scene_check.h"
#include "render/shadow_filter.h"
#include "render/virtual_image.h"

namespace stillray::render {
namespace {

/// Per-thread buffers for rendering one batch of pixels, reused in the next frame.
struct TileScratch {
  std::vector<PixelPosition> order;  // pixels of a region to trace
  PixelPosition positions[kBatchCapacity];
  int count = 0;
  vec2 points[kBatchCapacity];
  vec2 lenses[kBatchCapacity];
  PathSampler samplers[kBatchCapacity];
  PrimaryPixel pixels[kBatchCapacity];
  PixelGuides guides[kBatchCapacity];
  LensGuides lens_guides[kBatchCapacity];  // sums over the samples, with a lens
  FirstSurface first[kBatchCapacity];
  bool separates[kBatchCapacity];  // see PixelGuides
  ImageBatch images;
  SampleLight sum[kBatchCapacity];
  SampleSquares square[kBatchCapacity];
  PathScratch paths;
  RenderTimings timings;
};
static_assert(kTileSize * kTileSize <= kBatchCapacity);

/// The albedo by which a SignalKind is demodulated.
vec3 AlbedoOf(const PixelGuides& guides, int kind) {
  if (kind >= kDirectTransmission) {
    return guides.transmission_albedo;
  }
  return kind >= kDirectSpecular ? guides.specular_albedo : guides.albedo;
}

void AddSamples(int count, int signals, bool with_squares, TileScratch* scratch) {
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < signals; ++k) {
      const auto kind = static_cast<size_t>(k);
      const vec3 light = scratch->paths.light[i][kind];
      scratch->sum[i][kind] += light;
      if (with_squares) {
        const float l = Luminance709(Demodulate(light, AlbedoOf(scratch->guides[i], k)));
        scratch->square[i][kind] += l * l;
      }
    }
  }
}

LensGuides OneSample(const PixelGuides& guides) {
  LensGuides one;
  one.albedo = guides.albedo;
  one.depth = guides.depth;
  one.specular_albedo = guides.specular_albedo;
  one.roughness = guides.roughness;
  one.emission = guides.emission;
  one.motion_x = guides.motion.x;
  one.background = guides.background;
  one.motion_y = guides.motion.y;
  one.normal = guides.normal;
  one.id = guides.id;
  one.samples = one.members = one.votes = 1;
  one.unused_0 = 0;
  one.previous_normal = guides.previous_normal;
  one.unused_1 = 0;
  return one;
}

PixelGuides ToGuides(const LensGuides& mean) {
  PixelGuides guides;
  guides.depth = mean.depth;
  guides.normal = mean.normal;
  guides.albedo = mean.albedo;
  guides.specular_albedo = mean.specular_albedo;
  guides.motion = vec2(mean.motion_x, mean.motion_y);
  guides.id = mean.id;
  guides.roughness = mean.roughness;
  guides.emission = mean.emission;
  guides.background = mean.background;
  guides.previous_normal = mean.previous_normal;
  return guides;
}

/// Maps the progress 0..1 of a part to begin..end of the whole call.
RenderProgress PartOfProgress(const RenderProgress& progress, double begin, double end) {
  if (!progress) {
    return {};
  }
  return [&progress, begin, end](double part) { return progress(begin + part * (end - begin)); };
}

void AddTimings(const RenderTimings& part, RenderTimings* sum) {
  sum->clear_ms += part.clear_ms;
  sum->primary_ms += part.primary_ms;
  sum->bounce_ms += part.bounce_ms;
  sum->image_ms += part.image_ms;
  sum->shadow_ms += part.shadow_ms;
  sum->shade_ms += part.shade_ms;
  sum->primary_rays += part.primary_rays;
  sum->bounce_rays += part.bounce_rays;
  sum->image_rays += part.image_rays;
  sum->shadow_rays += part.shadow_rays;
  sum->dropped += part.dropped;
}

class PathTracer final : public Renderer {
 public:
  PathTracer(const Scene& scene, const RenderSettings& settings)
      : settings_(settings),
        any_transmission_(AnyTransmission(scene)),
        images_(ImagesOfScene(scene)),
        masks_(scene),
        state_(scene),
        bsdfs_(scene, settings.regularise),
        lights_(state_),
        filter_(state_) {}

  Status Build(const WrapAccel& wrap_accel, const KeepGoing& keep_going);
  Status SetSettings(const RenderSettings& settings) override;
  const RenderSettings& settings() const override { return settings_; }
  const RenderTimings& timings() const override { return timings_; }
  size_t memory_bytes() const override {
    return accel_->memory_bytes() + state_.memory_bytes() + lights_.memory_bytes() +
           bsdfs_.memory_bytes();
  }

 private:
  Status TraceFrame(const RenderMoment& moment, Frame* frame,
                    const RenderProgress& progress) override;
  Status TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                        const RenderProgress& progress) override;
  Result<TraceContext> MoveTo(const RenderMoment& moment);
  Status RenderWhole(const TraceContext& context, const RenderMoment& moment, Frame* frame,
                     const RenderProgress& progress);
  Status RenderPart(const TraceContext& context, const RenderMoment& moment, Frame* frame,
                    const RenderProgress& progress);
  void TakeTile(const Tile& tile, TileScratch* scratch) const;
  const vec2* ChooseLensPoints(const TraceContext& context, TileScratch* scratch) const;
  void FindGuides(const TraceContext& context, const Frame& frame, uint64_t sample,
                  TileScratch* scratch) const;
  ImageKinds ShownImages(const TraceContext& context) const;
  void FindImages(const TraceContext& context, TileScratch* scratch) const;
  /// Whether paths use the base colours of the virtual images.
  bool UsesImages(const TraceContext& context) const {
    return context.filters_textures && ShownImages(context).any();
  }
  void StoreTileGuides(const TraceContext& context, const Tile& tile, TileScratch* scratch,
                       Frame* frame) const;
  void PreparePlanes(const TraceContext& context, const RenderMoment& moment, Frame* frame) const;
  void TraceSamples(const TraceContext& context, const Frame& frame, uint64_t first_sample,
                    TileScratch* scratch) const;
  void RenderRegion(const TraceContext& context, const PixelOrder& order, const Tile& region,
                    TileScratch* scratch, Frame* frame);
  void RenderReferenceTile(const TraceContext& context, int spp, TileScratch* scratch,
                           Image3* radiance) const;
  void MakeSamplers(SampleStream stream, uint64_t sample, TileScratch* scratch) const;
  Status RunTiles(TileSize size, const RenderProgress& progress,
                  const std::function<void(const Tile&, TileScratch*)>& body);

  RenderSettings settings_;
  bool any_transmission_;
  ImageKinds images_;  // virtual images that the scene may contain
  LensMasks masks_;
  SceneState state_;
  BsdfTables bsdfs_;
  LightSet lights_;
  SceneShadowFilter filter_;
  std::unique_ptr<Accel> accel_;
  RenderTimings timings_;
  SparseFrameWriter sparse_;
  tbb::enumerable_thread_specific<std::unique_ptr<TileScratch>> scratch_;
};

Status PathTracer::Build(const WrapAccel& wrap_accel, const KeepGoing& keep_going) {
  state_.Update(0.0, 0.0);
  Result<std::unique_ptr<Accel>> accel = Accel::Create(state_.scene(), DescribeInstances(state_),
                                                       state_.Places(), filter_, keep_going);
  if (!accel.ok()) {
    return accel.status();
  }
  accel_ = wrap_accel ? wrap_accel(std::move(*accel)) : std::move(*accel);
  lights_.Update(true);
  return Status::Ok();
}

Result<TraceContext> PathTracer::MoveTo(const RenderMoment& moment) {
  STILLRAY_RETURN_IF_ERROR(CheckMoment(state_.scene(), moment));
  timings_ = RenderTimings();
  const PhaseTimer timer(&timings_.update_ms);
  const bool moved = state_.Update(moment.seconds, moment.previous_seconds);
  STILLRAY_RETURN_IF_ERROR(CheckPlaces(state_, moment));
  if (moved) {
    STILLRAY_RETURN_IF_ERROR(accel_->Update(state_.Places()));
  }
  lights_.Update(moved);
  CameraPair cameras = CamerasOf(state_, moment, settings_.width, settings_.height);
  const Lens lens = LensOf(state_.scene(), settings_, moment.camera);
  SetLens(state_, lens, &cameras);
  const bool has_lens = cameras.now.lens_radius > 0.0f;
  return TraceContext{state_,
                      bsdfs_,
                      lights_,
                      *accel_,
                      settings_,
                      cameras.now,
                      cameras.before,
                      !any_transmission_,
                      MakeLensArrays(lens, masks_),
                      WantedImages(settings_, images_, has_lens).refraction,
                      FiltersTextures(settings_, state_.scene())};
}

Status PathTracer::SetSettings(const RenderSettings& settings) {
  STILLRAY_RETURN_IF_ERROR(ValidateRenderSettings(settings));
  try {
    if (settings.regularise != settings_.regularise) {
      bsdfs_ = BsdfTables(state_.scene(), settings.regularise);
    }
    settings_ = settings;
    return Status::Ok();
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("changing the settings of the renderer: out of memory");
  }
}

void PathTracer::TakeTile(const Tile& tile, TileScratch* scratch) const {
  scratch->count = tile.count();
  for (int i = 0; i < tile.count(); ++i) {
    scratch->positions[i] = {tile.x0 + i % tile.width, tile.y0 + i / tile.width};
  }
}

void PathTracer::MakeSamplers(SampleStream stream, uint64_t sample, TileScratch* scratch) const {
  const SamplerKind kind = SamplerOf(stream, settings_.sampler, settings_.spp);
  for (int i = 0; i < scratch->count; ++i) {
    const auto [x, y] = scratch->positions[i];
    scratch->samplers[i] = MakePathSampler(kind, settings_.seed, stream, x, y, sample);
  }
}

/// Returns points of the lens for the samples of MakeSamplers; null for a pinhole.
const vec2* PathTracer::ChooseLensPoints(const TraceContext& context, TileScratch* scratch) const {
  if (context.camera.lens_radius <= 0.0f) {
    return nullptr;
  }
  for (int i = 0; i < scratch->count; ++i) {
    const vec4 u = scratch->samplers[i].Get(kLensDimensions);
    scratch->lenses[i] = LensPoint(context.lens, vec2(u.x, u.y));
  }
  return scratch->lenses;
}

/// Traces the primary rays of the batch's pixels and computes their guides; with a lens, for this
/// sample.
void PathTracer::FindGuides(const TraceContext& context, const Frame& frame, uint64_t sample,
                            TileScratch* scratch) const {
  const vec2* lenses = nullptr;
  if (context.camera.lens_radius > 0.0f) {
    MakeSamplers(SampleStream::kFrames, sample, scratch);
    lenses = ChooseLensPoints(context, scratch);
  }
  const vec2 offset(0.5f + frame.jitter_x, 0.5f + frame.jitter_y);
  for (int i = 0; i < scratch->count; ++i) {
    scratch->points[i] = vec2(scratch->positions[i].x, scratch->positions[i].y) + offset;
  }
  RenderTimings* timings = &scratch->timings;
  FindPrimarySurfaces(context, scratch->points, lenses, scratch->count, &scratch->paths.trace,
                      scratch->pixels, timings);
  const PhaseTimer timer(&timings->shade_ms);
  for (int i = 0; i < scratch->count; ++i) {
    scratch->guides[i] = MakeGuides(context, scratch->pixels[i], &scratch->first[i]);
    scratch->separates[i] = scratch->guides[i].separates_transmission();
  }
}

ImageKinds PathTracer::ShownImages(const TraceContext& context) const {
  return WantedImages(settings_, images_, context.camera.lens_radius > 0.0f);
}

/// Finds the virtual images of the batch's pixels, whose guides have been computed.
void PathTracer::FindImages(const TraceContext& context, TileScratch* scratch) const {
  const ImageKinds shown = ShownImages(context);
  if (shown.any()) {
    FindVirtualImages(context, shown, scratch->pixels, scratch->first, scratch->separates,
                      scratch->count, &scratch->paths.trace, &scratch->images, &scratch->timings);
  }
}

void PathTracer::StoreTileGuides(const TraceContext& context, const Tile& tile,
                                 TileScratch* scratch, Frame* frame) const {
  const ImageKinds shown = ShownImages(context);
  if (shown.reflection) {
    StoreVirtualImages(tile, scratch->images.reflection, &frame->reflection);
  }
  if (shown.refraction) {
    StoreVirtualImages(tile, scratch->images.refraction, &frame->refraction);
  }
  const PhaseTimer timer(&scratch->timings.shade_ms);
  StoreGuides(tile, scratch->guides, frame);
}

void PathTracer::PreparePlanes(const TraceContext& context, const RenderMoment& moment,
                               Frame* frame) const {
  PrepareFrame(settings_, moment, context.separates_transmission, frame);
  frame->focal_pixels = FocalPixels(context.camera);
  PreparePreviousNormals(state_, frame);
  PrepareVirtualGuides(settings_, ShownImages(context), frame);
}

/// Traces the paths of the batch's pixels, whose guides in the first sample have been computed.
/// With a lens each sample has different primary hits: guides become means over all samples.
void PathTracer::TraceSamples(const TraceContext& context, const Frame& frame,
                              uint64_t first_sample, TileScratch* scratch) const {
  const bool has_lens = context.camera.lens_radius > 0.0f;
  for (int i = 0; i < scratch->count; ++i) {
    scratch->sum[i].fill(vec3(0.0f));
    scratch->square[i].fill(0.0f);
    scratch->lens_guides[i].samples = 0;
  }
  const auto spp = static_cast<uint64_t>(settings_.spp);
  const auto signals = static_cast<int>(frame.signals.size());
  for (uint64_t s = 0; s < spp; ++s) {
    if (has_lens && s > 0) {
      FindGuides(context, frame, first_sample + s, scratch);
    }
    MakeSamplers(SampleStream::kFrames, first_sample + s, scratch);
    TraceSample(context,
                {.pixels = scratch->pixels,
                 .samplers = scratch->samplers,
                 .first = scratch->first,
                 .images = UsesImages(context) ? &scratch->images : nullptr,
                 .separates = scratch->separates,
                 .count = scratch->count},
                &scratch->paths, &scratch->timings);
    AddSamples(scratch->count, signals, spp > 1, scratch);
    for (int i = 0; i < scratch->count && has_lens; ++i) {
      AddLensSample(scratch->lens_guides[i], OneSample(scratch->guides[i]));
    }
  }
  for (int i = 0; i < scratch->count && has_lens; ++i) {
    scratch->guides[i] = ToGuides(MeanOfLensSamples(scratch->lens_guides[i]));
  }
}

void PathTracer::RenderRegion(const TraceContext& context, const PixelOrder& order,
                              const Tile& region, TileScratch* scratch, Frame* frame) {
  {
    const PhaseTimer timer(&scratch->timings.clear_ms);
    sparse_.Clear(region, frame);
    order.Collect(region, &scratch->order);
  }
  for (size_t done = 0; done < scratch->order.size(); done += kBatchCapacity) {
    const size_t count = std::min(scratch->order.size() - done, size_t{kBatchCapacity});
    std::copy_n(scratch->order.begin() + static_cast<ptrdiff_t>(done), count, scratch->positions);
    scratch->count = static_cast<int>(count);
    const auto sample = static_cast<uint64_t>(order.cycle_index());
    FindGuides(context, *frame, sample, scratch);
    if (UsesImages(context)) {
      FindImages(context, scratch);
    }
    TraceSamples(context, *frame, sample, scratch);
    const PhaseTimer timer(&scratch->timings.shade_ms);
    for (size_t i = 0; i < count; ++i) {
      const auto [x, y] = scratch->positions[i];
      sparse_.Store(region, x, y, scratch->sum[i], scratch->guides[i], frame);
    }
  }
}

void PathTracer::RenderReferenceTile(const TraceContext& context, int spp, TileScratch* scratch,
                                     Image3* radiance) const {
  // Sums over many samples need double precision to keep small contributions.
  std::vector<glm::dvec3> sum(static_cast<size_t>(scratch->count), glm::dvec3(0.0));
  RenderTimings* timings = &scratch->timings;
  for (int s = 0; s < spp; ++s) {
    MakeSamplers(SampleStream::kReference, static_cast<uint64_t>(s), scratch);
    for (int i = 0; i < scratch->count; ++i) {
      vec2 within(0.5f);
      if (settings_.jitter) {
        const vec4 u = scratch->samplers[i].Get(kPrimaryDimensions);
        within = vec2(u.x, u.y);
      }
      scratch->points[i] = vec2(scratch->positions[i].x, scratch->positions[i].y) + within;
    }
    FindPrimarySurfaces(context, scratch->points, ChooseLensPoints(context, scratch),
                        scratch->count, &scratch->paths.trace, scratch->pixels, timings);
    TraceSample(context,
                {.pixels = scratch->pixels, .samplers = scratch->samplers, .count = scratch->count},
                &scratch->paths, timings);
    for (int i = 0; i < scratch->count; ++i) {
      const UnscatteredLight own = FindUnscatteredLight(context, scratch->pixels[i]);
      vec3 light = own.emission + own.background;
      for (const vec3& signal : scratch->paths.light[i]) {
        light += signal;
      }
      sum[static_cast<size_t>(i)] += glm::dvec3(light);
    }
  }
  for (int i = 0; i < scratch->count; ++i) {
    StorePixel(radiance, scratch->positions[i].x, scratch->positions[i].y,
               vec3(sum[static_cast<size_t>(i)] / static_cast<double>(spp)));
  }
}

Status PathTracer::RunTiles(TileSize size, const RenderProgress& progress,
                            const std::function<void(const Tile&, TileScratch*)>& body) {
  const Status status =
      ForEachTile(settings_.width, settings_.height, size, progress, [&](const Tile& tile) {
        std::unique_ptr<TileScratch>& mine = scratch_.local();
        if (!mine) {
          mine = std::make_unique<TileScratch>();
        }
        body(tile, mine.get());
      });
  for (std::unique_ptr<TileScratch>& scratch : scratch_) {
    if (scratch) {
      AddTimings(scratch->timings, &timings_);
      scratch->timings = RenderTimings();
    }
  }
  return status;
}

/// Renders a frame in which every pixel is sampled.
Status PathTracer::RenderWhole(const TraceContext& context, const RenderMoment& moment,
                               Frame* frame, const RenderProgress& progress) {
  sparse_.Forget();
  PreparePlanes(context, moment, frame);
  const uint64_t first_sample =
      static_cast<uint64_t>(moment.frame_index) * static_cast<uint64_t>(settings_.spp);
  return RunTiles(TileSize(), progress, [&](const Tile& tile, TileScratch* scratch) {
    TakeTile(tile, scratch);
    FindGuides(context, *frame, first_sample, scratch);
    FindImages(context, scratch);
    TraceSamples(context, *frame, first_sample, scratch);
    StoreTileGuides(context, tile, scratch, frame);
    const PhaseTimer timer(&scratch->timings.shade_ms);
    StoreLight(tile, settings_.spp, scratch->sum, scratch->square, frame);
  });
}

/// Renders a frame in which some pixels are sampled.
Status PathTracer::RenderPart(const TraceContext& context, const RenderMoment& moment, Frame* frame,
                              const RenderProgress& progress) {
  sparse_.Begin(settings_, *frame);
  PreparePlanes(context, moment, frame);
  const PixelOrder order(settings_.cycle, settings_.seed, moment.frame_index);
  const auto sample = static_cast<uint64_t>(order.cycle_index());
  double done = 0;
  if (settings_.guides == GuideCoverage::kFull) {
    done = 0.5;
    STILLRAY_RETURN_IF_ERROR(RunTiles(TileSize(), PartOfProgress(progress, 0, done),
                                      [&](const Tile& tile, TileScratch* scratch) {
                                        TakeTile(tile, scratch);
                                        FindGuides(context, *frame, sample, scratch);
                                        FindImages(context, scratch);
                                        StoreTileGuides(context, tile, scratch, frame);
                                      }));
  }
  // Full ray packets need the sampled pixels of a large region. With full guides, the primary rays
  // of these pixels are traced a second time, which is cheap compared with the paths.
  STILLRAY_RETURN_IF_ERROR(RunTiles(kSparseRegion, PartOfProgress(progress, done, 1),
                                    [&](const Tile& region, TileScratch* scratch) {
                                      RenderRegion(context, order, region, scratch, frame);
                                    }));
  sparse_.End(*frame);
  return Status::Ok();
}

Status PathTracer::TraceFrame(const RenderMoment& moment, Frame* frame,
                              const RenderProgress& progress) {
  Result<TraceContext> context = MoveTo(moment);
  if (!context.ok()) {
    return context.status();
  }
  STILLRAY_RETURN_IF_ERROR(settings_.cycle > 1 ? RenderPart(*context, moment, frame, progress)
                                               : RenderWhole(*context, moment, frame, progress));
  const PhaseTimer timer(&timings_.shade_ms);
  StorePreviousNormals(state_, frame);
  return Status::Ok();
}

Status PathTracer::TraceReference(const RenderMoment& moment, int spp, Image3* radiance,
                                  const RenderProgress& progress) {
  Result<TraceContext> context = MoveTo(moment);
  if (!context.ok()) {
    return context.status();
  }
  ResizeImage(radiance, settings_.width, settings_.height);
  return RunTiles(TileSize(), progress, [&](const Tile& tile, TileScratch* scratch) {
    TakeTile(tile, scratch);
    RenderReferenceTile(*context, spp, scratch, radiance);
  });
}

}  // namespace

Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 const WrapAccel& wrap_accel,
                                                 const KeepGoing& keep_going) {
  STILLRAY_RETURN_IF_ERROR(ValidateRenderSettings(settings));
  STILLRAY_RETURN_IF_ERROR(CheckScene(scene));
  try {
    auto renderer = std::make_unique<PathTracer>(scene, settings);
    STILLRAY_RETURN_IF_ERROR(renderer->Build(wrap_accel, keep_going));
    return std::unique_ptr<Renderer>(std::move(renderer));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("preparing the scene: out of memory");
  }
}

}  // namespace stillray::render

namespace stillray {

Status Renderer::RenderFrame(const RenderMoment& moment, Frame* frame,
                             const RenderProgress& progress) {
  if (frame == nullptr) {
    return Status::InvalidArgument("frame is null");
  }
  try {
    return TraceFrame(moment, frame, progress);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("rendering a frame: out of memory");
  }
}

Status Renderer::RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                                 const RenderProgress& progress) {
  if (radiance == nullptr) {
    return Status::InvalidArgument("radiance is null");
  }
  if (spp < 1) {
    return Status::InvalidArgument("spp of the reference is " + std::to_string(spp) +
                                   ", expected at least 1");
  }
  try {
    return TraceReference(moment, spp, radiance, progress);
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("rendering a reference: out of memory");
  }
}

Result<std::unique_ptr<Renderer>> Renderer::Create(const Scene& scene,
                                                   const RenderSettings& settings,
                                                   const KeepGoing& keep_going) {
  return render::CreateRenderer(scene, settings, {}, keep_going);
}

}  // namespace stillray
