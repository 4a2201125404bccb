// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/render.h"

#include <new>
#include <optional>

#include <tbb/enumerable_thread_specific.h>

#include "core/colour.h"
#include "render/create_renderer.h"
#include "render/guides.h"
#include "render/integrator.h"
#include "render/scene_check.h"
#include "render/tiles.h"

namespace stillray::render {
namespace {

// What a thread needs to render one tile; kept for the next frame.
struct TileScratch {
  vec2 points[kBatchCapacity];
  PathSampler samplers[kBatchCapacity];
  PrimaryPixel pixels[kBatchCapacity];
  PixelGuides guides[kBatchCapacity];
  FirstSurface first[kBatchCapacity];
  SampleLight sum[kBatchCapacity];
  std::array<float, kTracedSignalCount> square[kBatchCapacity];
  PathScratch paths;
  RenderTimings timings;
};
static_assert(kTileSize * kTileSize <= kBatchCapacity);

// Shadow rays pass alpha cut-outs, blended surfaces and smooth thin sheets.
class SceneShadowFilter final : public ShadowFilter {
 public:
  explicit SceneShadowFilter(const SceneState& state) : state_(state) {}

  vec3 Transmittance(const Hit& hit, vec3 direction) const override {
    const float opacity = state_.Opacity(hit);
    vec3 through(1.0f - opacity);
    const PlacedInstance& instance = state_.instance(hit.instance);
    if (opacity > 0.0f && instance.material->transmission > 0.0f && !instance.material->solid) {
      const Triangle t = state_.TriangleOf(instance, hit.primitive);
      const vec3 normal = SafeNormalize(cross(t.p1 - t.p0, t.p2 - t.p0), direction);
      through += opacity * SheetTransmittance(state_, hit, dot(normal, direction));
    }
    return through;
  }

 private:
  const SceneState& state_;
};

std::vector<AccelInstance> DescribeInstances(const SceneState& state) {
  std::vector<AccelInstance> out(state.instances().size());
  for (size_t i = 0; i < out.size(); ++i) {
    const PlacedInstance& instance = state.instances()[i];
    out[i].moving = instance.moving;
    out[i].see_through =
        !instance.opaque || (instance.material->transmission > 0.0f && !instance.material->solid);
  }
  return out;
}

template <typename P>
void Prepare(P* image, int width, int height) {
  if (image->width() != width || image->height() != height) {
    *image = P(width, height);
  }
}

void PrepareFrame(const RenderSettings& settings, Frame* frame) {
  const int w = settings.width;
  const int h = settings.height;
  frame->width = w;
  frame->height = h;
  frame->signals.resize(kTracedSignalCount);
  for (int k = 0; k < kTracedSignalCount; ++k) {
    Signal& signal = frame->signals[static_cast<size_t>(k)];
    signal.kind = static_cast<SignalKind>(k);
    Prepare(&signal.radiance, w, h);
    if (settings.spp > 1) {
      Prepare(&signal.second_moment, w, h);
    } else {
      signal.second_moment = Image1();
    }
  }
  Prepare(&frame->guides.depth, w, h);
  Prepare(&frame->guides.normal, w, h);
  Prepare(&frame->guides.albedo, w, h);
  Prepare(&frame->guides.specular_albedo, w, h);
  Prepare(&frame->guides.motion, w, h);
  Prepare(&frame->guides.id, w, h);
  Prepare(&frame->guides.roughness, w, h);
  Prepare(&frame->emission, w, h);
  Prepare(&frame->background, w, h);
  if (settings.spp > 1) {
    Prepare(&frame->samples, w, h);
    frame->samples.Fill(static_cast<float>(settings.spp));
  } else {
    frame->samples = Image1();
  }
}

void Store(Image3* image, int x, int y, vec3 value) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

void StoreGuides(const PixelGuides& guides, int x, int y, Frame* frame) {
  frame->guides.depth(x, y) = guides.depth;
  Store(&frame->guides.normal, x, y, guides.normal);
  Store(&frame->guides.albedo, x, y, guides.albedo);
  Store(&frame->guides.specular_albedo, x, y, guides.specular_albedo);
  frame->guides.motion[0](x, y) = guides.motion.x;
  frame->guides.motion[1](x, y) = guides.motion.y;
  frame->guides.id(x, y) = guides.id;
  frame->guides.roughness(x, y) = guides.roughness;
  Store(&frame->emission, x, y, guides.emission);
  Store(&frame->background, x, y, guides.background);
}

bool IsSpecular(int kind) {
  return static_cast<SignalKind>(kind) == SignalKind::kDirectSpecular ||
         static_cast<SignalKind>(kind) == SignalKind::kIndirectSpecular;
}

void AddSamples(int count, bool with_squares, TileScratch* scratch) {
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < kTracedSignalCount; ++k) {
      const auto kind = static_cast<size_t>(k);
      const vec3 light = scratch->paths.light[i][kind];
      scratch->sum[i][kind] += light;
      if (with_squares) {
        const vec3 albedo =
            IsSpecular(k) ? scratch->guides[i].specular_albedo : scratch->guides[i].albedo;
        const float l = Luminance709(Demodulate(light, albedo));
        scratch->square[i][kind] += l * l;
      }
    }
  }
}

