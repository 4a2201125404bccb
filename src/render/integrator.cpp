// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/integrator.h"

#include <algorithm>
#include <utility>

#include "render/light_candidates_shared.h"

namespace stillray::render {
namespace {

static_assert(static_cast<int>(SignalKind::kIndirectTransmission) == kIndirectTransmission);
static_assert(kSurfaceSignals == kTracedSignalCount && kAllSignals == kMostTracedSignals);

/// Hits access the scene's memory incoherently: prefetches the triangle indices, then the vertices
/// of later hits.
void FetchAhead(const SceneState& state, const HitBatch& hits, int i, int count) {
  constexpr int kIndices = 16;
  constexpr int kCorners = 8;
  if (i + kIndices < count && hits.instance[i + kIndices] != kNoHit) {
    const Mesh& mesh = *state.instance(hits.instance[i + kIndices]).mesh;
    __builtin_prefetch(mesh.indices.data() + 3 * static_cast<size_t>(hits.primitive[i + kIndices]));
  }
  if (i + kCorners < count && hits.instance[i + kCorners] != kNoHit) {
    const PlacedInstance& instance = state.instance(hits.instance[i + kCorners]);
    const Mesh& mesh = *instance.mesh;
    const size_t first = 3 * static_cast<size_t>(hits.primitive[i + kCorners]);
    for (size_t k = first; k < first + 3; ++k) {
      const uint32_t corner = mesh.indices[k];
      __builtin_prefetch(instance.vertices.positions + corner);
      __builtin_prefetch(instance.vertices.normals + corner);
      if (!mesh.uv[0].empty()) {
        __builtin_prefetch(mesh.uv[0].data() + corner);
      }
    }
  }
}

/// Traces the paths of a tile step by step.
class Tracer {
 public:
  Tracer(const TraceContext& context, const SampledPixels& sampled, PathScratch* scratch,
         RenderTimings* timings)
      : context_(context),
        sampled_(sampled),
        scratch_(*scratch),
        rays_(&scratch->trace.rays),
        next_(&scratch->next),
        timings_(*timings) {}

  void Start(int part);
  void ShadeAll();
  void TraceShadows();
  void TraceBounces();
  bool Alive() const { return rays_->count > 0; }

 private:
  void Shade(int path_index, const Hit& hit);
  bool PassMedium(int path_index, float far);
  void ScatterAt(int path_index, const Surface& surface, const Bsdf& bsdf, vec3 direction, vec4 u);
  void Leave(const Path& path, vec3 direction);
  void MeetLight(const Path& path, const Hit& hit, const Surface& surface, vec3 direction);
  float SeekLight(const Path& path, const Surface& surface, const Bsdf& bsdf, vec4* u);
  void Continue(const Path& path, vec3 origin, vec3 direction);
  void Add(int pixel, int kind, vec3 light);
  void AddFound(int pixel, int properties, const FoundLight& found);
  int sampling() const { return static_cast<int>(context_.settings.light_sampling); }

