// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/integrator.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stillray::render {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kBelowOne = 0.99999994f;
// Surfaces after which paths of little weight may end.
constexpr int kRouletteBounces = 3;
constexpr float kLeastSurvival = 0.05f;
// Shadow rays end this much short of their light, relative to the distance.
constexpr float kShadowEnd = 1.0f - 1e-5f;

int Index(SignalKind kind) {
  return static_cast<int>(kind);
}

bool IsUsable(vec3 v) {
  return v.x >= 0.0f && v.y >= 0.0f && v.z >= 0.0f && v.x + v.y + v.z < kInfinity;
}

vec3 AbsorptionOf(const Material& material) {
  constexpr float kDarkest = 1e-6f;
  if (!(material.attenuation_distance > 0.0f) || std::isinf(material.attenuation_distance)) {
    return vec3(0.0f);
  }
  const auto one = [&](float colour) {
    return -std::log(clamp(colour, kDarkest, 1.0f)) / material.attenuation_distance;
  };
  return {one(material.attenuation_color.x), one(material.attenuation_color.y),
          one(material.attenuation_color.z)};
}

// Of the space that a ray from the surface enters; `below`: on the far side from the viewer.
vec3 AbsorptionBeyond(const Path& path, const Surface& surface, bool below) {
  if (!below || !surface.material->solid) {
    return path.absorption;
  }
  return surface.front ? AbsorptionOf(*surface.material) : vec3(0.0f);
}

vec3 Absorb(vec3 absorption, float distance) {
  constexpr float kFar = 1e30f;  // 0 times infinity is not a number
  return absorption == vec3(0.0f) ? vec3(1.0f) : glm::exp(-absorption * min(distance, kFar));
}

// Hits lie all over the scene's memory: asks for what the next ones need, first for the indices of
// their triangles, then for the corners.
void FetchAhead(const SceneState& state, const HitBatch& hits, int i, int count) {
  constexpr int kIndices = 16;
  constexpr int kCorners = 8;
  if (i + kIndices < count && hits.instance[i + kIndices] != kNoHit) {
    const Mesh& mesh = *state.instance(hits.instance[i + kIndices]).mesh;
    __builtin_prefetch(mesh.indices.data() + 3 * static_cast<size_t>(hits.primitive[i + kIndices]));
  }
  if (i + kCorners < count && hits.instance[i + kCorners] != kNoHit) {
    const Mesh& mesh = *state.instance(hits.instance[i + kCorners]).mesh;
    const size_t first = 3 * static_cast<size_t>(hits.primitive[i + kCorners]);
    for (size_t k = first; k < first + 3; ++k) {
      const uint32_t corner = mesh.indices[k];
      __builtin_prefetch(mesh.positions.data() + corner);
      __builtin_prefetch(mesh.normals.data() + corner);
      if (!mesh.uv[0].empty()) {
        __builtin_prefetch(mesh.uv[0].data() + corner);
      }
    }
  }
}

// The steps that all paths of a tile take together.
class Tracer {
 public:
  Tracer(const TraceContext& context, const FirstSurface* first, PathScratch* scratch,
         RenderTimings* timings)
      : context_(context),
        first_(first),
        scratch_(*scratch),
        rays_(&scratch->trace.rays),
        next_(&scratch->next),
        timings_(*timings) {}

  void Start(const PrimaryPixel* pixels, const PathSampler* samplers, int count);
  void ShadeAll();
  void TraceShadows();
  void TraceBounces();
  bool Alive() const { return rays_->count > 0; }

 private:
  void Shade(int path_index, const Hit& hit);
  void ScatterAt(int path_index, const Surface& surface, const Bsdf& bsdf, vec3 direction, vec4 u);
  void Leave(const Path& path, vec3 direction);
  void MeetLight(const Path& path, const Hit& hit, const Surface& surface, vec3 direction);
  float SeekLight(const Path& path, const Surface& surface, const Bsdf& bsdf, vec4 u);
  void SendShadowRay(const Surface& surface, const LightSample& light, bool above,
                     const PathScratch::ShadowLight& found);
  bool Scatter(Path* path, const Surface& surface, const Bsdf& bsdf, vec4 u, vec3* direction);
  bool SurvivesRoulette(Path* path, float u);
  void Continue(const Path& path, vec3 origin, vec3 direction);
  void Add(int pixel, SignalKind kind, vec3 light);
  void AddFound(const Path& path, vec3 radiance);
  float ScatterWeight(const Path& path, float light_density) const;