void StoreLight(const Tile& tile, int spp, const TileScratch& scratch, Frame* frame) {
  const float scale = 1.0f / static_cast<float>(spp);
  for (int i = 0; i < tile.count(); ++i) {
    const int x = tile.x0 + i % tile.width;
    const int y = tile.y0 + i / tile.width;
    for (size_t k = 0; k < kTracedSignalCount; ++k) {
      Store(&frame->signals[k].radiance, x, y, scratch.sum[i][k] * scale);
      if (spp > 1) {
        frame->signals[k].second_moment(x, y) = scratch.square[i][k] * scale;
      }
    }
  }
}

void AddTimings(const RenderTimings& part, RenderTimings* sum) {
  sum->primary_ms += part.primary_ms;
  sum->bounce_ms += part.bounce_ms;
  sum->shadow_ms += part.shadow_ms;
  sum->shade_ms += part.shade_ms;
  sum->primary_rays += part.primary_rays;
  sum->bounce_rays += part.bounce_rays;
  sum->shadow_rays += part.shadow_rays;
  sum->dropped += part.dropped;
}

class PathTracer final : public Renderer {
 public:
  PathTracer(const Scene& scene, const RenderSettings& settings, LightStrategy strategy)
      : settings_(settings),
        strategy_(strategy),
        state_(scene),
        bsdfs_(scene, settings.regularise),
        lights_(state_),
        filter_(state_) {}

  Status Build();
  Status RenderFrame(const RenderMoment& moment, Frame* frame,
                     const RenderProgress& progress) override;
  Status RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                         const RenderProgress& progress) override;
  const RenderTimings& timings() const override { return timings_; }
  size_t memory_bytes() const override {
    return accel_->memory_bytes() + lights_.memory_bytes() + bsdfs_.memory_bytes();
  }

 private:
  Result<TraceContext> MoveTo(const RenderMoment& moment);
  void RenderTile(const TraceContext& context, const RenderMoment& moment, const Tile& tile,
                  TileScratch* scratch, Frame* frame) const;
  void RenderReferenceTile(const TraceContext& context, const Tile& tile, int spp,
                           TileScratch* scratch, Image3* radiance) const;
  void MakeSamplers(SampleStream stream, uint64_t sample, const Tile& tile,
                    TileScratch* scratch) const;
  Status RunTiles(const RenderProgress& progress,
                  const std::function<void(const Tile&, TileScratch*)>& body);

  RenderSettings settings_;
  LightStrategy strategy_;
  SceneState state_;
  BsdfTables bsdfs_;
  LightSet lights_;
  SceneShadowFilter filter_;
  std::unique_ptr<Accel> accel_;
  RenderTimings timings_;
  tbb::enumerable_thread_specific<std::unique_ptr<TileScratch>> scratch_;
};

