// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "mirror_room.h"

#include <cmath>
#include <limits>

namespace stillray {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr dvec3 kMirrorColour(0.9, 0.8, 0.7);

/// Columns: right, up, forward.
glm::dmat3 AxesOf(const RoomCamera& camera) {
  const double c = std::cos(camera.pan);
  const double s = std::sin(camera.pan);
  const dvec3 right(c, 0, -s);
  const dvec3 level(s, 0, c);
  const dvec3 up(0, 1, 0);
  const dvec3 forward = std::cos(camera.tilt) * level + std::sin(camera.tilt) * up;
  return {right, std::cos(camera.tilt) * up - std::sin(camera.tilt) * level, forward};
}

struct Hit {
  double t = kInfinity;
  dvec3 point{0.0};
  dvec3 normal{0.0};  ///< towards the ray
  dvec3 colour{1.0};
  dvec3 velocity{0.0};
  RoomSurface surface = RoomSurface::kMatt;
  uint32_t id = 0;
  const RoomBall* ball = nullptr;  ///< that is hit

  bool IsSky() const { return !(t < kInfinity); }
};

constexpr double kNear = 1e-6;

dvec3 Texture(dvec3 colour, double s, double t) {
  const bool dark = (static_cast<int>(std::floor(8 * s)) + static_cast<int>(8 * t)) % 2 != 0;
  return (dark ? 0.4 : 1.0) * colour;
}

void HitRectangle(const RoomRectangle& r, uint32_t id, dvec3 origin, dvec3 direction, Hit* hit) {
  const dvec3 normal = glm::normalize(glm::cross(r.a, r.b));
  const double t = glm::dot(r.corner - origin, normal) / glm::dot(direction, normal);
  const dvec3 point = origin + t * direction;
  const double s = glm::dot(point - r.corner, r.a) / glm::dot(r.a, r.a);
  const double u = glm::dot(point - r.corner, r.b) / glm::dot(r.b, r.b);
  if (!(t > kNear && t < hit->t && s >= 0 && s <= 1 && u >= 0 && u <= 1)) {
    return;
  }
  const dvec3 colour = r.surface == RoomSurface::kMatt ? Texture(r.colour, s, u) : r.colour;
  const dvec3 facing = glm::dot(normal, direction) < 0 ? normal : -normal;
  *hit = {t, point, facing, colour, r.velocity, r.surface, id, nullptr};
}

void HitBall(const RoomBall& ball, uint32_t id, dvec3 origin, dvec3 direction, Hit* hit) {
  const dvec3 to = origin - ball.centre;
  const double a = glm::dot(direction, direction);
  const double b = glm::dot(to, direction);
  const double root = b * b - a * (glm::dot(to, to) - ball.radius * ball.radius);
  const double t = (-b - std::sqrt(std::max(root, 0.0))) / a;
  if (root > 0 && t > kNear && t < hit->t) {
    const dvec3 point = origin + t * direction;
    const dvec3 normal = glm::normalize(point - ball.centre);
    *hit = {t, point, normal, kMirrorColour, dvec3(0.0), ball.surface, id, &ball};
  }
}

Hit FirstHit(const Room& room, dvec3 origin, dvec3 direction) {
  Hit hit;
  uint32_t id = 0;
  for (const RoomRectangle& rectangle : room.rectangles) {
    HitRectangle(rectangle, ++id, origin, direction, &hit);
  }
  for (const RoomBall& ball : room.balls) {
    HitBall(ball, ++id, origin, direction, &hit);
  }
  return hit;
}

/// What a ray meets behind the first surface.
struct Behind {
  Hit hit;
  double length = 0;  ///< of the whole path
  dvec3 image{0.0};   ///< where the eye sees it
  dvec3 before{0.0};  ///< where the image was one frame ago
  dvec3 colour{1.0};  ///< of the mirror
};

dvec3 ReflectedAt(const Hit& mirror, dvec3 point) {
  return point - 2 * glm::dot(point - mirror.point, mirror.normal) * mirror.normal;
}

Behind Follow(const Room& room, const Hit& first, dvec3 origin, dvec3 direction) {
  Behind behind;
  behind.hit = first;
  behind.length = glm::length(first.point - origin);
  behind.image = first.point;
  behind.before = first.point + first.velocity * -1.0;
  const bool mirror = first.surface == RoomSurface::kMirror || first.surface == RoomSurface::kRough;
  if (first.surface == RoomSurface::kMatt) {
    return behind;
  }
  const dvec3 out = mirror ? glm::reflect(direction, first.normal) : direction;
  behind.hit = FirstHit(room, first.point + 1e-6 * out, out);
  behind.colour = first.colour;
  if (behind.hit.IsSky()) {
    behind.length = 0;
    behind.image = behind.before = origin + 1e9 * direction;
    return behind;
  }
  const dvec3 before = behind.hit.point - behind.hit.velocity;
  behind.length += glm::length(behind.hit.point - first.point);
  behind.image = mirror ? ReflectedAt(first, behind.hit.point) : behind.hit.point;
  behind.before = mirror ? ReflectedAt(first, before) : before;
  return behind;
}

/// The point of a ball that shows a point to an eye (Alhazen's problem), by bisection: between the
/// directions to both, its normal turns from the one to the other.
dvec3 PointOfBall(const RoomBall& ball, dvec3 eye, dvec3 shown) {
  const dvec3 to_eye = glm::normalize(eye - ball.centre);
  const dvec3 to_shown = glm::normalize(shown - ball.centre);
  double low = 0;
  double high = 1;
  dvec3 point = eye;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const dvec3 normal = glm::normalize((1 - middle) * to_eye + middle * to_shown);
    point = ball.centre + ball.radius * normal;
    const double eye_cosine = glm::dot(normal, glm::normalize(eye - point));
    const double shown_cosine = glm::dot(normal, glm::normalize(shown - point));
    (eye_cosine > shown_cosine ? low : high) = middle;
  }
  return point;
}

