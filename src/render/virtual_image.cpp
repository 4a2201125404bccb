// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/virtual_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/colour.h"
#include "render/frame_store.h"
#include "render/guides.h"
#include "render/previous_normals.h"
#include "render/virtual_image_shared.h"

namespace stillray::render {
namespace {

/// Longer chains show no image: two faces of three glass bodies, and two mirrors.
constexpr int kMostVertices = 8;
/// Rays of a chain, those that pass thin sheets and cut-outs too.
constexpr int kMostRays = 16;

/// How a chain leaves a surface.
enum class Pass : uint8_t { kEnd, kReflect, kRefract, kStraight };

struct Leaving {
  Pass pass = Pass::kEnd;
  float eta = 0;          ///< of kRefract
  float reflectance = 1;  ///< of glass
};

/// Light of an emitter or the sky is divided by itself, so that the filter does not see it: smaller
/// values are.
constexpr float kLeastRadiance = 0.01f;
/// Least cosine of a clear coat's normal with the surface's, about which chains are reflected.
constexpr float kSameNormal = 0.9999f;
/// Glass shows the image of a light that it reflects if that is brighter than this part of the mean
/// sky.
constexpr float kVisibleLight = 0.5f;

bool IsSmooth(float alpha) {
  return alpha <= AlphaOfRoughness(kSmoothRoughness);
}

/// \param first  the visible surface, whose specular light alone is guided: it may be diffuse too
Leaving LeavingOf(const Surface& surface, const Bsdf& bsdf, vec3 specular_albedo, bool first) {
  if (bsdf.glass_weight > 0.5f && IsSmooth(bsdf.glass_alpha)) {
    const float reflectance = bsdf.thin != 0
                                  ? bsdf.sheet_reflectance
                                  : FresnelDielectric(min(surface.local_wo.z, 1.0f), bsdf.eta);
    if (reflectance > 0.5f) {
      return {Pass::kReflect};
    }
    return {bsdf.thin != 0 ? Pass::kStraight : Pass::kRefract, bsdf.eta, reflectance};
  }
  const bool coat = IsMainlyCoat(bsdf);
  const bool reflects = coat ? IsSmooth(bsdf.coat_alpha) && bsdf.coat_normal.z > kSameNormal
                             : bsdf.pick_specular > 0.0f && IsSmooth(bsdf.specular_alpha);
  const bool mostly = Luminance709(specular_albedo) > Luminance709(DiffuseAlbedo(bsdf));
  return reflects && (first || mostly) ? Leaving{Pass::kReflect} : Leaving{};
}

/// A chain of smooth surfaces.
struct Chain {
  int pixel = 0;
  vec3 direction;
  float length = 0;
  vec3 throughput = vec3(1.0f);  ///< colour of the surfaces behind the first one
  int count = 0;
  int rays = 0;
  /// It only looks for a light that glass reflects, while another chain of the pixel passes
  /// through: the mirror image of a light is brighter than what is seen through the glass.
  bool seeks_light = false;
  float reflectance = 1;                          ///< of the glass, then
  std::array<ChainVertex, kMostVertices> vertex;  ///< in the previous frame
};

/// The point of a hit at the previous frame's moment.
vec3 PreviousPoint(const PlacedInstance& instance, const Hit& hit, vec3 now) {
  return instance.moving
             ? vec3(instance.previous_world *
                    vec4(LocalPoint(*instance.mesh, instance.previous_vertices.positions, hit),
                         1.0f))
             : now;
}

/// The surface around a hit in the previous frame.
ChainVertex MakeVertex(const TraceContext& context, const Hit& hit, const Surface& surface,
                       float eta) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  const Mesh& mesh = *instance.mesh;
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(hit.primitive);
  const mat3 world(instance.moving ? instance.previous_world : instance.world);
  const mat3 to_normal = transpose(inverse(world));
  const mat3 from_normal = transpose(mat3(instance.world));
  const VertexArrays& before = instance.previous_vertices;
  const auto normal_at = [&](int k) {
    return SafeNormalize(to_normal * before.normals[corner[k]], surface.frame.z);
  };
  ChainVertex vertex;
  vertex.position = PreviousPoint(instance, hit, surface.position);
  vertex.edge_u = world * (before.positions[corner[1]] - before.positions[corner[0]]);
  vertex.edge_v = world * (before.positions[corner[2]] - before.positions[corner[0]]);
  vertex.normal = surface.frame.z;
  if (instance.HasChangedShape()) {
    vertex.normal = PreviousNormalAt(instance, hit, surface.frame.z);
  } else if (instance.moving) {
    vertex.normal = SafeNormalize(to_normal * (from_normal * surface.frame.z), surface.frame.z);
  }
  const vec3 n0 = normal_at(0);
  const float side = dot(n0, vertex.normal) < 0.0f ? -1.0f : 1.0f;
  vertex.normal_u = (normal_at(1) - n0) * side;
  vertex.normal_v = (normal_at(2) - n0) * side;
  vertex.eta = eta;
  return vertex;
}

/// Continues a chain from a surface. \return false if it ends there
bool Continue(const TraceContext& context, const Hit& hit, const Surface& surface,
              const Leaving& leaving, Chain* chain, RayBatch* rays) {
  if (leaving.pass == Pass::kEnd || chain->rays == kMostRays ||
      (leaving.pass != Pass::kStraight && chain->count == kMostVertices)) {
    return false;
  }
  vec3 direction = chain->direction;
  if (leaving.pass == Pass::kReflect) {
    direction -= 2.0f * dot(direction, surface.frame.z) * surface.frame.z;
  } else if (leaving.pass == Pass::kRefract) {
    direction = RefractAbout(surface.wo, surface.frame.z, leaving.eta);
  }
  const bool above = dot(direction, surface.geometric) > 0.0f;
  if (above != (leaving.pass == Pass::kReflect)) {
    return false;  // the shading normal leads through the surface
  }
  if (leaving.pass != Pass::kStraight) {
    const size_t i = static_cast<size_t>(chain->count++);
    chain->vertex[i] = MakeVertex(context, hit, surface, leaving.eta);
  }
  ++chain->rays;
  chain->direction = direction;
  rays->Push(OriginOf(surface, direction), direction, kInfinity);
  return true;
}

/// The end of a chain in the previous frame: a point, or a direction to the sky.
struct ChainEnd {
  vec3 point;  ///< or direction
  bool is_sky = false;
};

/// Rays of the previous frame along a chain, and how far they pass its end.
struct ChainSearch {
  const CameraView& camera;
  const Chain& chain;
  const ChainEnd& end;
  LocalFrame axes = {};  ///< across the last ray