Status PathTracer::Build() {
  state_.Update(0.0, 0.0);
  Result<std::unique_ptr<Accel>> accel = Accel::Create(state_.scene(), DescribeInstances(state_),
                                                       state_.InstanceTransforms(), filter_);
  if (!accel.ok()) {
    return accel.status();
  }
  accel_ = std::move(*accel);
  lights_.Update(true);
  return Status::Ok();
}

Result<TraceContext> PathTracer::MoveTo(const RenderMoment& moment) {
  STILLRAY_RETURN_IF_ERROR(CheckMoment(state_.scene(), moment));
  timings_ = RenderTimings();
  const PhaseTimer timer(&timings_.update_ms);
  const bool moved = state_.Update(moment.seconds, moment.previous_seconds);
  if (moved) {
    STILLRAY_RETURN_IF_ERROR(accel_->Update(state_.InstanceTransforms()));
  }
  lights_.Update(moved);
  const Camera& camera = state_.scene().cameras[static_cast<size_t>(moment.camera)];
  const auto node = static_cast<size_t>(camera.node);
  return TraceContext{
      state_,
      bsdfs_,
      lights_,
      *accel_,
      settings_,
      strategy_,
      MakeCameraView(camera, state_.nodes()[node], settings_.width, settings_.height),
      MakeCameraView(camera, state_.previous_nodes()[node], settings_.width, settings_.height)};
}

void PathTracer::MakeSamplers(SampleStream stream, uint64_t sample, const Tile& tile,
                              TileScratch* scratch) const {
  for (int i = 0; i < tile.count(); ++i) {
    scratch->samplers[i] =
        MakePathSampler(settings_.sampler, settings_.seed, stream, tile.x0 + i % tile.width,
                        tile.y0 + i / tile.width, sample);
  }
}

void PathTracer::RenderTile(const TraceContext& context, const RenderMoment& moment,
                            const Tile& tile, TileScratch* scratch, Frame* frame) const {
  const vec2 offset(0.5f + frame->jitter_x, 0.5f + frame->jitter_y);
  for (int i = 0; i < tile.count(); ++i) {
    scratch->points[i] = vec2(tile.x0 + i % tile.width, tile.y0 + i / tile.width) + offset;
    scratch->sum[i].fill(vec3(0.0f));
    scratch->square[i].fill(0.0f);
  }
  RenderTimings* timings = &scratch->timings;
  FindPrimarySurfaces(context, scratch->points, tile.count(), &scratch->paths.trace,
                      scratch->pixels, timings);
  {
    const PhaseTimer timer(&timings->shade_ms);
    for (int i = 0; i < tile.count(); ++i) {
      scratch->guides[i] = MakeGuides(context, scratch->pixels[i], &scratch->first[i]);
      StoreGuides(scratch->guides[i], tile.x0 + i % tile.width, tile.y0 + i / tile.width, frame);
    }
  }
  const auto spp = static_cast<uint64_t>(settings_.spp);
  for (uint64_t s = 0; s < spp; ++s) {
    MakeSamplers(SampleStream::kFrames, static_cast<uint64_t>(moment.frame_index) * spp + s, tile,
                 scratch);
    TraceSample(context, scratch->pixels, scratch->first, scratch->samplers, tile.count(),
                &scratch->paths, timings);
    AddSamples(tile.count(), spp > 1, scratch);
  }
  StoreLight(tile, settings_.spp, *scratch, frame);
}

