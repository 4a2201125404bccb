// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A car of curved, glossy paint and glass that turns on a plate outdoors: reflections that slide
/// over curved surfaces, thin panes before a dark interior, wheels with fine spokes.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "scene/builtin.h"

namespace stillray {

namespace {

// Metres. The car drives towards +x and stands on y = 0; it is symmetric in z.
constexpr float kPi = 3.14159265f;
constexpr float kAxle = 1.31f;  // x of the front axle, -x of the rear one
constexpr float kWheelRadius = 0.335f;
constexpr float kWheelZ = 0.76f;

// Signed distances of solids, negative inside. The smooth variants round the edge over about `k`.

float SmoothMin(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f) / k;
  return std::min(a, b) - 0.25f * k * h * h;
}

float SmoothMax(float a, float b, float k) {
  return -SmoothMin(-a, -b, k);
}

float Ellipsoid(vec3 p, vec3 radii) {
  const float k0 = glm::length(p / radii);
  const float k1 = glm::length(p / (radii * radii));
  return k1 > 0.0f ? k0 * (k0 - 1.0f) / k1 : -std::min({radii.x, radii.y, radii.z});
}

float RoundedBox(vec3 p, vec3 half, float rounding) {
  const vec3 q = glm::abs(p) - half + rounding;
  return glm::length(glm::max(q, vec3(0.0f))) + std::min(std::max({q.x, q.y, q.z}), 0.0f) -
         rounding;
}

/// A smooth curve y(x) through points in ascending x (cubic Hermite, tangents from neighbours).
struct Curve {
  std::vector<vec2> points;

  vec2 ValueAndSlope(float x) const {
    size_t i = 0;
    while (i + 2 < points.size() && x > points[i + 1].x) {
      ++i;
    }
    const vec2 a = points[i];
    const vec2 b = points[i + 1];
    const float width = b.x - a.x;
    const float m0 = width * Tangent(i);
    const float m1 = width * Tangent(i + 1);
    const float t = std::clamp((x - a.x) / width, 0.0f, 1.0f);
    const float c = 3.0f * (b.y - a.y) - 2.0f * m0 - m1;
    const float d = 2.0f * (a.y - b.y) + m0 + m1;
    const float slope = (m0 + t * (2.0f * c + t * 3.0f * d)) / width;
    // Linear extrapolation beyond the ends.
    const float beyond = x - (a.x + t * width);
    return {a.y + t * (m0 + t * (c + t * d)) + slope * beyond, slope};
  }

  float Tangent(size_t i) const {
    const vec2 before = points[i == 0 ? 0 : i - 1];
    const vec2 after = points[std::min(i + 1, points.size() - 1)];
    return (after.y - before.y) / (after.x - before.x);
  }

  /// Distance of (x, y) from the curve, above it positive, to first order.
  float Above(float x, float y) const {
    const vec2 at = ValueAndSlope(x);
    return (y - at.x) / std::sqrt(1.0f + at.y * at.y);
  }
};

/// The car's solids.
class CarShape {
 public:
  /// The outside without wheel wells, windows and grille.
  float Outer(vec3 p) const {
    const vec3 q(p.x, p.y, std::abs(p.z));
    const float body = SmoothMin(Lower(q), Cabin(q), 0.10f);
    return SmoothMin(body, Fenders(q), 0.22f);
  }

  /// The painted shell, hollow below the roof.
  float Shell(vec3 p) const {
    constexpr float kFarAway = 0.3f;  // beyond the reach of all cuts
    const float outer = Outer(p);
    if (outer > kFarAway) {
      return outer;
    }
    const vec3 q(p.x, p.y, std::abs(p.z));
    float d = SmoothMax(outer, -Wells(q), 0.05f);
    d = SmoothMax(d, -Ellipsoid(q - vec3(2.16f, 0.36f, 0.0f), vec3(0.22f, 0.085f, 0.48f)), 0.06f);
    d = SmoothMax(d, -Inside(q, outer), 0.04f);
    return SmoothMax(d, -Windows(p), 0.05f);
  }

