// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/virtual_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/colour.h"
#include "render/chain_search_shared.h"
#include "render/frame_store.h"
#include "render/guides.h"
#include "render/previous_normals.h"

namespace stillray::render {
namespace {

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

  ChainArrays arrays() const { return {vertex.data(), count}; }
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
  const VertexArrays& before = instance.previous_vertices;
  const vec3 n = surface.frame.z;
  ChainTriangle triangle;
  triangle.edge_u = before.positions[corner[1]] - before.positions[corner[0]];
  triangle.edge_v = before.positions[corner[2]] - before.positions[corner[0]];
  triangle.normal_0 = before.normals[corner[0]];
  triangle.normal_1 = before.normals[corner[1]];
  triangle.normal_2 = before.normals[corner[2]];
  triangle.world = mat3(instance.world);
  triangle.before = mat3(instance.moving ? instance.previous_world : instance.world);
  triangle.moving = instance.moving ? 1 : 0;
  return MakeChainVertex(
      triangle, PreviousPoint(instance, hit, surface.position), n,
      instance.HasChangedShape() ? PreviousNormalAt(instance, hit, n) : MovedNormal(triangle, n),
      eta);
}

/// Continues a chain from a surface. \return false if it ends there
bool Continue(const TraceContext& context, const Hit& hit, const Surface& surface,
              const Leaving& leaving, Chain* chain, RayBatch* rays) {
  if (leaving.way == kChainEnds || chain->rays == kMostChainRays ||
      (leaving.way != kChainGoesOn && chain->count == kMostVertices)) {
    return false;
  }
  vec3 direction = chain->direction;
  if (!TurnChain(leaving, surface, direction)) {
    return false;
  }
  if (leaving.way != kChainGoesOn) {
    const size_t i = static_cast<size_t>(chain->count++);
    chain->vertex[i] = MakeVertex(context, hit, surface, leaving.eta);
  }
  ++chain->rays;
  chain->direction = direction;
  rays->Push(OriginOf(surface, direction), direction, kInfinity);
  return true;
}

vec2 MotionOf(const TraceContext& context, const Chain& chain, const ChainEnd& end, vec2 now) {
  vec2 before;
  if (!FindPreviousPlace(chain.arrays(), context.previous_camera, end, before)) {
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
  const ChainEnd end = {PreviousPoint(instance, hit, surface.position), 0};
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
      MotionOf(context, chain, {chain.direction, 1}, context.camera.Project(pixel.direction));
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
    const Leaving leaving = LeavingOf(first.bsdf, first.surface, vec3(1.0f), 1);
    const Chain start = chain;
    if (Continue(context_, of.layers[0].hit, first.surface, leaving, &chain, &scratch_.rays)) {
      chains_.push_back(chain);
    }
    if (leaving.way == kChainRefracts || leaving.way == kChainGoesOn) {
      starts_.push_back({start, of.layers[0].hit, first.surface, leaving.reflectance});
    }
  }

  /// Looks for lights that glass reflects, after all other chains have ended.
  void SeekLights() {
    for (const GlassStart& glass : starts_) {
      Chain chain = glass.chain;
      chain.seeks_light = true;
      chain.reflectance = glass.reflectance;
      if (Continue(context_, glass.hit, glass.surface, LeavingBy(kChainReflects), &chain,
                   &scratch_.rays)) {
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
    if (context_.state.Opacity(hit) < kChainOpacity) {
      return Continue(context_, hit, surface, LeavingBy(kChainGoesOn), chain, &scratch_.rays);
    }
    if (chain->seeks_light &&
        !(surface.material->emits() && IsVisible(*chain, context_.state.Emission(hit)))) {
      return false;
    }
    vec3 specular_albedo;
    const Bsdf bsdf = context_.bsdfs.Make(surface, 0.0f, &specular_albedo);
    const Leaving leaving = LeavingOf(bsdf, surface, specular_albedo, 0);
    const vec3 before = chain->throughput;
    chain->throughput *= leaving.way == kChainReflects ? specular_albedo : bsdf.tint;
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

bool WantsImages(const RenderSettings& settings) {
  return settings.virtual_guides &&
         (settings.cycle == 1 || settings.guides == GuideCoverage::kFull);
}

void PrepareVirtualGuides(const RenderSettings& settings, bool shown, Frame* frame) {
  VirtualGuides& image = frame->reflection;
  frame->refraction = VirtualGuides();
  if (!shown) {
    image = VirtualGuides();
    return;
  }
  ResizeImage(&image.depth, settings.width, settings.height);
  ResizeImage(&image.normal, settings.width, settings.height);
  ResizeImage(&image.albedo, settings.width, settings.height);
  ResizeImage(&image.motion, settings.width, settings.height);
  ResizeImage(&image.id, settings.width, settings.height);
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