void PathTracer::RenderReferenceTile(const TraceContext& context, const Tile& tile, int spp,
                                     TileScratch* scratch, Image3* radiance) const {
  // Sums of many samples: in double precision, or small ones would be lost.
  std::vector<glm::dvec3> sum(static_cast<size_t>(tile.count()), glm::dvec3(0.0));
  RenderTimings* timings = &scratch->timings;
  for (int s = 0; s < spp; ++s) {
    MakeSamplers(SampleStream::kReference, static_cast<uint64_t>(s), tile, scratch);
    for (int i = 0; i < tile.count(); ++i) {
      vec2 within(0.5f);
      if (settings_.jitter) {
        const vec4 u = scratch->samplers[i].Get(kPrimaryDimensions);
        within = vec2(u.x, u.y);
      }
      scratch->points[i] = vec2(tile.x0 + i % tile.width, tile.y0 + i / tile.width) + within;
    }
    FindPrimarySurfaces(context, scratch->points, tile.count(), &scratch->paths.trace,
                        scratch->pixels, timings);
    TraceSample(context, scratch->pixels, nullptr, scratch->samplers, tile.count(), &scratch->paths,
                timings);
    for (int i = 0; i < tile.count(); ++i) {
      const UnscatteredLight own = FindUnscatteredLight(context, scratch->pixels[i]);
      vec3 light = own.emission + own.background;
      for (const vec3& signal : scratch->paths.light[i]) {
        light += signal;
      }
      sum[static_cast<size_t>(i)] += glm::dvec3(light);
    }
  }
  for (int i = 0; i < tile.count(); ++i) {
    Store(radiance, tile.x0 + i % tile.width, tile.y0 + i / tile.width,
          vec3(sum[static_cast<size_t>(i)] / static_cast<double>(spp)));
  }
}

Status PathTracer::RunTiles(const RenderProgress& progress,
                            const std::function<void(const Tile&, TileScratch*)>& body) {
  const Status status =
      ForEachTile(settings_.width, settings_.height, progress, [&](const Tile& tile) {
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

Status PathTracer::RenderFrame(const RenderMoment& moment, Frame* frame,
                               const RenderProgress& progress) {
  if (frame == nullptr) {
    return Status::InvalidArgument("frame is null");
  }
  try {
    Result<TraceContext> context = MoveTo(moment);
    if (!context.ok()) {
      return context.status();
    }
    PrepareFrame(settings_, frame);
    frame->index = moment.frame_index;
    const vec2 jitter = settings_.jitter ? FrameJitter(moment.frame_index) : vec2(0.0f);
    frame->jitter_x = jitter.x;
    frame->jitter_y = jitter.y;
    return RunTiles(progress, [&](const Tile& tile, TileScratch* scratch) {
      RenderTile(*context, moment, tile, scratch, frame);
    });
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("rendering a frame: out of memory");
  }
}

Status PathTracer::RenderReference(const RenderMoment& moment, int spp, Image3* radiance,
                                   const RenderProgress& progress) {
  if (radiance == nullptr) {
    return Status::InvalidArgument("radiance is null");
  }
  if (spp < 1) {
    return Status::InvalidArgument("spp of the reference is " + std::to_string(spp) +
                                   ", expected at least 1");
  }
  try {
    Result<TraceContext> context = MoveTo(moment);
    if (!context.ok()) {
      return context.status();
    }
    Prepare(radiance, settings_.width, settings_.height);
    return RunTiles(progress, [&](const Tile& tile, TileScratch* scratch) {
      RenderReferenceTile(*context, tile, spp, scratch, radiance);
    });
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("rendering a reference: out of memory");
  }
}

}  // namespace

Result<std::unique_ptr<Renderer>> CreateRenderer(const Scene& scene, const RenderSettings& settings,
                                                 LightStrategy strategy) {
  STILLRAY_RETURN_IF_ERROR(CheckSettings(settings));
  STILLRAY_RETURN_IF_ERROR(CheckScene(scene));
  try {
    auto renderer = std::make_unique<PathTracer>(scene, settings, strategy);
    STILLRAY_RETURN_IF_ERROR(renderer->Build());
    return std::unique_ptr<Renderer>(std::move(renderer));
  } catch (const std::bad_alloc&) {
    return Status::OutOfMemory("preparing the scene: out of memory");
  }
}

}  // namespace stillray::render

namespace stillray {

Result<std::unique_ptr<Renderer>> Renderer::Create(const Scene& scene,
                                                   const RenderSettings& settings) {
  return render::CreateRenderer(scene, settings, render::LightStrategy::kBoth);
}

}  // namespace stillray