  /// The solid that cuts the window openings; extends far beyond the surface.
  float Windows(vec3 p) const {
    const vec3 q(p.x, p.y, std::abs(p.z));
    constexpr float kFrame = 0.075f;
    constexpr float kBelt = 0.985f;
    const float roof = CabinTop(q);
    float side = SmoothMax(roof + kFrame, kBelt - q.y, 0.09f);
    side = SmoothMax(side, 0.035f - std::abs(q.x + 0.42f), 0.06f);  // a pillar between two panes
    side = std::max(side, 0.30f - q.z);
    const float across = CabinSide(q) + kFrame;
    const float front = SmoothMax(SmoothMax(across, q.y - 1.235f, 0.09f), 0.965f - q.y, 0.09f);
    const float rear = SmoothMax(SmoothMax(across, q.y - 1.20f, 0.09f), 1.02f - q.y, 0.09f);
    return std::min({side, std::max(front, 0.15f - q.x), std::max(rear, q.x + 0.85f)});
  }

 private:
  /// Lowers panels towards the sides, so that none is flat across.
  static float Crown(vec3 q) { return 0.07f * q.z * q.z; }

  float Lower(vec3 q) const {
    const float top = lower_top_.Above(q.x, q.y + Crown(q));
    const float from_waist = q.y - 0.56f;
    const float bulge = from_waist > 0.0f ? 0.62f : 0.50f;
    const float half_width = half_width_.ValueAndSlope(q.x).x - bulge * from_waist * from_waist;
    const float side = q.z - half_width;
    const float nose = q.x - (2.13f - 0.9f * (q.y - 0.46f) * (q.y - 0.46f) - 0.16f * q.z * q.z);
    const float tail = -q.x - (2.12f - 0.7f * (q.y - 0.66f) * (q.y - 0.66f) - 0.16f * q.z * q.z);
    const float ends = std::max(nose, tail);
    const float sill = 0.20f - q.y;
    return SmoothMax(SmoothMax(SmoothMax(top, side, 0.20f), ends, 0.20f), sill, 0.10f);
  }

  float CabinTop(vec3 q) const { return cabin_top_.Above(q.x, q.y + 2.0f * Crown(q)); }

  /// The sides lean inwards above the belt, stay within the body below it, and come closer towards
  /// the rear.
  float CabinSide(vec3 q) const {
    const float back = std::max(-q.x - 0.3f, 0.0f);
    const float lean = 0.40f * std::abs(q.y - 0.85f) + 0.11f * back * back;
    return (q.z - (0.80f - lean)) / 1.08f;
  }

  float Cabin(vec3 q) const {
    return std::max(SmoothMax(CabinTop(q), CabinSide(q), 0.16f), 0.60f - q.y);
  }

  /// Bulges over the wheels.
  static float Fenders(vec3 q) {
    const float front = Ellipsoid(q - vec3(kAxle, 0.48f, 0.66f), vec3(0.60f, 0.40f, 0.20f));
    const float rear = Ellipsoid(q - vec3(-kAxle, 0.52f, 0.68f), vec3(0.66f, 0.42f, 0.21f));
    return std::min(front, rear);
  }

  static float Wells(vec3 q) {
    constexpr float kGap = 0.055f;
    const vec2 from_axle(std::abs(q.x) - kAxle, q.y - kWheelRadius);
    return SmoothMax(glm::length(from_axle) - (kWheelRadius + kGap), 0.52f - q.z, 0.06f);
  }

  /// The cabin below the roof, which leaves a wall to the outside and to the wheel wells.
  float Inside(vec3 q, float outer) const {
    constexpr float kWall = 0.045f;
    const float cabin = SmoothMax(CabinTop(q), CabinSide(q), 0.16f);
    const float below_roof = SmoothMax(cabin, outer, 0.06f) + kWall;
    return SmoothMax(SmoothMax(below_roof, kWall - Wells(q), 0.08f), 0.55f - q.y, 0.08f);
  }