  ChainRay Shoot(vec2 pixel) const {
    ChainRay ray = {camera.position, camera.Direction(pixel)};
    for (int i = 0; i < chain.count; ++i) {
      ray = PassVertex(chain.vertex[static_cast<size_t>(i)], ray);
    }
    return ray;
  }
  vec2 MissAt(vec2 pixel) const {
    const ChainRay ray = Shoot(pixel);
    const vec3 wanted = end.is_sky ? end.point : end.point - ray.origin;
    const vec3 miss = wanted - ray.direction * dot(wanted, ray.direction);
    return {dot(miss, axes.x), dot(miss, axes.y)};
  }
};

/// The change of the miss per pixel.
struct MissSlope {
  vec2 by_x;
  vec2 by_y;

  MissSlope(const ChainSearch& search, vec2 at, vec2 miss) {
    constexpr float kStep = 0.5f;  // pixels
    by_x = (search.MissAt(at + vec2(kStep, 0.0f)) - miss) / kStep;
    by_y = (search.MissAt(at + vec2(0.0f, kStep)) - miss) / kStep;
  }
  /// The step to where a linear miss would be zero.
  vec2 StepFrom(vec2 miss) const {
    const float determinant = by_x.x * by_y.y - by_x.y * by_y.x;
    return vec2(by_y.x * miss.y - by_y.y * miss.x, by_x.y * miss.x - by_x.x * miss.y) / determinant;
  }
};

/// The place of the image in the previous frame: Newton's method on the pixel whose ray reaches the
/// end of the chain. Exact for planar mirrors. \return false if none is found
bool FindPreviousPlace(const CameraView& camera, const Chain& chain, const ChainEnd& end,
                       vec2* place) {
  constexpr int kIterations = 10;
  constexpr float kConverged = 0.002f;  // pixels
  constexpr float kAccepted = 0.1f;
  constexpr float kSlow = 0.25f;  // steps that shrink less need the slope at their place
  const vec3 first = chain.count > 0 ? chain.vertex[0].position - camera.position
                                     : (end.is_sky ? end.point : end.point - camera.position);
  if (dot(first, camera.forward) <= 0.0f) {
    return false;
  }
  vec2 at = camera.Project(first);
  ChainSearch search = {camera, chain, end};
  search.axes = MakeLocalFrame(search.Shoot(at).direction);
  vec2 miss = search.MissAt(at);
  MissSlope slope(search, at, miss);
  float change = kInfinity;
  for (int i = 0; i < kIterations && chain.count > 0; ++i) {
    const vec2 step = slope.StepFrom(miss);
    const float before = change;
    change = length(step);
    if (!(change < camera.width + camera.height)) {
      return false;
    }
    at += step;
    if (change <= kConverged) {
      break;
    }
    miss = search.MissAt(at);
    if (change > kSlow * before) {
      slope = MissSlope(search, at, miss);
    }
  }
  *place = at;
  return chain.count == 0 || change <= kAccepted;
}

vec2 MotionOf(const TraceContext& context, const Chain& chain, const ChainEnd& end, vec2 now) {
  vec2 before;
  if (!FindPreviousPlace(context.previous_camera, chain, end, &before)) {
    return MotionOutOfPicture(context.previous_camera);
  }
  return before - now;
}

/// The image at the end of a chain on a surface.
VirtualImage ImageOf(const TraceContext& context, const Chain& chain, const PrimaryPixel& pixel,
                     const Hit& hit, const Surface& surface, const Bsdf& bsdf,
                     vec3 specular_albedo) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  VirtualImage image;
  image.depth = chain.length * dot(pixel.direction, context.camera.forward);
  image.normal = surface.frame.z;
  const vec3 own = instance.material->emits()
                       ? max(context.state.Emission(hit), vec3(kLeastRadiance))
                       : min(DiffuseAlbedo(bsdf) + specular_albedo, vec3(1.0f));
  image.albedo = own * chain.throughput;
  image.id = hit.instance + 1;
  const ChainEnd end = {PreviousPoint(instance, hit, surface.position)};
  image.motion = MotionOf(context, chain, end, context.camera.Project(pixel.direction));
  return image;
}

