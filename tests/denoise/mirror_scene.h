// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A scene of formulas, traced with one sample per pixel through the pixels' centres: a chequered
/// floor, a chrome ball, a ball of rough gold and a diffuse one under a round lamp and a sky, seen
/// by a camera on an orbit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/parallel.h"
#include "denoise/test_frames.h"
#include "stillray/vec.h"

namespace stillray::test {

class MirrorScene {
 public:
  static constexpr uint32_t kFloor = 1;
  static constexpr uint32_t kChrome = 2;
  static constexpr uint32_t kGold = 3;
  static constexpr uint32_t kClay = 4;

  /// \param degrees  by which the camera turns from frame to frame
  MirrorScene(int width, int height, float degrees, float lamp_radius = 0.5f)
      : width_(width), height_(height), degrees_(degrees), lamp_radius_(lamp_radius) {}

  /// A frame as a renderer hands it over. \param samples  per pixel; more than one: the mean alone,
  /// for reference
  Frame Trace(int64_t index, int samples = 1) const {
    Frame f = MakeWall(width_, height_, index);
    const Camera now = CameraOf(index);
    const Camera before = CameraOf(index - 1);
    ParallelRows(height_, 8, [&](int y0, int y1) {
      for (int y = y0; y < y1; ++y) {
        for (int x = 0; x < width_; ++x) {
          TracePixel(now, before, index, samples, x, y, &f);
        }
      }
    });
    return f;
  }

  float chrome_roughness = 0.0f;
  float gold_roughness = 0.35f;
  float sky_one_of = 1;  ///< shaded points of which one looks at the sky: the noise of its light

 private:
  static constexpr float kPi = 3.14159265f;

  struct Camera {
    vec3 eye, right, up, forward;
    float scale;  ///< pixels per unit of slope
  };
  struct Hit {
    float t = std::numeric_limits<float>::infinity();
    uint32_t id = 0;
    vec3 point{0.0f}, normal{0.0f};
  };
  struct Ball {
    vec3 centre;
    uint32_t id;
  };

  /// A stream of random numbers: hashes of pixel, frame, sample and count.
  struct Stream {
    uint32_t a, b;
    uint32_t n = 0;
    float Next() { return Random(a, b, n++); }
  };

  std::array<Ball, 3> balls() const {
    return {{{{-1.2f, 1.0f, 0.0f}, kChrome},
             {{1.2f, 1.0f, 0.2f}, kGold},
             {{0.2f, 1.0f, -2.2f}, kClay}}};
  }

  Camera CameraOf(int64_t index) const {
    const float angle = (20.0f + degrees_ * static_cast<float>(index)) * kPi / 180.0f;
    Camera c;
    c.eye = vec3(6.0f * std::sin(angle), 2.4f, 6.0f * std::cos(angle));
    c.forward = normalize(vec3(0.0f, 0.8f, 0.0f) - c.eye);
    c.right = normalize(cross(c.forward, vec3(0, 1, 0)));
    c.up = cross(c.right, c.forward);
    c.scale = 1.3f * static_cast<float>(height_);
    return c;
  }

  Hit Intersect(vec3 origin, vec3 direction) const {
    Hit hit;
    if (direction.y < 0) {
      const float t = -origin.y / direction.y;
      const vec3 p = origin + t * direction;
      if (t > 1e-4f && std::abs(p.x) < 8 && std::abs(p.z) < 8) {
        hit = {t, kFloor, p, vec3(0, 1, 0)};
      }
    }
    for (const Ball& ball : balls()) {
      const vec3 o = origin - ball.centre;
      const float b = dot(o, direction);
      const float root = b * b - dot(o, o) + 1.0f;
      if (root <= 0) {
        continue;
      }
      const float t = -b - std::sqrt(root);
      if (t > 1e-4f && t < hit.t) {
        const vec3 p = origin + t * direction;
        hit = {t, ball.id, p, p - ball.centre};
      }
    }
    return hit;
  }