/// Sets pixels of a picture, rounded.
class Painter {
 public:
  Painter(const RoomOptions& options, RoomPicture* picture)
      : options_(options), picture_(*picture) {}

  void Paint(const Room& room, const RoomCamera& now, const RoomCamera& before, int x, int y);

 private:
  float Rounded(double value) const {
    return options_.halves ? RoundToHalf(value) : static_cast<float>(value);
  }
  void Set(dvec3 value, int x, int y, Image3* image) const {
    for (int c = 0; c < 3; ++c) {
      (*image)[c](x, y) = Rounded(value[c]);
    }
  }
  void SetFirst(const Hit& hit, const RoomCamera& now, dvec2 motion, int x, int y);
  void SetSeen(const Behind& behind, const RoomCamera& now, dvec2 p, int x, int y);
  void SetRandom(int x, int y);
  void SetExpected(const Behind& behind, double depth, dvec2 motion, int x, int y,
                   VirtualGuides* guides);
  double Random() { return std::uniform_real_distribution<double>()(random_); }

  const RoomOptions& options_;
  RoomPicture& picture_;
  std::mt19937 random_{1};
};

void Painter::SetFirst(const Hit& hit, const RoomCamera& now, dvec2 motion, int x, int y) {
  Guides& g = picture_.frame.guides;
  g.depth(x, y) = Rounded(hit.IsSky() ? kInfinity : now.InCamera(hit.point).z);
  if (hit.IsSky()) {
    return;
  }
  const vec3 stored(Rounded(hit.normal.x), Rounded(hit.normal.y), Rounded(hit.normal.z));
  const vec3 normal = glm::normalize(stored);  // as the importer
  for (int c = 0; c < 3; ++c) {
    g.normal[c](x, y) = normal[c];
  }
  const bool matt = hit.surface == RoomSurface::kMatt;
  const bool pane = hit.surface == RoomSurface::kPane;
  Set(matt ? hit.colour : dvec3(0.0), x, y, &g.albedo);
  Set(matt ? dvec3(0.0) : pane ? dvec3(0.04) : hit.colour, x, y, &g.specular_albedo);
  Set(pane ? hit.colour : dvec3(0.0), x, y, &g.transmission_albedo);
  g.motion[0](x, y) = Rounded(motion.x);
  g.motion[1](x, y) = Rounded(motion.y);
  g.id(x, y) = hit.id;
  picture_.what(x, y) = static_cast<uint32_t>(hit.surface) + 1;
}

void Painter::SetSeen(const Behind& behind, const RoomCamera& now, dvec2 p, int x, int y) {
  if (behind.hit.IsSky()) {
    return;
  }
  const double secant = glm::length(now.Ray(p));
  picture_.seen.depth(x, y) = Rounded(behind.length - options_.clip_start * secant);
  // The room's axes and Cycles' of the camera differ in handedness.
  const dvec3 flipped(-1, 1, 1);
  Set(flipped * now.InCamera(now.position + behind.hit.normal), x, y, &picture_.seen.normal);
  const bool other = behind.hit.surface == RoomSurface::kMatt;
  Set(other ? behind.colour * behind.hit.colour : behind.colour, x, y, &picture_.seen.albedo);
}