  Curve lower_top_ = {{{-2.2f, 0.74f},
                       {-2.0f, 0.84f},
                       {-1.6f, 0.91f},
                       {-1.0f, 0.93f},
                       {0.0f, 0.92f},
                       {0.6f, 0.90f},
                       {1.1f, 0.84f},
                       {1.6f, 0.745f},
                       {2.0f, 0.635f},
                       {2.2f, 0.56f}}};
  Curve cabin_top_ = {{{-2.0f, 0.80f},
                       {-1.6f, 0.985f},
                       {-1.1f, 1.185f},
                       {-0.6f, 1.305f},
                       {-0.15f, 1.335f},
                       {0.22f, 1.275f},
                       {0.6f, 1.10f},
                       {1.0f, 0.865f},
                       {1.3f, 0.68f}}};
  Curve half_width_ = {{{-2.2f, 0.74f},
                        {-1.7f, 0.85f},
                        {-1.2f, 0.875f},
                        {0.0f, 0.845f},
                        {0.8f, 0.85f},
                        {1.3f, 0.865f},
                        {1.8f, 0.81f},
                        {2.2f, 0.66f}}};
};

/// The triangles of `mesh` whose centre satisfies `keeps`, with their vertices.
Mesh Selected(const Mesh& mesh, const std::function<bool(vec3)>& keeps, int material) {
  Mesh out;
  out.material = material;
  constexpr uint32_t kUnused = 0xFFFFFFFFu;
  std::vector<uint32_t> renumbered(mesh.positions.size(), kUnused);
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const uint32_t* corner = &mesh.indices[i];
    const vec3 sum =
        mesh.positions[corner[0]] + mesh.positions[corner[1]] + mesh.positions[corner[2]];
    if (!keeps(sum / 3.0f)) {
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      uint32_t& vertex = renumbered[corner[c]];
      if (vertex == kUnused) {
        vertex = static_cast<uint32_t>(out.positions.size());
        out.positions.push_back(vec3(mesh.positions[corner[c]]));
        out.normals.push_back(vec3(mesh.normals[corner[c]]));
        out.uv[0].push_back(vec2(mesh.uv[0][corner[c]]));
      }
      out.indices.push_back(vertex);
    }
  }
  return out;
}

/// Paint, dark trim where the shell was cut, and panes a little below the surface.
void AddBody(Scene* scene, const CarShape& shape, int trim, int car) {
  const int paint = AddMaterial(scene, "paint", vec3(0.48f, 0.012f, 0.018f), 0.0f, 0.04f);
  const int glass = AddMaterial(scene, "panes", vec3(0.62f, 0.68f, 0.66f), 0.0f, 0.0f);
  scene->materials.back().transmission = 1.0f;
  scene->materials.back().double_sided = true;
  constexpr float kCell = 0.016f;
  constexpr float kTrimDepth = 0.012f;
  constexpr float kPaneDepth = 0.016f;
  constexpr float kPaneOverlap = 0.02f;  // less than the thickness of the shell
  Aabb bounds;
  bounds.min = vec3(-2.25f, 0.14f, -1.0f);
  bounds.max = vec3(2.25f, 1.42f, 1.0f);
  const Mesh shell = MakeIsosurface(
      bounds, kCell, [&](vec3 p) { return shape.Shell(p); }, paint);
  const auto is_trim = [&](vec3 p) { return shape.Outer(p) < -kTrimDepth; };
  AddChild(scene, "body", Selected(shell, std::not_fn(is_trim), paint), vec3(0.0f), car);
  AddChild(scene, "trim", Selected(shell, is_trim, trim), vec3(0.0f), car);
  bounds.min.y = 0.9f;
  const Mesh panes = MakeIsosurface(
      bounds, kCell, [&](vec3 p) { return shape.Outer(p) + kPaneDepth; }, glass);
  AddChild(scene, "panes",
           Selected(
               panes, [&](vec3 p) { return shape.Windows(p) < kPaneOverlap; }, glass),
           vec3(0.0f), car);
}