  const TraceContext& context_;
  const FirstSurface* first_;
  PathScratch& scratch_;
  RayBatch* rays_;  // those of the paths, and those of the next step
  RayBatch* next_;
  RenderTimings& timings_;
};

// The one door through which light gets into the picture.
void Tracer::Add(int pixel, SignalKind kind, vec3 light) {
  if (!IsUsable(light)) {
    ++timings_.dropped;
    return;
  }
  scratch_.light[pixel][static_cast<size_t>(Index(kind))] += light;
}

// Light that the path's own ray met.
void Tracer::AddFound(const Path& path, vec3 radiance) {
  const vec3 light = path.throughput * radiance;
  Add(path.pixel, path.direct ? SignalKind::kDirectDiffuse : SignalKind::kIndirectDiffuse,
      path.diffuse * light);
  Add(path.pixel, path.direct ? SignalKind::kDirectSpecular : SignalKind::kIndirectSpecular,
      path.specular * light);
}

// MIS weight of light that the scattered ray met and a ray to a light could have found.
float Tracer::ScatterWeight(const Path& path, float light_density) const {
  if (path.density <= 0.0f) {
    return 1.0f;
  }
  switch (context_.strategy) {
    case LightStrategy::kBoth:
      break;
    case LightStrategy::kNextEvent:
      return light_density > 0.0f ? 0.0f : 1.0f;
    case LightStrategy::kScatter:
      return 1.0f;
  }
  return MisWeight(path.density, light_density);
}