VirtualImage ImageOfSky(const TraceContext& context, const Chain& chain,
                        const PrimaryPixel& pixel) {
  VirtualImage image;
  image.depth = kInfinity;
  image.albedo = chain.throughput *
                 max(context.lights.environment().Radiance(chain.direction), vec3(kLeastRadiance));
  image.motion =
      MotionOf(context, chain, {chain.direction, true}, context.camera.Project(pixel.direction));
  return image;
}

/// The chains of a batch.
class Tracer {
 public:
  Tracer(const TraceContext& context, const PrimaryPixel* pixels, RayScratch* scratch,
         VirtualImage* images, RenderTimings* timings)
      : context_(context),
        pixels_(pixels),
        scratch_(*scratch),
        images_(images),
        timings_(*timings) {
    scratch_.rays.count = 0;
  }

  void Start(int pixel, const FirstSurface& first) {
    const PrimaryPixel& of = pixels_[pixel];
    Chain chain;
    chain.pixel = pixel;
    chain.direction = of.direction;
    chain.length = length(first.surface.position - context_.camera.position);
    const Leaving leaving = LeavingOf(first.surface, first.bsdf, vec3(1.0f), true);
    const Chain start = chain;
    if (Continue(context_, of.layers[0].hit, first.surface, leaving, &chain, &scratch_.rays)) {
      chains_.push_back(chain);
    }
    if (leaving.pass == Pass::kRefract || leaving.pass == Pass::kStraight) {
      starts_.push_back({start, of.layers[0].hit, first.surface, leaving.reflectance});
    }
  }

  /// Looks for lights that glass reflects, after all other chains have ended.
  void SeekLights() {
    for (const GlassStart& glass : starts_) {
      Chain chain = glass.chain;
      chain.seeks_light = true;
      chain.reflectance = glass.reflectance;
      if (Continue(context_, glass.hit, glass.surface, {Pass::kReflect}, &chain, &scratch_.rays)) {
        chains_.push_back(chain);
      }
    }
    Run();
  }

  void Run() {
    while (!chains_.empty()) {
      timings_.image_rays += static_cast<uint64_t>(scratch_.rays.count);
      context_.accel.IntersectIncoherent(scratch_.rays, &scratch_.hits);
      Step();
    }
  }