void Painter::SetRandom(int x, int y) {
  const dvec3 direction(Random() - 0.5, Random() - 0.5, Random() - 0.5);
  picture_.seen.depth(x, y) = Rounded(3 + 20 * Random());
  Set(glm::normalize(direction), x, y, &picture_.seen.normal);
  Set(dvec3(Random()), x, y, &picture_.seen.albedo);
}

void Painter::SetExpected(const Behind& behind, double depth, dvec2 motion, int x, int y,
                          VirtualGuides* guides) {
  VirtualGuides& g = *guides;
  const bool sky = behind.hit.IsSky();
  g.depth(x, y) = static_cast<float>(sky ? kInfinity : depth);
  g.motion[0](x, y) = static_cast<float>(motion.x);
  g.motion[1](x, y) = static_cast<float>(motion.y);
  for (int c = 0; c < 3 && !sky; ++c) {
    g.normal[c](x, y) = static_cast<float>(behind.hit.normal[c]);
    g.albedo[c](x, y) = static_cast<float>(behind.hit.colour[c]);
  }
}

void Painter::Paint(const Room& room, const RoomCamera& now, const RoomCamera& before, int x,
                    int y) {
  const int width = options_.width;
  const dvec2 p = PointOfPixel(width, options_.height, x, y);
  const dvec3 direction = now.Ray(p);
  const Hit first = FirstHit(room, now.position, direction);
  const auto motion_of = [&](dvec3 was) { return (before.Project(was) - p) * (0.5 * width); };
  SetFirst(first, now, motion_of(first.point - first.velocity), x, y);
  if (first.IsSky()) {
    return;
  }
  const Behind behind = Follow(room, first, now.position, direction);
  const bool shows = first.surface == RoomSurface::kMirror || first.surface == RoomSurface::kPane;
  const bool rough = first.surface == RoomSurface::kRough;
  if ((rough && Random() < 0.5) || (shows && Random() < options_.outliers)) {
    SetRandom(x, y);
  } else {
    SetSeen(behind, now, p, x, y);
  }
  if (shows && first.ball == nullptr) {
    SetExpected(behind, now.InCamera(behind.image).z, motion_of(behind.before), x, y,
                &picture_.expected);
  } else if (shows) {
    const dvec3 shown = behind.hit.IsSky()
                            ? first.point + 1e9 * glm::reflect(direction, first.normal)
                            : behind.hit.point;
    SetExpected(behind, behind.length / glm::length(now.Ray(p)),
                motion_of(PointOfBall(*first.ball, before.position, shown)), x, y,
                &picture_.curved);
  }
}

RoomPicture BlackPicture(int w, int h) {
  RoomPicture picture;
  picture.frame.width = w;
  picture.frame.height = h;
  Guides& g = picture.frame.guides;
  g.depth = Image1(w, h);
  g.normal = g.albedo = g.specular_albedo = g.transmission_albedo = Image3(w, h);
  g.motion = Image2(w, h);
  g.id = picture.what = Plane<uint32_t>(w, h);
  picture.seen = {Image1(w, h), Image3(w, h), Image3(w, h)};
  picture.expected = {Image1(w, h), Image3(w, h), Image3(w, h), Image2(w, h), {}};
  picture.curved = picture.expected;
  return picture;
}

RoomRectangle Board(dvec3 corner, dvec3 a, dvec3 b, dvec3 colour) {
  return {corner, a, b, RoomSurface::kMatt, colour, dvec3(0.0)};
}

}  // namespace

dvec3 RoomCamera::Ray(dvec2 p) const {
  const dvec2 offset = (p - shift) * tangent;
  return AxesOf(*this) * dvec3(offset.x, -offset.y, 1);
}

dvec3 RoomCamera::InCamera(dvec3 point) const {
  return glm::transpose(AxesOf(*this)) * (point - position);
}

dvec2 RoomCamera::Project(dvec3 point) const {
  const dvec3 v = InCamera(point);
  return dvec2(v.x, -v.y) / (v.z * tangent) + shift;
}

