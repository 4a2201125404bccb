// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/virtual_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/colour.h"
#include "render/base_colour.h"
#include "render/chain_search_shared.h"
#include "render/frame_store.h"
#include "render/guides.h"
#include "render/previous_normals.h"

namespace stillray::render {
namespace {

/// A specular chain.
struct Chain {
  int pixel = 0;
  VirtualImage* image = nullptr;  ///< [out]
  vec3 direction;
  PixelRays beside;  ///< with filtered textures
  float length = 0;
  vec3 throughput = vec3(1.0f);  ///< colour of the surfaces behind the first one
  int count = 0;
  int rays = 0;
  std::array<ChainVertex, kMostVertices> vertex;  ///< in the previous frame

  ChainArrays arrays() const { return {vertex.data(), count}; }
};

/// The position of a hit point in the previous frame.
vec3 PreviousPoint(const PlacedInstance& instance, const Hit& hit, vec3 now) {
  return instance.moving
             ? vec3(instance.previous_world *
                    vec4(LocalPoint(*instance.mesh, instance.previous_vertices.positions, hit),
                         1.0f))
             : now;
}

/// The triangle of a hit with these vertices; `before` and `moving` are left to the caller.
ChainTriangle TriangleIn(const PlacedInstance& instance, const Hit& hit,
                         const VertexArrays& vertices) {
  const uint32_t* corner = instance.mesh->indices.data() + 3 * static_cast<size_t>(hit.primitive);
  ChainTriangle triangle;
  triangle.edge_u = vertices.positions[corner[1]] - vertices.positions[corner[0]];
  triangle.edge_v = vertices.positions[corner[2]] - vertices.positions[corner[0]];
  triangle.normal_0 = vertices.normals[corner[0]];
  triangle.normal_1 = vertices.normals[corner[1]];
  triangle.normal_2 = vertices.normals[corner[2]];
  triangle.world = mat3(instance.world);
  return triangle;
}

/// The chain vertex of a hit, in the previous frame.
ChainVertex MakeVertex(const TraceContext& context, const Hit& hit, const Surface& surface,
                       float eta) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  const vec3 n = surface.frame.z;
  ChainTriangle triangle = TriangleIn(instance, hit, instance.previous_vertices);
  triangle.before = mat3(instance.moving ? instance.previous_world : instance.world);
  triangle.moving = instance.moving ? 1 : 0;
  return MakeChainVertex(
      triangle, PreviousPoint(instance, hit, surface.position), n,
      instance.HasChangedShape() ? PreviousNormalAt(instance, hit, n) : MovedNormal(triangle, n),
      eta);
}

/// The chain vertex of a hit in the current frame.
ChainVertex CurrentVertex(const TraceContext& context, const Hit& hit, const Surface& surface,
                          float eta) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  ChainTriangle triangle = TriangleIn(instance, hit, instance.vertices);
  triangle.before = triangle.world;
  triangle.moving = 0;
  return MakeChainVertex(triangle, surface.position, surface.frame.z, surface.frame.z, eta);
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
    if (context.filters_textures) {
      const ChainVertex now = context.state.instance(hit.instance).moving
                                  ? CurrentVertex(context, hit, surface, leaving.eta)
                                  : chain->vertex[i];
      chain->beside.right = PassVertex(now, chain->beside.right);
      chain->beside.down = PassVertex(now, chain->beside.down);
    }
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

/// The total albedo of all lobes of a surface.
vec3 WholeAlbedo(const Bsdf& bsdf, const SpecularAlbedo& specular) {
  return min(DiffuseAlbedo(bsdf) + SumOf(specular), vec3(1.0f));
}

/// The virtual image of a chain that ends on a surface.
VirtualImage ImageOf(const TraceContext& context, const Chain& chain, const PrimaryPixel& pixel,
                     const Hit& hit, const Surface& surface, const Bsdf& bsdf,
                     const SpecularAlbedo& specular) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  VirtualImage image;
  image.depth = chain.length * dot(pixel.direction, context.camera.forward);
  image.normal = surface.frame.z;
  const bool emits = instance.material->emits();
  const vec3 emission = emits ? context.state.Emission(hit) : vec3(0.0f);
  const vec3 own = emits ? max(emission, vec3(kLeastRadiance)) : WholeAlbedo(bsdf, specular);
  image.light = chain.count == 1 ? ChainLuminance(emission) : 0.0f;
  image.albedo = own * chain.throughput;
  image.id = hit.instance + 1;
  image.hit = hit;
  image.base_colour = surface.base_colour;
  const ChainEnd end = {PreviousPoint(instance, hit, surface.position), 0};
  image.motion = MotionOf(context, chain, end, context.camera.Project(pixel.direction));
  return image;
}