void Tracer::Start(const PrimaryPixel* pixels, const PathSampler* samplers, int count) {
  const PhaseTimer timer(&timings_.shade_ms);
  RayScratch& trace = scratch_.trace;
  trace.rays.count = 0;
  for (int i = 0; i < count; ++i) {
    scratch_.light[i].fill(vec3(0.0f));
    const PrimaryPixel& pixel = pixels[i];
    if (pixel.count == 0) {
      continue;
    }
    // A path starts at one of the layers, by chance.
    int layer = 0;
    if (pixel.count > 1 || pixel.background > 0.0f) {
      float rest = samplers[i].Get(kPrimaryDimensions).w;
      while (layer < pixel.count && rest >= pixel.layers[layer].weight) {
        rest -= pixel.layers[layer++].weight;
      }
      if (layer == pixel.count) {
        if (pixel.background > 0.0f) {
          continue;
        }
        --layer;  // the weights' sum is 1 up to rounding
      }
    }
    const int at = trace.rays.count;
    Path& path = scratch_.paths[at];
    path = {};
    path.sampler = samplers[i];
    path.throughput = vec3(1.0f);
    path.pixel = i;
    path.first = true;
    path.known = first_ != nullptr && pixel.count == 1;
    trace.rays.Push(context_.camera.position, pixel.direction, kInfinity);
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

// Keeps the path for the next step. There are never more survivors than paths shaded so far, so
// that none is overwritten before its turn.
void Tracer::Continue(const Path& path, vec3 origin, vec3 direction) {
  Path& kept = scratch_.paths[next_->count];
  if (&kept != &path) {
    kept = path;
  }
  next_->Push(origin, direction, kInfinity);
}

// The ray left the scene.
void Tracer::Leave(const Path& path, vec3 direction) {
  const EnvironmentLight& environment = context_.lights.environment();
  if (environment.dark()) {
    return;
  }
  const float density =
      context_.lights.DensityOfEnvironment(path.normal, path.light_total, direction);
  AddFound(path, environment.Radiance(direction) * ScatterWeight(path, density));
}

// The ray met a surface that may shine.
void Tracer::MeetLight(const Path& path, const Hit& hit, const Surface& surface, vec3 direction) {
  const Material& material = *surface.material;
  if (path.first || !material.emits() || !(surface.front || material.double_sided)) {
    return;
  }
  const float distance = length(surface.position - path.origin);
  const float density =
      context_.lights.DensityOfHit(path.origin, path.light_total, hit, direction, distance);
  AddFound(path, context_.state.Emission(hit) * ScatterWeight(path, density));
}

// Sends a ray to a light. Returns the total of LightChoices.
float Tracer::SeekLight(const Path& path, const Surface& surface, const Bsdf& bsdf, vec4 u) {
  LightChoices choices;
  context_.lights.Weigh(surface.position, &choices);
  const LightSample light = context_.lights.Sample(surface.position, surface.frame.z, choices, u);
  if (!(light.density > 0.0f) || (context_.strategy == LightStrategy::kScatter && !light.delta)) {
    return choices.total();
  }
  const vec3 wi = surface.frame.ToLocal(light.direction);
  if (!surface.Consistent(light.direction, wi.z)) {
    return choices.total();
  }
  const BsdfValue value = EvaluateBsdf(bsdf, surface.local_wo, wi);
  const bool weighted = !light.delta && context_.strategy == LightStrategy::kBoth;
  const float weight = weighted ? MisWeight(light.density, value.density) : 1.0f;
  const vec3 arriving = path.throughput * light.radiance * (weight / light.density) *
                        Absorb(AbsorptionBeyond(path, surface, wi.z < 0.0f), light.distance);
  PathScratch::ShadowLight found;
  found.pixel = path.pixel;
  found.direct = path.first;
  if (path.first) {
    found.diffuse = value.diffuse * arriving;
    found.specular = value.specular * arriving;
  } else {
    const vec3 scattered = (value.diffuse + value.specular) * arriving;
    found.diffuse = path.diffuse * scattered;
    found.specular = path.specular * scattered;
  }
  if (found.diffuse != vec3(0.0f) || found.specular != vec3(0.0f)) {
    SendShadowRay(surface, light, wi.z > 0.0f, found);
  }
  return choices.total();
}

// Tests whether the light found arrives.
void Tracer::SendShadowRay(const Surface& surface, const LightSample& light, bool above,
                           const PathScratch::ShadowLight& found) {
  const vec3 side = above ? surface.geometric : -surface.geometric;
  const vec3 from = OffsetPoint(surface.position, side);
  vec3 direction = light.direction;
  float end = light.distance;
  if (!light.delta && end < kInfinity) {
    const vec3 offset = OffsetPoint(light.point, light.normal) - from;
    end = length(offset);
    direction = offset / end;
  }
  const int at = scratch_.shadow.count;
  scratch_.shadow_light[at] = found;
  scratch_.shadow.Push(from, direction, end * kShadowEnd);
}

// Draws the ray on and gives the path its new weight. Returns whether it goes on.
bool Tracer::Scatter(Path* path, const Surface& surface, const Bsdf& bsdf, vec4 u,
                     vec3* direction) {
  const BsdfSample sample = SampleBsdf(bsdf, surface.local_wo, u);
  if (sample.kind == kScatterNone) {
    return false;
  }
  *direction = SafeNormalize(surface.frame.ToWorld(sample.wi), surface.wo);
  if (sample.kind == kScatterStraight) {
    *direction = -surface.wo;
  } else if (!surface.Consistent(*direction, sample.wi.z)) {
    return false;
  }
  const bool in_solid = surface.material->solid && !surface.front;
  const bool is_free = sample.kind == kScatterRefract || sample.kind == kScatterStraight ||
                       (sample.kind == kScatterMirror && in_solid && bsdf.pick_glass > 0.0f);
  if (is_free) {
    if (++path->free_events > kMaxFreeEvents) {
      return false;
    }
  } else if (!path->first && ++path->bounces > context_.settings.bounces) {
    return false;
  }
  if (path->first) {
    path->diffuse = sample.diffuse;
    path->specular = sample.specular;
    path->direct = true;
  } else {
    path->throughput *= sample.diffuse + sample.specular;
    // A sheet passed straight on is no surface to light: rays to lights pass it too.
    path->direct = path->direct && sample.kind == kScatterStraight;
  }
  path->absorption = AbsorptionBeyond(*path, surface, sample.wi.z < 0.0f);
  if (sample.kind == kScatterRough) {
    path->roughest =
        max(path->roughest, bsdf.pick_diffuse + bsdf.pick_specular * bsdf.specular_alpha +
                                bsdf.pick_glass * bsdf.glass_alpha);
  }
  if (path->first || sample.kind != kScatterStraight) {
    path->origin = surface.position;
    path->normal = surface.frame.z;
    path->density = sample.density;
  }
  path->first = false;
  return true;
}

bool Tracer::SurvivesRoulette(Path* path, float u) {
  if (path->bounces < kRouletteBounces) {
    return true;
  }
  const float weight = MaxComponent(path->throughput * max(path->diffuse, path->specular));
  const float survival = clamp(weight, kLeastSurvival, 1.0f);
  if (u >= survival) {
    return false;
  }
  path->throughput /= survival;
  return true;
}

void Tracer::Shade(int path_index, const Hit& hit) {
  Path& path = scratch_.paths[path_index];
  const vec3 direction = rays_->Direction(path_index);
  if (!path.first) {
    path.throughput *= Absorb(path.absorption, hit.t);
    if (hit.instance == kNoHit) {
      return Leave(path, direction);
    }
  }
  vec4 u = scratch_.light_numbers.Get(path_index);
  if (!path.first) {
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
    const FirstSurface& first = first_[path.pixel];
    return ScatterAt(path_index, first.surface, first.bsdf, direction, u);
  }
  // At the end of the path only light itself counts, or what lies behind smooth glass.
  const Material& material = *context_.state.instance(hit.instance).material;
  const bool at_end = path.bounces >= context_.settings.bounces && material.transmission <= 0.0f;
  if (at_end && !material.emits()) {
    return;
  }
  const Surface surface = MakeSurface(context_.state, hit, direction);
  MeetLight(path, hit, surface, direction);
  if (at_end) {
    return;
  }
  const float min_alpha = context_.settings.regularise ? kRegularisation * path.roughest : 0.0f;
  const Bsdf bsdf = context_.bsdfs.Make(surface, min_alpha > kSmoothAlpha ? min_alpha : 0.0f);
  ScatterAt(path_index, surface, bsdf, direction, u);
}

// Seeks light at the surface and follows the path on. u: LightDimensions of this step.
void Tracer::ScatterAt(int path_index, const Surface& surface, const Bsdf& bsdf, vec3 direction,
                       vec4 u) {
  Path* path = &scratch_.paths[path_index];
  if (bsdf.pick_diffuse + bsdf.pick_specular + bsdf.pick_glass <= 0.0f) {
    return;  // black
  }
  const bool any_rough = bsdf.pick_diffuse > 0.0f || bsdf.specular_alpha > 0.0f ||
                         (bsdf.pick_glass > 0.0f && bsdf.glass_alpha > 0.0f);
  const bool may_scatter = path->first || path->bounces < context_.settings.bounces;
  float total = 0.0f;
  if (any_rough && may_scatter && !context_.lights.empty()) {
    total = SeekLight(*path, surface, bsdf, u);
  }
  vec3 onward;
  const bool was_first = path->first;
  if (!Scatter(path, surface, bsdf, scratch_.scatter_numbers.Get(path_index), &onward) ||
      !SurvivesRoulette(path, u.w)) {
    return;
  }
  if (was_first || onward != direction) {
    path->light_total = total;
  }
  // A ray after which only emitters count need not be traced where there can be none.
  if (context_.ends_are_opaque && path->bounces >= context_.settings.bounces &&
      !context_.lights.MayBeMet(surface.position, onward)) {
    return;
  }
  ++path->step;
  path->known = false;
  const bool up = dot(onward, surface.geometric) > 0.0f;
  Continue(*path, OffsetPoint(surface.position, up ? surface.geometric : -surface.geometric),
           onward);
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
    Add(found.pixel, found.direct ? SignalKind::kDirectDiffuse : SignalKind::kIndirectDiffuse,
        found.diffuse * through);
    Add(found.pixel, found.direct ? SignalKind::kDirectSpecular : SignalKind::kIndirectSpecular,
        found.specular * through);
  }
}

void Tracer::TraceBounces() {
  std::swap(rays_, next_);
  const PhaseTimer timer(&timings_.bounce_ms);
  timings_.bounce_rays += static_cast<uint64_t>(rays_->count);
  context_.accel.IntersectIncoherent(*rays_, &scratch_.trace.hits);
}

}  // namespace

void TraceSample(const TraceContext& context, const PrimaryPixel* pixels, const FirstSurface* first,
                 const PathSampler* samplers, int count, PathScratch* scratch,
                 RenderTimings* timings) {
  Tracer tracer(context, first, scratch, timings);
  tracer.Start(pixels, samplers, count);
  while (tracer.Alive()) {
    tracer.ShadeAll();
    tracer.TraceShadows();
    tracer.TraceBounces();
  }
}

}  // namespace stillray::render