 private:
  /// A visible surface of glass.
  struct GlassStart {
    Chain chain;
    Hit hit;
    Surface surface;
    float reflectance = 0;
  };

  /// Whether glass visibly reflects light of this radiance.
  bool IsVisible(const Chain& chain, vec3 radiance) const {
    return chain.reflectance * Luminance709(radiance) >
           kVisibleLight * context_.lights.environment().arrays().mean_luminance;
  }

  void Step() {
    std::vector<Chain> next;
    rays_ = scratch_.rays;
    scratch_.rays.count = 0;
    for (size_t i = 0; i < chains_.size(); ++i) {
      Chain& chain = chains_[i];
      const Hit hit = scratch_.hits.Get(static_cast<int>(i));
      if (hit.instance == kNoHit) {
        const bool is_light =
            !chain.seeks_light ||
            IsVisible(chain, context_.lights.environment().Radiance(chain.direction));
        if (is_light) {
          images_[chain.pixel] = ImageOfSky(context_, chain, pixels_[chain.pixel]);
        }
        continue;
      }
      if (Meet(hit, rays_.Origin(static_cast<int>(i)), &chain)) {
        next.push_back(chain);
      }
    }
    chains_ = std::move(next);
  }

  /// \return whether the chain continues
  bool Meet(const Hit& hit, vec3 origin, Chain* chain) {
    const Surface surface = MakeSurface(context_.state, hit, chain->direction);
    chain->length += length(surface.position - origin);
    if (context_.state.Opacity(hit) < 0.5f) {
      return Continue(context_, hit, surface, {Pass::kStraight}, chain, &scratch_.rays);
    }
    if (chain->seeks_light &&
        !(surface.material->emits() && IsVisible(*chain, context_.state.Emission(hit)))) {
      return false;
    }
    vec3 specular_albedo;
    const Bsdf bsdf = context_.bsdfs.Make(surface, 0.0f, &specular_albedo);
    const Leaving leaving = LeavingOf(surface, bsdf, specular_albedo, false);
    const vec3 before = chain->throughput;
    chain->throughput *= leaving.pass == Pass::kReflect ? specular_albedo : bsdf.tint;
    if (Continue(context_, hit, surface, leaving, chain, &scratch_.rays)) {
      return true;
    }
    chain->throughput = before;
    images_[chain->pixel] =
        ImageOf(context_, *chain, pixels_[chain->pixel], hit, surface, bsdf, specular_albedo);
    return false;
  }

  const TraceContext& context_;
  const PrimaryPixel* pixels_;
  RayScratch& scratch_;
  VirtualImage* images_;
  RenderTimings& timings_;
  RayBatch rays_;
  std::vector<Chain> chains_;
  std::vector<GlassStart> starts_;
};

}  // namespace

bool MayShowImages(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) {
    const bool coat = m.clearcoat > 0.0f && (m.clearcoat_roughness <= kSmoothRoughness ||
                                             m.clearcoat_roughness_texture.texture >= 0);
    return coat || m.roughness <= kSmoothRoughness || m.metallic_roughness_texture.texture >= 0;
  });
}

void FindVirtualImages(const TraceContext& context, const PrimaryPixel* pixels,
                       const FirstSurface* first, int count, RayScratch* scratch,
                       VirtualImage* images, RenderTimings* timings) {
  const PhaseTimer timer(&timings->image_ms);
  Tracer tracer(context, pixels, scratch, images, timings);
  for (int i = 0; i < count; ++i) {
    images[i] = VirtualImage();
    if (pixels[i].count == 1) {
      tracer.Start(i, first[i]);
    }
  }
  tracer.Run();
  tracer.SeekLights();
}

void StoreVirtualImages(const Tile& tile, const VirtualImage* images, VirtualGuides* guides) {
  for (int i = 0; i < tile.count(); ++i) {
    const int x = tile.x0 + i % tile.width;
    const int y = tile.y0 + i / tile.width;
    const VirtualImage& image = images[i];
    guides->depth(x, y) = image.depth;
    guides->motion[0](x, y) = image.motion.x;
    guides->motion[1](x, y) = image.motion.y;
    guides->id(x, y) = image.id;
    StorePixel(&guides->normal, x, y, image.normal);
    StorePixel(&guides->albedo, x, y, image.albedo);
  }
}

}  // namespace stillray::render