void AddInterior(Scene* scene, int car) {
  const int leather = AddMaterial(scene, "leather", vec3(0.30f, 0.19f, 0.11f), 0.0f, 0.5f);
  Aabb bounds;
  bounds.min = vec3(-1.0f, 0.5f, -0.7f);
  bounds.max = vec3(1.0f, 1.2f, 0.7f);
  const auto seats = [](vec3 p) {
    const vec3 q(p.x, p.y, std::abs(p.z) - 0.32f);
    const vec3 back = q - vec3(-0.45f, 0.80f, 0.0f);
    // Seat backs lean backwards.
    const vec3 leaning(back.x + 0.25f * back.y, back.y, back.z);
    const float seat = RoundedBox(q - vec3(-0.15f, 0.60f, 0.0f), vec3(0.28f, 0.08f, 0.22f), 0.06f);
    const float chair =
        SmoothMin(seat, RoundedBox(leaning, vec3(0.08f, 0.27f, 0.22f), 0.07f), 0.1f);
    const float head = RoundedBox(q - vec3(-0.53f, 1.10f, 0.0f), vec3(0.05f, 0.07f, 0.11f), 0.045f);
    const float dash = RoundedBox(p - vec3(0.72f, 0.80f, 0.0f), vec3(0.2f, 0.1f, 0.62f), 0.08f);
    return std::min({chair, head, dash});
  };
  AddChild(scene, "seats", MakeIsosurface(bounds, 0.03f, seats, leather), vec3(0.0f), car);
}

/// Five double spokes in a rim about the y axis, its front towards +y.
float RimDistance(vec3 p) {
  constexpr float kSpokes = 5.0f;
  const float from_axis = glm::length(vec2(p.x, p.z));
  const float sector = 2.0f * kPi / kSpokes;
  const float angle = std::atan2(p.z, p.x);
  const float folded = angle - sector * std::round(angle / sector);
  const vec3 q(from_axis * std::cos(folded), p.y, std::abs(from_axis * std::sin(folded)));
  const float dish = 0.045f + 0.25f * from_axis * from_axis;
  const float spread = 0.012f + 0.16f * q.x;
  const float spoke =
      RoundedBox(vec3(q.x - 0.12f, q.y - dish, q.z - spread), vec3(0.12f, 0.018f, 0.011f), 0.010f);
  const float rim =
      RoundedBox(vec3(from_axis - 0.235f, p.y, 0.0f), vec3(0.014f, 0.095f, 0.1f), 0.012f);
  const float hub =
      RoundedBox(vec3(from_axis, p.y - 0.04f, 0.0f), vec3(0.052f, 0.032f, 0.1f), 0.016f);
  return SmoothMin(SmoothMin(spoke, rim, 0.03f), hub, 0.03f);
}

void AddWheels(Scene* scene, int trim, int car) {
  const int rubber = AddMaterial(scene, "rubber", vec3(0.035f), 0.0f, 0.75f);
  const int alloy = AddMaterial(scene, "alloy", vec3(0.80f, 0.80f, 0.82f), 1.0f, 0.18f);
  const std::vector<vec2> tyre = {
      {0.235f, -0.095f}, {0.285f, -0.112f}, {0.312f, -0.108f}, {0.328f, -0.093f}, {0.335f, -0.065f},
      {0.335f, 0.065f},  {0.328f, 0.093f},  {0.312f, 0.108f},  {0.285f, 0.112f},  {0.235f, 0.095f}};
  Aabb bounds;
  bounds.min = vec3(-0.27f, -0.12f, -0.27f);
  bounds.max = vec3(0.27f, 0.12f, 0.27f);
  int first_tyre = -1;
  int first_rim = -1;
  int first_disc = -1;
  for (const float x : {kAxle, -kAxle}) {
    for (const float side : {1.0f, -1.0f}) {
      const std::string name =
          fmt::format("{} {} wheel", x > 0.0f ? "front" : "rear", side > 0.0f ? "right" : "left");
      const int wheel = AddNode(scene, name, vec3(x, kWheelRadius, side * kWheelZ));
      Node& node = scene->nodes.back();
      node.parent = car;
      // In object space the axis of a wheel is y.
      node.local.rotation = RotationAbout(vec3(1.0f, 0.0f, 0.0f), side * 0.5f * kPi);
      const bool first = first_tyre < 0;
      const auto add = [&](const char* part, int* original, const std::function<Mesh()>& make) {
        const int added = first ? AddObject(scene, part, make(), vec3(0.0f))
                                : AddCopy(scene, part, *original, vec3(0.0f));
        scene->nodes[static_cast<size_t>(added)].parent = wheel;
        *original = first ? added : *original;
      };
      add("tyre", &first_tyre, [&] { return MakeLathe(tyre, 128, vec2(1.0f), rubber); });
      add("rim", &first_rim, [&] { return MakeIsosurface(bounds, 0.007f, &RimDistance, alloy); });
      add("brake", &first_disc, [&] { return MakeCylinder(0.222f, 0.012f, 96, vec2(1.0f), trim); });
    }
  }
}