VirtualImage ImageOfSky(const TraceContext& context, const Chain& chain,
                        const PrimaryPixel& pixel) {
  const vec3 radiance = context.lights.environment().Radiance(chain.direction);
  VirtualImage image;
  image.depth = kInfinity;
  image.albedo = chain.throughput * max(radiance, vec3(kLeastRadiance));
  image.light = chain.count == 1 ? ChainLuminance(radiance) : 0.0f;
  image.motion =
      MotionOf(context, chain, {chain.direction, 1}, context.camera.Project(pixel.direction));
  return image;
}

/// The virtual image of the surface behind an alpha-blended one. The emission of that surface is
/// not part of the signals.
VirtualImage ImageBehind(const TraceContext& context, const PrimaryPixel& pixel) {
  const Hit& hit = HeaviestLayer(pixel, 1)->hit;
  const Surface surface =
      MakeSurface(context.state, hit, vec3(context.state.BaseColour(hit)), pixel.direction);
  SpecularAlbedo specular;
  const Bsdf bsdf = context.bsdfs.Make(surface, 0.0f, &specular);
  VirtualImage image;
  image.depth = context.camera.Depth(surface.position);
  image.normal = surface.frame.z;
  image.albedo = WholeAlbedo(bsdf, specular);
  image.motion = MotionOfSurface(context, pixel, hit, surface.position);
  image.id = hit.instance + 1;
  return image;
}

/// Traces the chains of a batch.
class ImageTracer {
 public:
  ImageTracer(const TraceContext& context, const PrimaryPixel* pixels, RayScratch* scratch,
              RenderTimings* timings)
      : context_(context), pixels_(pixels), scratch_(*scratch), timings_(*timings) {
    scratch_.rays.count = 0;
  }

  /// \param image  [out] set by Run if the chain ends at a virtual image
  void Start(int pixel, const FirstSurface& first, const Leaving& leaving, VirtualImage* image) {
    Chain chain;
    chain.pixel = pixel;
    chain.image = image;
    chain.direction = pixels_[pixel].direction;
    chain.beside = RaysBeside(context_.camera, pixels_[pixel].point);
    chain.length = length(first.surface.position - context_.camera.position);
    if (Continue(context_, pixels_[pixel].layers[0].hit, first.surface, leaving, &chain,
                 &scratch_.rays)) {
      chains_.push_back(chain);
    }
  }

  void Run() {
    while (!chains_.empty()) {
      timings_.image_rays += static_cast<uint64_t>(scratch_.rays.count);
      context_.accel.IntersectIncoherent(scratch_.rays, &scratch_.hits);
      Step();
    }
  }

 private:
  void Step() {
    std::vector<Chain> next;
    rays_ = scratch_.rays;
    scratch_.rays.count = 0;
    for (size_t i = 0; i < chains_.size(); ++i) {
      Chain& chain = chains_[i];
      const Hit hit = scratch_.hits.Get(static_cast<int>(i));
      if (hit.instance == kNoHit) {
        *chain.image = ImageOfSky(context_, chain, pixels_[chain.pixel]);
      } else if (Meet(hit, rays_.Origin(static_cast<int>(i)), &chain)) {
        next.push_back(chain);
      }
    }
    chains_ = std::move(next);
  }

  /// \return whether the chain continues
  bool Meet(const Hit& hit, vec3 origin, Chain* chain) {
    const vec3 base_colour =
        BaseColourOf(context_, hit, chain->beside, pixels_[chain->pixel].point);
    const Surface surface = MakeSurface(context_.state, hit, base_colour, chain->direction);
    chain->length += length(surface.position - origin);
    if (context_.state.Opacity(hit) < kChainOpacity) {
      return Continue(context_, hit, surface, LeavingBy(kChainGoesOn), chain, &scratch_.rays);
    }
    SpecularAlbedo specular;
    const Bsdf bsdf = context_.bsdfs.Make(surface, 0.0f, &specular);
    const Leaving leaving = LeavingOf(bsdf, surface, SumOf(specular));
    const vec3 before = chain->throughput;
    chain->throughput *= leaving.way == kChainReflects ? SumOf(specular) : bsdf.tint;
    if (Continue(context_, hit, surface, leaving, chain, &scratch_.rays)) {
      return true;
    }
    chain->throughput = before;
    *chain->image = ImageOf(context_, *chain, pixels_[chain->pixel], hit, surface, bsdf, specular);
    return false;
  }