  static vec3 Albedo(uint32_t id, vec3 p) {
    if (id == kClay) {
      return {0.25f, 0.4f, 0.7f};
    }
    const bool light =
        (static_cast<int>(std::floor(p.x * 1.5f)) + static_cast<int>(std::floor(p.z * 1.5f))) % 2 ==
        0;
    return light ? vec3(0.75f, 0.7f, 0.6f) : vec3(0.12f, 0.12f, 0.15f);
  }
  static vec3 SpecularAlbedo(uint32_t id) {
    return id == kChrome ? vec3(0.9f) : id == kGold ? vec3(0.95f, 0.7f, 0.3f) : vec3(0.0f);
  }
  static vec3 Sky(vec3 d) {
    const float t = 0.5f + 0.5f * d.y;
    return (1.0f - t) * vec3(0.6f, 0.65f, 0.7f) + t * vec3(0.25f, 0.4f, 0.8f);
  }
  static vec3 Frame3(vec3 n, vec3 local) {
    const vec3 t =
        normalize(std::abs(n.x) > 0.5f ? cross(n, vec3(0, 1, 0)) : cross(n, vec3(1, 0, 0)));
    return local.x * t + local.y * cross(n, t) + local.z * n;
  }

  /// Irradiance over pi from a point on the lamp, and from the sky along a cosine-weighted ray.
  void Shade(const Hit& hit, Stream* s, float* lamp, vec3* sky) const {
    const float r = lamp_radius_ * std::sqrt(s->Next());
    const float phi = 2 * kPi * s->Next();
    const vec3 to = vec3(3.0f + r * std::cos(phi), 5.0f, 2.0f + r * std::sin(phi)) - hit.point;
    const float distance2 = dot(to, to);
    const vec3 d = to / std::sqrt(distance2);
    const float cosine = dot(hit.normal, d);
    const bool visible = cosine > 0 && Intersect(hit.point + 1e-3f * hit.normal, d).id == 0;
    *lamp = visible ? 45.0f * cosine * d.y / distance2 : 0.0f;
    const float u = s->Next();
    const float angle = 2 * kPi * s->Next();
    const float sine = std::sqrt(u);
    const vec3 up =
        Frame3(hit.normal, {sine * std::cos(angle), sine * std::sin(angle), std::sqrt(1 - u)});
    const bool open = Intersect(hit.point + 1e-3f * hit.normal, up).id == 0;
    *sky = open && s->Next() * sky_one_of < 1 ? 0.5f * sky_one_of * Sky(up) : vec3(0.0f);
  }

  /// Radiance along a reflected ray, after two further reflections at most.
  vec3 Radiance(vec3 origin, vec3 direction, Stream* s, int depth) const {
    const Hit hit = Intersect(origin, direction);
    if (hit.id == 0) {
      return Sky(direction);
    }
    if (hit.id == kFloor || hit.id == kClay) {
      float lamp = 0;
      vec3 sky;
      Shade(hit, s, &lamp, &sky);
      return Albedo(hit.id, hit.point) * (vec3(lamp) + sky);
    }
    return depth == 0 ? vec3(0.0f)
                      : SpecularAlbedo(hit.id) * Reflected(hit, direction, s, depth - 1);
  }

  vec3 Reflected(const Hit& hit, vec3 direction, Stream* s, int depth) const {
    const float roughness = hit.id == kGold ? gold_roughness : chrome_roughness;
    vec3 n = hit.normal;
    if (roughness > 0) {
      const float u = s->Next();
      const float phi = 2 * kPi * s->Next();
      const float alpha = roughness * roughness;
      const float cosine = std::sqrt((1 - u) / (1 + (alpha * alpha - 1) * u));
      const float sine = std::sqrt(1 - cosine * cosine);
      n = Frame3(n, {sine * std::cos(phi), sine * std::sin(phi), cosine});
    }
    vec3 r = direction - 2.0f * dot(direction, n) * n;
    if (dot(r, hit.normal) <= 0) {
      r = direction - 2.0f * dot(direction, hit.normal) * hit.normal;
    }
    return Radiance(hit.point + 1e-3f * hit.normal, r, s, depth);
  }

