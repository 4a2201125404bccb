// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450

// Renders a ball on a floor, lit by a lamp that every second pixel misses: radiance and guides.
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba16f) writeonly uniform image2D light_image;
layout(set = 0, binding = 1, r32f) writeonly uniform image2D depth_image;
layout(set = 0, binding = 2, rgba16f) writeonly uniform image2D normal_image;
layout(set = 0, binding = 3, rgba16f) writeonly uniform image2D albedo_image;
layout(set = 0, binding = 4, rg16f) writeonly uniform image2D motion_image;
layout(push_constant) uniform Push {
  uint frame;
  uint noisy;
  ivec2 size;  // size of the frame; images may be larger
};

const vec3 kBall = vec3(0.0, 0.0, 4.0);
const vec3 kLamp = vec3(-2.0, 3.0, 2.0);

// Random number in 0..1, a hash of three numbers.
float Random(uvec3 v) {
  uint h = v.x * 0x9e3779b1u ^ v.y * 0x85ebca77u ^ v.z * 0xc2b2ae3du;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 12)) * 0x297a2d39u;
  return float((h ^ (h >> 15)) >> 8) / 16777216.0;
}

// Distance along a ray to a ball of radius 1; negative without a hit.
float HitBall(vec3 origin, vec3 direction) {
  vec3 to = origin - kBall;
  float b = dot(to, direction);
  float d = b * b - dot(to, to) + 1.0;
  return d > 0.0 ? -b - sqrt(d) : -1.0;
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (p.x >= size.x || p.y >= size.y) {
    return;
  }
  vec2 screen = (vec2(p) + 0.5 - 0.5 * vec2(size)) / float(size.y);
  vec3 direction = normalize(vec3(screen.x, -screen.y, 1.0));
  float ball = HitBall(vec3(0.0), direction);
  float ground = direction.y < 0.0 ? -1.0 / direction.y : -1.0;
  bool on_ball = ball > 0.0 && (ground < 0.0 || ball < ground);
  float t = on_ball ? ball : ground;
  vec3 light = vec3(0.0);
  vec3 normal = vec3(0.0);
  vec3 albedo = vec3(0.0);
  float depth = uintBitsToFloat(0x7f800000u);  // the sky
  if (t > 0.0) {
    vec3 at = t * direction;
    depth = at.z;
    normal = on_ball ? normalize(at - kBall) : vec3(0.0, 1.0, 0.0);
    bool dark = (int(floor(at.x * 2.0)) + int(floor(at.z * 2.0))) % 2 == 0;
    albedo = on_ball ? vec3(0.8, 0.3, 0.2) : vec3(dark ? 0.2 : 0.7);
    vec3 to_lamp = kLamp - at;
    float distance2 = dot(to_lamp, to_lamp);
    vec3 towards = to_lamp / sqrt(distance2);
    bool shadow = HitBall(at + 0.001 * normal, towards) > 0.0;
    float shine = shadow ? 0.05 : 0.05 + 6.0 * max(dot(normal, towards), 0.0) / distance2;
    bool hit = Random(uvec3(p, frame)) < 0.5;
    light = albedo * shine * (noisy == 0u ? 1.0 : (hit ? 2.0 : 0.0));
  }
  imageStore(light_image, p, vec4(light, 1.0));
  imageStore(depth_image, p, vec4(depth));
  imageStore(normal_image, p, vec4(normal, 0.0));
  imageStore(albedo_image, p, vec4(albedo, 1.0));
  imageStore(motion_image, p, vec4(0.0));
}
