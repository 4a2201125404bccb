// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/guides.h"

#include <limits>

#include "render/base_colour.h"
#include "render/previous_normals.h"
#include "render/virtual_image_shared.h"

namespace stillray::render {
namespace {

/// The cameras of a primary ray in the current and the previous frame, at the same point of the
/// lens: motion vectors are relative to that point.
struct PixelViews {
  CameraView now;
  CameraView before;
};

vec2 MotionBetween(const PixelViews& views, vec3 offset, vec3 previous_offset) {
  if (dot(previous_offset, views.before.forward) <= 0.0f) {
    return MotionOutOfPicture(views.before);
  }
  return views.before.Project(previous_offset) - views.now.Project(offset);
}

vec2 SurfaceMotion(const TraceContext& context, const PixelViews& views, const Hit& hit,
                   vec3 position) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  if (!instance.moving) {
    return MotionBetween(views, position - views.now.position, position - views.before.position);
  }
  const auto point = [&](const mat4& world, const VertexArrays& vertices) {
    return vec3(world * vec4(LocalPoint(*instance.mesh, vertices.positions, hit), 1.0f));
  };
  const vec3 now = point(instance.world, instance.vertices);
  const vec3 before = point(instance.previous_world, instance.previous_vertices);
  return MotionBetween(views, now - views.now.position, before - views.before.position);
}

vec3 EmissionTowards(const TraceContext& context, const Hit& hit, bool front) {
  const Material& material = *context.state.instance(hit.instance).material;
  return material.emits() && (front || material.double_sided) ? context.state.Emission(hit)
                                                              : vec3(0.0f);
}

/// Adds the albedos of layer `i`.
void AddAlbedos(const Bsdf& bsdf, const SpecularAlbedo& specular, const PrimaryPixel& pixel, int i,
                bool separates, PixelGuides* guides) {
  const float weight = pixel.layers[i].weight;
  if (separates && i > 0) {
    guides->transmission_albedo += vec3(weight);
    return;
  }
  const bool glass = separates && weight >= 1.0f && IsSmoothGlass(bsdf);
  guides->albedo += DiffuseAlbedo(bsdf) * weight;
  guides->specular_albedo += (glass ? specular.reflected : SumOf(specular)) * weight;
  guides->transmission_albedo += glass ? specular.transmitted * weight : vec3(0.0f);
}

/// The base colour of layer `i`: the mean over the pixel if it is opaque and the only one.
vec3 BaseColourOfLayer(const TraceContext& context, const CameraView& view,
                       const PrimaryPixel& pixel, int i) {
  const Hit& hit = pixel.layers[i].hit;
  if (pixel.layers[0].weight < 1.0f || !HasMeanColour(context, hit)) {
    return vec3(context.state.BaseColour(hit));
  }
  return BaseColourOf(context, hit, RaysBeside(view, pixel.point), pixel.point);
}

bool SeenFromFront(const TraceContext& context, const Hit& hit, vec3 direction) {
  const PlacedInstance& instance = context.state.instance(hit.instance);
  const Triangle t = context.state.TriangleOf(instance, hit.primitive);
  return dot(cross(t.p1 - t.p0, t.p2 - t.p0), direction) * instance.orientation <= 0.0f;
}

}  // namespace

const PrimaryLayer* HeaviestLayer(const PrimaryPixel& pixel, int begin) {
  const PrimaryLayer* heaviest = nullptr;
  for (int i = begin; i < pixel.count; ++i) {
    if (heaviest == nullptr || pixel.layers[i].weight > heaviest->weight) {
      heaviest = &pixel.layers[i];
    }
  }
  return heaviest;
}

vec2 MotionOfSurface(const TraceContext& context, const PrimaryPixel& pixel, const Hit& hit,
                     vec3 position) {
  return SurfaceMotion(context,
                       {ViewOf(context.camera, pixel), ViewOf(context.previous_camera, pixel)}, hit,
                       position);
}

vec2 MotionOutOfPicture(const CameraView& camera) {
  return {2.0f * camera.width, 2.0f * camera.height};
}

vec3 LocalPoint(const Mesh& mesh, const vec3* positions, const Hit& hit) {
  const uint32_t* corner = mesh.indices.data() + 3 * static_cast<size_t>(hit.primitive);
  return positions[corner[0]] * (1.0f - hit.u - hit.v) + positions[corner[1]] * hit.u +
         positions[corner[2]] * hit.v;
}

PixelGuides MakeGuides(const TraceContext& context, const PrimaryPixel& pixel,
                       FirstSurface* first) {
  PixelGuides guides;
  const PixelViews views = {ViewOf(context.camera, pixel), ViewOf(context.previous_camera, pixel)};
  const bool separates = context.separates_transmission;
  const PrimaryLayer* shown =
      separates && pixel.count > 0 ? &pixel.layers[0] : HeaviestLayer(pixel, 0);
  if (shown == nullptr) {
    guides.depth = std::numeric_limits<float>::infinity();
    guides.motion = MotionBetween(views, pixel.direction, pixel.direction);
  }
  for (int i = 0; i < pixel.count; ++i) {
    const PrimaryLayer& layer = pixel.layers[i];
    const vec3 base_colour = BaseColourOfLayer(context, views.now, pixel, i);
    const Surface surface = MakeSurface(context.state, layer.hit, base_colour, pixel.direction);
    SpecularAlbedo specular;
    const Bsdf bsdf = context.bsdfs.Make(surface, 0.0f, &specular);
    AddAlbedos(bsdf, specular, pixel, i, separates, &guides);
    guides.emission += EmissionTowards(context, layer.hit, surface.front != 0) * layer.weight;
    if (pixel.count == 1) {
      *first = {surface, bsdf};
    }
    if (&layer == shown) {
      guides.depth = context.camera.Depth(surface.position);
      guides.normal = surface.frame.z;
      guides.motion = SurfaceMotion(context, views, layer.hit, surface.position);
      const PlacedInstance& instance = context.state.instance(layer.hit.instance);
      if (instance.HasChangedShape()) {
        guides.previous_normal = PreviousNormalAt(instance, layer.hit, surface.frame.z);
      }
      guides.id = layer.hit.instance + 1;
      guides.roughness = GuideRoughness(bsdf, surface.roughness);
    }
  }
  guides.background = context.lights.environment().Radiance(pixel.direction) * pixel.background;
  return guides;
}

UnscatteredLight FindUnscatteredLight(const TraceContext& context, const PrimaryPixel& pixel) {
  UnscatteredLight light;
  for (int i = 0; i < pixel.count; ++i) {
    const PrimaryLayer& layer = pixel.layers[i];
    const bool front = SeenFromFront(context, layer.hit, pixel.direction);
    light.emission += EmissionTowards(context, layer.hit, front) * layer.weight;
  }
  light.background = context.lights.environment().Radiance(pixel.direction) * pixel.background;
  return light;
}

}  // namespace stillray::render