  void TracePixel(const Camera& now, const Camera& before, int64_t index, int samples, int x, int y,
                  Frame* f) const {
    const float w = static_cast<float>(width_);
    const float h = static_cast<float>(height_);
    const float sx = (static_cast<float>(x) + 0.5f - 0.5f * w) / now.scale;
    const float sy = (0.5f * h - static_cast<float>(y) - 0.5f) / now.scale;
    const vec3 d = normalize(now.forward + sx * now.right + sy * now.up);
    const Hit hit = Intersect(now.eye, d);
    Guides& g = f->guides;
    g.id(x, y) = hit.id;
    g.roughness(x, y) = hit.id == kChrome ? chrome_roughness
                        : hit.id == kGold ? gold_roughness
                                          : 1.0f;
    const vec3 albedo =
        hit.id == kFloor || hit.id == kClay ? Albedo(hit.id, hit.point) : vec3(0.0f);
    const vec3 specular = SpecularAlbedo(hit.id);
    for (int c = 0; c < 3; ++c) {
      g.normal[c](x, y) = hit.normal[c];
      g.albedo[c](x, y) = albedo[c];
      g.specular_albedo[c](x, y) = specular[c];
      f->background[c](x, y) = hit.id == 0 ? Sky(d)[c] : 0.0f;
    }
    g.depth(x, y) = hit.t * dot(d, now.forward);
    const vec3 from = hit.id == 0 ? d : hit.point - before.eye;
    const float z = dot(from, before.forward);
    g.motion[0](x, y) =
        0.5f * w + before.scale * dot(from, before.right) / z - static_cast<float>(x) - 0.5f;
    g.motion[1](x, y) =
        0.5f * h - before.scale * dot(from, before.up) / z - static_cast<float>(y) - 0.5f;
    if (hit.id == 0) {
      return;
    }
    vec3 direct(0.0f), indirect(0.0f), reflected(0.0f);
    for (int i = 0; i < samples; ++i) {
      Stream s = {static_cast<uint32_t>(y * width_ + x), static_cast<uint32_t>(index * 100003 + i)};
      if (hit.id == kFloor || hit.id == kClay) {
        float lamp = 0;
        vec3 sky;
        Shade(hit, &s, &lamp, &sky);
        direct += albedo * lamp;
        indirect += albedo * sky;
      } else {
        reflected += specular * Reflected(hit, d, &s, 2);
      }
    }
    const float scale = 1.0f / static_cast<float>(samples);
    for (int c = 0; c < 3; ++c) {
      Light(f, SignalKind::kDirectDiffuse)[c](x, y) = scale * direct[c];
      Light(f, SignalKind::kIndirectDiffuse)[c](x, y) = scale * indirect[c];
      Light(f, SignalKind::kIndirectSpecular)[c](x, y) = scale * reflected[c];
    }
  }

  int width_;
  int height_;
  float degrees_;
  float lamp_radius_;
};

/// PSNR in dB of x / (1 + x) over the pixels with this id.
inline double RegionPsnr(const Image3& a, const Image3& b, const Plane<uint32_t>& ids,
                         uint32_t id) {
  double sum = 0;
  int64_t count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      if (ids(x, y) != id) {
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        const double p = static_cast<double>(a[c](x, y));
        const double q = static_cast<double>(b[c](x, y));
        const double d = p / (1 + p) - q / (1 + q);
        sum += d * d;
        ++count;
      }
    }
  }
  return -10 * std::log10(sum / static_cast<double>(std::max<int64_t>(count, 1)));
}

}  // namespace stillray::test