  const TraceContext& context_;
  const PrimaryPixel* pixels_;
  RayScratch& scratch_;
  RenderTimings& timings_;
  RayBatch rays_;
  std::vector<Chain> chains_;
};

}  // namespace

ImageKinds ImagesOfScene(const Scene& scene) {
  ImageKinds kinds;
  for (const Material& m : scene.materials) {
    const bool coat = m.clearcoat > 0.0f && (m.clearcoat_roughness <= kMostReflectingRoughness ||
                                             m.clearcoat_roughness_texture.texture >= 0);
    kinds.reflection = kinds.reflection || coat || m.roughness <= kMostReflectingRoughness ||
                       m.metallic_roughness_texture.texture >= 0;
    kinds.refraction =
        kinds.refraction || m.transmission > 0.0f || m.alpha_mode == AlphaMode::kBlend;
  }
  return kinds;
}

ImageKinds WantedImages(const RenderSettings& settings, const ImageKinds& of_scene, bool has_lens) {
  const bool wanted = settings.virtual_guides && !has_lens &&
                      (settings.cycle == 1 || settings.guides == GuideCoverage::kFull);
  return wanted ? of_scene : ImageKinds();
}

namespace {

void PrepareImage(const RenderSettings& settings, bool shown, VirtualGuides* image) {
  if (!shown) {
    *image = VirtualGuides();
    return;
  }
  ResizeImage(&image->depth, settings.width, settings.height);
  ResizeImage(&image->normal, settings.width, settings.height);
  ResizeImage(&image->albedo, settings.width, settings.height);
  ResizeImage(&image->motion, settings.width, settings.height);
  ResizeImage(&image->id, settings.width, settings.height);
}

}  // namespace

void PrepareVirtualGuides(const RenderSettings& settings, const ImageKinds& shown, Frame* frame) {
  PrepareImage(settings, shown.reflection, &frame->reflection);
  PrepareImage(settings, shown.refraction, &frame->refraction);
}

void FindVirtualImages(const TraceContext& context, const ImageKinds& shown,
                       const PrimaryPixel* pixels, const FirstSurface* first, const bool* separates,
                       int count, RayScratch* scratch, ImageBatch* images, RenderTimings* timings) {
  const PhaseTimer timer(&timings->image_ms);
  std::fill_n(images->reflection, count, VirtualImage());
  std::fill_n(images->refraction, count, VirtualImage());
  ImageTracer reflections(context, pixels, scratch, timings);
  for (int i = 0; shown.reflection && i < count; ++i) {
    if (pixels[i].count == 1) {
      const Leaving leaving = FirstReflection(first[i].bsdf);
      reflections.Start(i, first[i], leaving, &images->reflection[i]);
    }
  }
  reflections.Run();
  ImageTracer transmissions(context, pixels, scratch, timings);
  for (int i = 0; shown.refraction && i < count; ++i) {
    if (pixels[i].count == 1 && separates[i]) {
      const Leaving leaving = LeavingThrough(first[i].bsdf, first[i].surface);
      transmissions.Start(i, first[i], leaving, &images->refraction[i]);
    } else if (pixels[i].count > 1) {
      images->refraction[i] = ImageBehind(context, pixels[i]);
    }
  }
  transmissions.Run();
  const float mean_sky = context.lights.environment().arrays().mean_luminance;
  for (int i = 0; shown.reflection && shown.refraction && i < count; ++i) {
    if (separates[i] && pixels[i].count == 1 &&
        ReflectsVisibly(SolidReflectance(first[i].bsdf, first[i].surface),
                        images->reflection[i].light, mean_sky)) {
      images->refraction[i] = images->reflection[i];
    }
  }
}

vec3 BaseColourOfVertex(const TraceContext& context, const ImageBatch* images, int pixel,
                        const Hit& hit) {
  if (images != nullptr) {
    for (const VirtualImage* image : {&images->reflection[pixel], &images->refraction[pixel]}) {
      const Hit& end = image->hit;
      if (end.instance == hit.instance && end.primitive == hit.primitive &&
          std::abs(end.u - hit.u) + std::abs(end.v - hit.v) < kSameBarycentrics) {
        return image->base_colour;
      }
    }
  }
  return vec3(context.state.BaseColour(hit));
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