/// Intersection of the car's surface with the ray from `from` towards `to`, which lies inside.
vec3 OnSurface(const CarShape& shape, vec3 from, vec3 to) {
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings; ++i) {
    const vec3 middle = 0.5f * (from + to);
    (shape.Outer(middle) > 0.0f ? from : to) = middle;
  }
  return from;
}

Mesh MakeEllipsoid(vec3 radii, int material) {
  Mesh mesh = MakeSphere(1.0f, 40, 20, material);
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] *= radii;
    mesh.normals[i] = glm::normalize(mesh.normals[i] / radii);
  }
  return mesh;
}

void AddLamps(Scene* scene, const CarShape& shape, int car) {
  const int head = AddMaterial(scene, "headlight", vec3(0.85f, 0.87f, 0.90f), 1.0f, 0.08f);
  scene->materials.back().emission = vec3(0.5f, 0.48f, 0.44f);
  const int tail = AddMaterial(scene, "tail light", vec3(0.35f, 0.01f, 0.01f), 0.0f, 0.05f);
  scene->materials.back().emission = vec3(1.1f, 0.03f, 0.02f);
  for (const float side : {1.0f, -1.0f}) {
    const vec3 front =
        OnSurface(shape, vec3(2.5f, 0.75f, side * 0.60f), vec3(1.2f, 0.55f, side * 0.60f));
    AddChild(scene, "headlight", MakeEllipsoid(vec3(0.10f, 0.075f, 0.11f), head),
             front - vec3(0.055f, 0.012f, 0.0f), car);
    const vec3 rear =
        OnSurface(shape, vec3(-2.5f, 0.72f, side * 0.55f), vec3(-1.2f, 0.70f, side * 0.55f));
    AddChild(scene, "tail light", MakeEllipsoid(vec3(0.07f, 0.035f, 0.19f), tail),
             rear + vec3(0.042f, 0.0f, 0.0f), car);
  }
}

/// A closed curve between an ellipse and a rectangle about the origin, at equal distances.
std::vector<vec2> RoundedOutline(vec2 half, int count) {
  constexpr int kSteps = 4096;
  constexpr float kSquareness = 0.55f;
  const auto squared = [](float c) { return std::copysign(std::pow(std::abs(c), kSquareness), c); };
  std::vector<vec2> fine;
  std::vector<float> length = {0.0f};
  for (int i = 0; i <= kSteps; ++i) {
    const float angle = 2.0f * kPi * static_cast<float>(i) / kSteps;
    fine.push_back(half * vec2(squared(std::cos(angle)), squared(std::sin(angle))));
    if (i > 0) {
      length.push_back(length.back() + glm::length(fine[fine.size() - 1] - fine[fine.size() - 2]));
    }
  }
  std::vector<vec2> points;
  size_t at = 0;
  for (int i = 0; i <= count; ++i) {
    const float wanted = length.back() * static_cast<float>(i) / static_cast<float>(count);
    while (at + 2 < length.size() && length[at + 1] < wanted) {
      ++at;
    }
    points.push_back(
        glm::mix(fine[at], fine[at + 1], (wanted - length[at]) / (length[at + 1] - length[at])));
  }
  return points;
}

