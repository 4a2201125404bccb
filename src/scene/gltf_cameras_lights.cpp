// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "scene/gltf_import.h"

namespace stillray {

namespace {

constexpr float kPi = 3.14159265f;
constexpr float kHalfPi = 1.57079633f;

bool ReadColour(const JsonView& view, vec3* colour) {
  view.Numbers("color", &colour->x, 3);
  if (colour->x < 0 || colour->y < 0 || colour->z < 0) {
    view.Fail("color", "is negative");
    return false;
  }
  return true;
}

void ReadSpot(const JsonView& light, PunctualLight* out) {
  const JsonView spot = light.Object("spot");
  out->outer_cone_angle = spot.NumberIn("outerConeAngle", out->outer_cone_angle, 1e-3f, kHalfPi);
  out->inner_cone_angle =
      spot.NumberIn("innerConeAngle", out->inner_cone_angle, 0.0f, out->outer_cone_angle);
}

/// Reads camera.extras.lens, if it has stillray's format.
Lens ReadLens(GltfImport* import, const JsonView& camera) {
  Lens lens;
  if (!camera.IsObject("extras") || !camera.Object("extras").IsObject("lens")) {
    return lens;
  }
  const JsonView view = camera.Object("extras").Object("lens");
  constexpr float kAny = std::numeric_limits<float>::max();
  lens.radius = view.Number("aperture", 0.0f);
  lens.f_number = view.Number("f_number", 0.0f);
  lens.focus = view.Number("focus", 0.0f);
  lens.blades = static_cast<int>(std::min<uint64_t>(view.Count("blades", 0), kMaxBlades + 1));
  lens.rotation = view.NumberIn("rotation", 0.0f, -kAny, kAny);
  if (!(lens.radius >= 0.0f && lens.radius <= 1e6f)) {
    view.Fail("aperture", fmt::format("{} is no radius (0 to 1e6)", lens.radius));
  } else if (view.Has("f_number") && !(lens.f_number >= 0.1f && lens.f_number <= 1000.0f)) {
    view.Fail("f_number", fmt::format("{} is no f-number (0.1 to 1000)", lens.f_number));
  } else if (view.Has("focus") && !(lens.focus > 0.0f)) {
    view.Fail("focus", fmt::format("{} is no distance above 0", lens.focus));
  } else if (lens.blades != 0 && (lens.blades < 3 || lens.blades > kMaxBlades)) {
    view.Fail("blades", fmt::format("is not 0 or 3 to {}", kMaxBlades));
  }
  const int mask = view.Index("mask", import->Root().Size("textures"), "textures");
  if (mask >= 0 && import->log.ok()) {
    lens.mask = UseTexture(import, mask);
  }
  return lens;
}

}  // namespace

void ImportNodeCamera(GltfImport* import, const JsonView& node, int scene_node) {
  const JsonView root = import->Root();
  const int index = node.Index("camera", root.Size("cameras"), "cameras");
  if (index < 0) {
    return;
  }
  const JsonView view = root.Item("cameras", static_cast<size_t>(index));
  const std::string type = view.String("type");
  if (type != "perspective") {
    view.Warn("type",
              fmt::format("'{}' cameras are not supported, it is left out", Printable(type)));
    return;
  }
  const JsonView perspective = view.Object("perspective");
  Camera camera;
  camera.name = view.String("name", import->scene.nodes[static_cast<size_t>(scene_node)].name);
  camera.node = scene_node;
  camera.yfov = perspective.Number("yfov", 0.0f);
  camera.aspect = perspective.Number("aspectRatio", 0.0f);
  if (!import->log.ok()) {
    return;
  }
  if (!(camera.yfov > 0.0f && camera.yfov < kPi)) {
    view.Fail("perspective.yfov",
              fmt::format("{} is no angle of view (radians, 0..pi)", camera.yfov));
    return;
  }
  if (perspective.Has("aspectRatio") && !(camera.aspect > 0.0f)) {
    perspective.Warn("aspectRatio", fmt::format("{} is left out", camera.aspect));
    camera.aspect = 0.0f;
  }
  camera.lens = ReadLens(import, view);
  import->scene.cameras.push_back(std::move(camera));
}

void ImportNodeLight(GltfImport* import, const JsonView& node, int scene_node) {
  constexpr const char* kName = "KHR_lights_punctual";
  const JsonView reference = node.Extension(kName);
  if (!reference.exists()) {
    return;
  }
  const JsonView lights = import->Root().Extension(kName);
  const int index = reference.Index("light", lights.Size("lights"), "lights");
  if (index < 0) {
    return;
  }
  const JsonView view = lights.Item("lights", static_cast<size_t>(index));
  const std::string type = view.String("type");
  PunctualLight light;
  light.name = view.String("name", import->scene.nodes[static_cast<size_t>(scene_node)].name);
  light.node = scene_node;
  if (type == "point") {
    light.type = LightType::kPoint;
  } else if (type == "spot") {
    light.type = LightType::kSpot;
    ReadSpot(view, &light);
  } else if (type == "directional") {
    light.type = LightType::kDirectional;
  } else {
    view.Fail("type", fmt::format("'{}' is not point, spot or directional", Printable(type)));
    return;
  }
  vec3 colour(1.0f);
  const float intensity = view.NumberIn("intensity", 1.0f, 0.0f, std::numeric_limits<float>::max());
  if (!ReadColour(view, &colour)) {
    return;
  }
  light.intensity = colour * intensity;
  if (view.Has("range")) {
    light.range = view.Number("range", light.range);
    if (!(light.range > 0.0f)) {
      view.Warn("range", fmt::format("{} is left out", light.range));
      light.range = std::numeric_limits<float>::infinity();
    }
  }
  import->scene.lights.push_back(std::move(light));
}

}  // namespace stillray