namespace {

/// \param forward  1 or -1: the sign of z in front of the camera
/// \param place    from RoomCamera::Project to device coordinates, of x and of y
CameraMatrices Matrices(const RoomCamera& camera, double forward, const dvec2 (&place)[2],
                        bool is_standard) {
  constexpr double kNear = 0.1;
  glm::dmat4 to_camera(1.0);
  glm::dmat4 to_ndc(1.0);
  for (int i = 0; i < 4; ++i) {
    // The image of a unit vector, or of the origin, in the camera's axes.
    dvec3 point(0.0);
    if (i < 3) {
      point[i] = 1;
    }
    const dvec3 v = camera.InCamera(point) - (i < 3 ? camera.InCamera(dvec3(0.0)) : dvec3(0.0));
    const dvec2 p = dvec2(v.x, -v.y) / camera.tangent + camera.shift * v.z;
    const double one = i < 3 ? 0 : 1;
    to_camera[i] = {v.x, v.y, forward * v.z, one};
    to_ndc[i] = {place[0].x * p.x + place[0].y * v.z, place[1].x * p.y + place[1].y * v.z,
                 v.z - kNear * one, v.z};
  }
  CameraMatrices result;
  result.is_standard = is_standard;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      result.world_to_camera[static_cast<size_t>(4 * i + j)] = to_camera[i][j];
      result.world_to_ndc[static_cast<size_t>(4 * i + j)] = to_ndc[i][j];
    }
  }
  return result;
}

}  // namespace

CameraMatrices MatricesOf(const RoomCamera& camera, int width, int height) {
  const dvec2 place[2] = {{0.5, 0.5}, {0.5 * width / height, 0.5}};
  return Matrices(camera, 1, place, true);
}

CameraMatrices MatricesOfOpenGl(const RoomCamera& camera, int width, int height) {
  const dvec2 place[2] = {{1, 0}, {-1.0 * width / height, 0}};
  return Matrices(camera, -1, place, false);
}

Room EmptyRoom() {
  Room room;
  room.rectangles = {
      Board({-5, 0, -6}, {10, 0, 0}, {0, 0, 12}, {0.8, 0.7, 0.6}),  // floor
      Board({-5, 0, 6}, {10, 0, 0}, {0, 3, 0}, {0.5, 0.6, 0.9}),    // wall in front
      Board({-5, 0, -6}, {10, 0, 0}, {0, 3, 0}, {0.9, 0.5, 0.5}),   // behind the camera
      Board({-5, 0, -6}, {0, 0, 12}, {0, 3, 0}, {0.6, 0.9, 0.5}),   // left
      Board({5, 0, -6}, {0, 0, 12}, {0, 3, 0}, {0.9, 0.9, 0.5}),    // right
      Board({2, 0, 2}, {1, 0, 0.4}, {0, 2, 0}, {0.7, 0.7, 0.7}),
      Board({-2.4, 0, 0}, {0.6, 0, 0}, {0, 1, 0}, {0.3, 0.8, 0.8}),
  };
  return room;
}

Room RoomWithMirror() {
  Room room = EmptyRoom();
  room.rectangles.push_back(
      {{-3, 0.3, 5}, {4, 0, -0.6}, {0, 2.6, 0}, RoomSurface::kMirror, kMirrorColour, dvec3(0.0)});
  return room;
}

RoomRectangle MovingBoard() {
  RoomRectangle board = Board({0.2, 0.6, -2}, {1, 0, 0.4}, {0, 1.1, 0.2}, {0.6, 0.4, 0.2});
  board.velocity = {0.05, -0.03, 0.04};
  return board;
}

RoomPicture Trace(const Room& room, const RoomCamera& now, const RoomCamera& before,
                  const RoomOptions& options) {
  RoomPicture picture = BlackPicture(options.width, options.height);
  Painter painter(options, &picture);
  for (int y = 0; y < options.height; ++y) {
    for (int x = 0; x < options.width; ++x) {
      painter.Paint(room, now, before, x, y);
    }
  }
  return picture;
}

float RoundToHalf(double value) {
  if (!std::isfinite(value) || value == 0) {
    return static_cast<float>(value);
  }
  constexpr int kBits = 11;
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return static_cast<float>(
      std::ldexp(std::nearbyint(std::ldexp(mantissa, kBits)), exponent - kBits));
}

glm::dvec2 PointOfPixel(int width, int height, int x, int y) {
  return {(x + 0.5) * 2 / width - 1, (2 * (y + 0.5) - height) / width};
}

}  // namespace stillray