  const TraceContext& context_;
  const SampledPixels& sampled_;
  PathScratch& scratch_;
  RayBatch* rays_;  // rays of the current paths; next_: rays of the next step
  RayBatch* next_;
  RenderTimings& timings_;
};

/// The only function that adds radiance to a pixel.
void Tracer::Add(int pixel, int kind, vec3 light) {
  if (!IsUsableLight(light)) {
    ++timings_.dropped;
    return;
  }
  scratch_.light[pixel][static_cast<size_t>(kind)] += light;
}

/// \param properties  kLight...
void Tracer::AddFound(int pixel, int properties, const FoundLight& found) {
  const FoundLight light =
      SortLight(ClampLight(found, context_.settings.clamp_radiance), properties);
  Add(pixel, DiffuseKind(properties), light.diffuse);
  Add(pixel, SpecularKind(properties), light.specular);
}

/// The layers of a pixel at which a path may start.
struct LayerRange {
  int begin = 0;
  int end = 0;
  float weight = 1;  ///< total weight of the layers, including the background if it is eligible
  bool background = true;  ///< the background may be selected, in which case there is no path
};

LayerRange LayersOfPart(const PrimaryPixel& pixel, bool separates, int part) {
  LayerRange range = {.end = pixel.count};
  if (!separates || pixel.count == 1) {
    return range;
  }
  const float first = pixel.layers[0].weight;
  return part == 0 ? LayerRange{0, 1, first, false} : LayerRange{1, pixel.count, 1.0f - first};
}

/// Selects a layer in proportion to the weights. \param u in [0, 1) \return index of the layer; -1:
/// the background
int PickLayer(const PrimaryPixel& pixel, const LayerRange& range, float u) {
  float rest = u * range.weight;
  for (int i = range.begin; i < range.end; ++i) {
    if (rest < pixel.layers[i].weight) {
      return i;
    }
    rest -= pixel.layers[i].weight;
  }
  // Weights sum to range.weight only up to rounding.
  return range.background && pixel.background > 0.0f ? -1 : range.end - 1;
}

void Tracer::Start(int part) {
  const PhaseTimer timer(&timings_.shade_ms);
  RayScratch& trace = scratch_.trace;
  trace.rays.count = 0;
  for (int i = 0; i < sampled_.count; ++i) {
    if (part == 0) {
      scratch_.light[i].fill(vec3(0.0f));
    }
    const PrimaryPixel& pixel = sampled_.pixels[i];
    const bool parted = sampled_.separates != nullptr && sampled_.separates[i];
    if (pixel.count == 0 || (part > 0 && !parted)) {
      continue;
    }
    const LayerRange range = LayersOfPart(pixel, parted, part);
    const bool is_sure =
        range.end - range.begin == 1 && !(range.background && pixel.background > 0);
    const int layer = is_sure
                          ? range.begin
                          : PickLayer(pixel, range, sampled_.samplers[i].Get(kPrimaryDimensions).w);
    if (layer < 0) {
      continue;
    }
    const int at = trace.rays.count;
    Path& path = scratch_.paths[at];
    static_cast<PathState&>(path) = StartPath(sampled_.samplers[i].seed);
    if (parted) {
      StartPart(path, part, pixel.count > 1, range.weight);
    }
    path.pixel = i;
    path.sampler = sampled_.samplers[i];
    path.known = sampled_.first != nullptr && pixel.count == 1;
    trace.rays.Push(ViewOf(context_.camera, pixel).position, pixel.direction, kInfinity);
    const Hit& hit = pixel.layers[layer].hit;
    trace.hits.t[at] = hit.t;
    trace.hits.u[at] = hit.u;
    trace.hits.v[at] = hit.v;
    trace.hits.instance[at] = hit.instance;
    trace.hits.primitive[at] = hit.primitive;
  }
}

void Tracer::ShadeAll() {
  const PhaseTimer timer(&timings_.shade_ms);
  next_->count = 0;
  scratch_.shadow.count = 0;
  const int count = rays_->count;
  SamplerBatch& samplers = scratch_.samplers;
  samplers.count = 0;
  for (int i = 0; i < count; ++i) {
    samplers.Push(scratch_.paths[i].sampler, ScatterDimensions(scratch_.paths[i].step));
  }
  DrawNumbers(samplers, 0, &scratch_.scatter_numbers);
  DrawNumbers(samplers, LightDimensions(0) - ScatterDimensions(0), &scratch_.light_numbers);
  for (int i = 0; i < count; ++i) {
    FetchAhead(context_.state, scratch_.trace.hits, i, count);
    Shade(i, scratch_.trace.hits.Get(i));
  }
}

/// Stores the path for the next step, in place: paths stored so far never outnumber paths shaded so
/// far, hence no path is overwritten before it is read.
void Tracer::Continue(const Path& path, vec3 origin, vec3 direction) {
  Path& kept = scratch_.paths[next_->count];
  if (&kept != &path) {
    kept = path;
  }
  next_->Push(origin, direction, kInfinity);
}

/// Ends a path whose ray left the scene.
void Tracer::Leave(const Path& path, vec3 direction) {
  const EnvironmentLight& environment = context_.lights.environment();
  if (environment.dark()) {
    return;
  }
  const float density =
      DensityOfEnvironment(context_.lights.arrays(), path.normal, path.light_total, direction);
  const vec3 radiance =
      environment.Radiance(direction) * ScatterWeight(path.density, density, sampling());
  AddFound(path.pixel, path.light, LightMet(path, radiance));
}

/// Adds the emission of a hit surface.
void Tracer::MeetLight(const Path& path, const Hit& hit, const Surface& surface, vec3 direction) {
  const Material& material = *surface.material;
  if (path.first != 0 || !material.emits() || !(surface.front != 0 || material.double_sided)) {
    return;
  }
  const float distance = length(surface.position - path.origin);
  const float density =
      context_.lights.DensityOfHit(path.origin, path.light_total, hit, direction, distance);
  const vec3 radiance =
      context_.state.Emission(hit) * ScatterWeight(path.density, density, sampling());
  AddFound(path.pixel, path.light, LightMet(path, radiance));
}

/// Light sampling by resampled candidates: adds the shadow ray to the chosen candidate. Returns
/// TotalOf the choices.
/// \param u  [in,out] u.w is used, and replaced by an independent number
float Tracer::SeekLight(const Path& path, const Surface& surface, const Bsdf& bsdf, vec4* u) {
  const LightArrays& lights = context_.lights.arrays();
  const LightChoices choices = WeighLights(lights, surface.position);
  const int count = CandidateCount(lights, context_.settings.light_candidates, path.first != 0);
  CandidateChoice choice = NoCandidate(u->w);
  PathScratch::ShadowLight chosen{};
  PathRay ray{};
  for (int i = 0; i < count; ++i) {
    const LightSample light = context_.lights.Sample(surface.position, surface.frame.z, choices,
                                                     CandidateNumbers(*u, i, count));
    if (!(light.density > 0.0f)) {
      continue;
    }
    const vec3 wi = ToLocal(surface.frame, light.direction);
    if (!IsConsistent(surface, light.direction, wi.z)) {
      continue;
    }
    const BsdfValue value = EvaluateBsdf(bsdf, surface.local_wo, wi, PartOfBsdf(path));
    const float weight = SoughtWeight(light.density, value.density, light.delta, sampling());
    const FoundLight found = LightSought(path, surface, light, value, wi.z, weight);
    if (!IsUsableLight(found.diffuse + found.specular)) {
      ++timings_.dropped;
      continue;
    }
    const float candidate = CandidateWeight(found);
    if (candidate > 0.0f && TakesCandidate(choice, candidate)) {
      chosen = {path.pixel, LightSoughtBy(path, wi.z), found};
      ray = ShadowRayTo(surface, light, wi.z > 0.0f);
    }
  }
  u->w = choice.u;
  if (choice.weight > 0.0f) {
    const float factor = FactorOfChosen(choice, count);
    chosen.light.diffuse *= factor;
    chosen.light.specular *= factor;
    scratch_.shadow_light[scratch_.shadow.count] = chosen;
    scratch_.shadow.Push(ray.origin, ray.direction, ray.end);
  }
  return TotalOf(choices);
}

/// Advances the path through its medium. Returns whether it reaches the surface at `far`; otherwise
/// it is scattered or ends.
bool Tracer::PassMedium(int path_index, float far) {
  Path& path = scratch_.paths[path_index];
  vec3 direction = rays_->Direction(path_index);
  const vec3 before = direction;
  float distance = 0.0f;
  const vec4 u = path.sampler.Get(MediumDimensions(path.step));
  const int fate = CrossMedium(path, far, u, scratch_.light_numbers.Get(path_index).w,
                               context_.settings.bounces, direction, distance);
  if (fate == kMediumScatters) {
    ++path.step;
    path.known = false;
    Continue(path, rays_->Origin(path_index) + before * distance, direction);
  }
  return fate == kMediumPasses;
}

void Tracer::Shade(int path_index, const Hit& hit) {
  Path& path = scratch_.paths[path_index];
  const vec3 direction = rays_->Direction(path_index);
  if (path.first == 0) {
    if (IsInScatteringMedium(path)) {
      if (!PassMedium(path_index, hit.t)) {
        return;
      }
    } else {
      path.throughput *= Absorb(path.extinction, hit.t);
    }
    if (hit.instance == kNoHit) {
      return Leave(path, direction);
    }
  }
  vec4 u = scratch_.light_numbers.Get(path_index);
  if (path.first == 0) {
    const float opacity = context_.state.Opacity(hit);
    if (u.w >= opacity) {
      ++path.step;
      if (++path.free_events <= kMaxFreeEvents) {
        Continue(path, OriginBehind(context_.state, hit, direction), direction);
      }
      return;
    }
    u.w = min(u.w / opacity, kBelowOne);
  }
  if (path.known) {
    const FirstSurface& first = sampled_.first[path.pixel];
    return ScatterAt(path_index, first.surface, first.bsdf, direction, u);
  }
  // After the last bounce only emission contributes, possibly through smooth glass.
  const Material& material = *context_.state.instance(hit.instance).material;
  const bool at_end = path.bounces >= context_.settings.bounces && material.transmission <= 0.0f;
  if (at_end && !material.emits()) {
    return;
  }
  const vec3 base_colour = BaseColourOfVertex(context_, sampled_.images, path.pixel, hit);
  const Surface surface = MakeSurface(context_.state, hit, base_colour, direction);
  MeetLight(path, hit, surface, direction);
  if (at_end) {
    return;
  }
  const float min_alpha = context_.settings.regularise ? LeastAlpha(path) : 0.0f;
  const Bsdf bsdf = context_.bsdfs.Make(surface, min_alpha);
  ScatterAt(path_index, surface, bsdf, direction, u);
}

/// Samples lights at the surface and continues the path. u: LightDimensions of this step.
void Tracer::ScatterAt(int path_index, const Surface& surface, const Bsdf& bsdf, vec3 direction,
                       vec4 u) {
  Path& path = scratch_.paths[path_index];
  if (IsBlack(bsdf)) {
    return;
  }
  const int most_bounces = context_.settings.bounces;
  float total = 0.0f;
  if (!context_.lights.empty() && MaySeekLight(path, bsdf, most_bounces, sampling())) {
    total = SeekLight(path, surface, bsdf, &u);
  }
  vec3 onward(0.0f);
  const bool was_first = path.first != 0;
  const vec4 scatter_u = scratch_.scatter_numbers.Get(path_index);
  if (!ScatterPath(path, surface, bsdf, scatter_u, most_bounces, onward) ||
      !SurvivesRoulette(path, u.w)) {
    return;
  }
  if (was_first || onward != direction) {
    path.light_total = total;
  }
  // The last ray contributes only if it hits an emitter: it is not traced if there is none to hit.
  if (context_.ends_are_opaque && path.bounces >= most_bounces &&
      !LightMayBeMet(context_.lights.arrays(), surface.position, onward)) {
    return;
  }
  ++path.step;
  path.known = false;
  Continue(path, OriginOf(surface, onward), onward);
}

void Tracer::TraceShadows() {
  if (scratch_.shadow.count == 0) {
    return;
  }
  {
    const PhaseTimer timer(&timings_.shadow_ms);
    timings_.shadow_rays += static_cast<uint64_t>(scratch_.shadow.count);
    context_.accel.Occluded(scratch_.shadow, scratch_.transmittance);
  }
  const PhaseTimer timer(&timings_.shade_ms);
  for (int i = 0; i < scratch_.shadow.count; ++i) {
    const PathScratch::ShadowLight& found = scratch_.shadow_light[i];
    const vec3 through = scratch_.transmittance[i];
    if (through == vec3(0.0f)) {
      continue;
    }
    AddFound(found.pixel, found.properties,
             {found.light.diffuse * through, found.light.specular * through});
  }
}

void Tracer::TraceBounces() {
  std::swap(rays_, next_);
  const PhaseTimer timer(&timings_.bounce_ms);
  timings_.bounce_rays += static_cast<uint64_t>(rays_->count);
  context_.accel.IntersectIncoherent(*rays_, &scratch_.trace.hits);
}

}  // namespace

void TraceSample(const TraceContext& context, const SampledPixels& sampled, PathScratch* scratch,
                 RenderTimings* timings) {
  const bool* separates = sampled.separates;
  const bool any = separates != nullptr && std::find(separates, separates + sampled.count, true) !=
                                               separates + sampled.count;
  for (int part = 0; part < (any ? 2 : 1); ++part) {
    Tracer tracer(context, sampled, scratch, timings);
    tracer.Start(part);
    while (tracer.Alive()) {
      tracer.ShadeAll();
      tracer.TraceShadows();
      tracer.TraceBounces();
    }
  }
}

}  // namespace stillray::render