/// The gap around a door: a dark cord half sunk into the side.
Mesh MakeDoorLine(const CarShape& shape, float side, int material) {
  constexpr int kPoints = 240;
  std::vector<vec3> points;
  for (const vec2& on_outline : RoundedOutline(vec2(0.58f, 0.325f), kPoints)) {
    const vec3 at(vec2(0.12f, 0.615f) + on_outline, 0.0f);
    points.push_back(
        OnSurface(shape, at + vec3(0.0f, 0.0f, side * 1.2f), at + vec3(0.0f, 0.0f, side * 0.3f)));
  }
  const auto centre = [&](float t) {
    const float at = (t - std::floor(t)) * kPoints;
    const size_t i = std::min(static_cast<size_t>(at), static_cast<size_t>(kPoints - 1));
    return glm::mix(points[i], points[i + 1], at - static_cast<float>(i));
  };
  return MakeTube(centre, 0.0045f, 8, kPoints, material);
}

void AddPlace(Scene* scene, int* plate) {
  const int paving =
      AddTexturedMaterial(scene,
                          MakeTiles("paving", 1024, 6, vec3(0.40f, 0.38f, 0.35f),
                                    vec3(0.33f, 0.32f, 0.31f), vec3(0.16f, 0.15f, 0.14f), 307),
                          0.7f);
  const int bricks = AddTexturedMaterial(
      scene,
      MakeBricks("bricks", 1024, 20, vec3(0.56f, 0.36f, 0.27f), vec3(0.62f, 0.58f, 0.52f), 311),
      0.9f);
  const int concrete = AddTexturedMaterial(
      scene,
      MakeMottled("concrete", 512, 5, vec3(0.56f, 0.55f, 0.53f), vec3(0.44f, 0.43f, 0.42f), 313),
      0.45f);
  constexpr float kHalf = 90.0f;
  AddObject(scene, "ground",
            MakeQuad(vec3(-kHalf, 0.0f, -kHalf), vec3(0.0f, 0.0f, 2.0f * kHalf),
                     vec3(2.0f * kHalf, 0.0f, 0.0f), vec2(2.0f * kHalf / 3.0f), paving),
            vec3(0.0f));
  for (const float side : {-1.0f, 1.0f}) {
    AddObject(scene, "wall", MakeBox(vec3(14.0f, 2.4f, 0.3f), 0.5f, bricks),
              vec3(side * 9.0f, 0.0f, -6.5f));
  }
  constexpr float kPlateHeight = 0.06f;
  *plate =
      AddObject(scene, "plate", MakeCylinder(2.75f, kPlateHeight, 256, vec2(6.0f, 0.1f), concrete),
                vec3(0.0f));
  // The lid's texture coordinates span one texture.
  for (vec2& uv : scene->meshes.back().uv[0]) {
    uv *= 2.0f;
  }
}

}  // namespace

Scene MakeCarScene() {
  Scene scene;
  scene.environment = MakeSky();
  int plate = -1;
  AddPlace(&scene, &plate);
  const CarShape shape;
  const int trim = AddMaterial(&scene, "trim", vec3(0.03f), 0.0f, 0.5f);
  const int car = AddNode(&scene, "car", vec3(0.0f));
  AddBody(&scene, shape, trim, car);
  AddInterior(&scene, car);
  AddWheels(&scene, trim, car);
  AddLamps(&scene, shape, car);
  for (const float side : {1.0f, -1.0f}) {
    AddChild(&scene, "door line", MakeDoorLine(shape, side, trim), vec3(0.0f), car);
  }
  const auto turn = [](float y) {
    return [=](float t) {
      Transform pose;
      pose.translation = vec3(0.0f, y, 0.0f);
      pose.rotation = RotationY(glm::mix(-0.25f, -1.0f, t));
      return pose;
    };
  };
  Animate(&scene, plate, turn(0.0f));
  Animate(&scene, car, turn(0.06f));
  constexpr float kFieldOfView = 0.50f;
  AddAnimatedCamera(&scene, kFieldOfView, [](float t) {
    const vec3 eye = glm::mix(vec3(3.3f, 1.35f, 5.6f), vec3(2.7f, 1.55f, 5.7f), t);
    return LookAt(eye, vec3(0.0f, 0.62f, 0.0f));
  });
  return scene;
}

}  // namespace stillray
