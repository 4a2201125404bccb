// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Common to all compute shaders of the denoiser: formats, inputs, small functions.
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_samplerless_texture_functions : require

#include "core/shared.h"
#include "core/colour_shared.h"
#include "core/negative_limit_shared.h"
#include "denoise/octahedral_shared.h"

// Formats of images between stages. With STILLRAY_HALF radiance takes 8 bytes per pixel; without,
// it has the precision of the CPU.
#ifdef STILLRAY_HALF
#define LIGHT_FORMAT rgba16f
#define SCALAR_FORMAT r16f
#define FRACTION_FORMAT r16
#define DETAIL_FORMAT rg32ui
const float kMostLight = 65504.0f;
const float kMostLength = 2048.0f;  // halves cannot represent 2049
#else
#define LIGHT_FORMAT rgba32f
#define SCALAR_FORMAT r32f
#define FRACTION_FORMAT r32f
#define DETAIL_FORMAT rgba32ui
const float kMostLight = 3e38f;
const float kMostLength = 16777216.0f;
#endif

// Normals of surfaces: octahedral in 32 bits, or three floats. Shaders that read surfaces support
// both, selected by the constant. Images that are written have a declared format: shaders that
// write surfaces are compiled a second time, with STILLRAY_OTHER_NORMALS, for the format that is
// not the precision's default.
#if defined(STILLRAY_HALF) != defined(STILLRAY_OTHER_NORMALS)
#define SURFACE_FORMAT rg32ui
layout(constant_id = 0) const bool kOctahedralNormals = true;  // of surfaces
#else
#define SURFACE_FORMAT rgba32ui
layout(constant_id = 0) const bool kOctahedralNormals = false;  // of surfaces
#endif

layout(constant_id = 1) const int kKnownSignals = 1;  // 0: not known when the pipeline is made

#ifndef LOCAL_SIZE_X
#define LOCAL_SIZE_X 16
#define LOCAL_SIZE_Y 8
#endif
layout(local_size_x = LOCAL_SIZE_X, local_size_y = LOCAL_SIZE_Y) in;

// Inputs of the frame: images of the caller, in any format that converts to float.
layout(set = 0, binding = 0) uniform texture2D light_0;
layout(set = 0, binding = 1) uniform texture2D light_1;
layout(set = 0, binding = 2) uniform texture2D light_2;
layout(set = 0, binding = 3) uniform texture2D light_3;
layout(set = 0, binding = 4) uniform texture2D light_4;
layout(set = 0, binding = 5) uniform texture2D light_5;
layout(set = 0, binding = 6) uniform texture2D second_moment_0;
layout(set = 0, binding = 7) uniform texture2D second_moment_1;
layout(set = 0, binding = 8) uniform texture2D second_moment_2;
layout(set = 0, binding = 9) uniform texture2D second_moment_3;
layout(set = 0, binding = 10) uniform texture2D second_moment_4;
layout(set = 0, binding = 11) uniform texture2D second_moment_5;
layout(set = 0, binding = 12) uniform texture2D depth_image;
layout(set = 0, binding = 13) uniform texture2D normal_image;
layout(set = 0, binding = 14) uniform utexture2D id_image;
layout(set = 0, binding = 15) uniform texture2D motion_image;
layout(set = 0, binding = 16) uniform texture2D albedo_image;
layout(set = 0, binding = 17) uniform texture2D specular_albedo_image;
layout(set = 0, binding = 18) uniform texture2D transmission_albedo_image;
layout(set = 0, binding = 19) uniform texture2D emission_image;
layout(set = 0, binding = 20) uniform texture2D background_image;
layout(set = 0, binding = 21) uniform texture2D samples_image;
layout(set = 0, binding = 22) uniform texture2D roughness_image;
layout(set = 0, binding = 23) uniform texture2D confidence_image;
layout(set = 0, binding = 24) uniform texture2D previous_normal_image;
layout(set = 0, binding = 25, rgba32f) writeonly uniform image2D colour_float;
layout(set = 0, binding = 26, rgba16f) writeonly uniform image2D colour_half;
layout(set = 0, binding = 27, rgba8) writeonly uniform image2D display_image;
#include "denoise/vulkan/frame_shared.h"
// Work of one frame. light_bins and the counts of blocks are zero between frames.
layout(set = 0, binding = 30, std430) buffer Partials {
  uint light_bins[STILLRAY_LIGHT_BINS];  // see negative_limit.h
  float negative_limit;                  // values in (-negative_limit, 0) become zero
  float unused[3];
  uint changed_blocks[4];  // per signal: see measure_change.comp
  uint known_blocks[4];
  vec4 partials[];  // two per workgroup
};

int SignalCount() {
  return kKnownSignals != 0 ? kKnownSignals : signals;
}
ivec2 Size() {
  return ivec2(width, height);
}
bool Inside(ivec2 p) {
  return p.x >= 0 && p.y >= 0 && p.x < width && p.y < height;
}
ivec2 ClampToPicture(ivec2 p) {
  return clamp(p, ivec2(0), Size() - 1);
}

// Tests the bits, since compilers may assume that there are no infinities.
bool IsFinite(float x) {
  return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u;
}
bool IsFinite(vec3 v) {
  return IsFinite(v.x) && IsFinite(v.y) && IsFinite(v.z);
}
bool IsNaN(float x) {
  return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}

float GivenSamples(ivec2 p) {
  return has_samples != 0 ? texelFetch(samples_image, p, 0).x : 1.0f;
}

// The confidence in the last frame's radiance: UsedConfidence.
float Confidence(ivec2 p) {
  float given = has_confidence != 0 ? texelFetch(confidence_image, p, 0).x : 1.0f;
  return UsedConfidence(given, IsNaN(given));
}

// A surface: inverse depth (0: none) and unit normal. Its detail: gradient and id.
struct Surface {
  float inverse_depth;
  vec3 normal;
};
struct Detail {
  vec2 gradient;
  uint id;
};

// The normal of a surface; without a surface any finite vector.
vec3 UnpackNormal(uvec4 packed_surface) {
  return kOctahedralNormals ? OctahedralDecode(unpackSnorm2x16(packed_surface.y))
                            : uintBitsToFloat(packed_surface.yzw);
}
Surface UnpackSurface(uvec4 packed_surface) {
  Surface s;
  s.inverse_depth = uintBitsToFloat(packed_surface.x);
  vec3 normal = UnpackNormal(packed_surface);  // computed unconditionally, to avoid a branch
  s.normal = s.inverse_depth > 0.0f ? normal : vec3(0.0f);
  return s;
}
uvec4 PackSurface(Surface s) {
  uint i = floatBitsToUint(s.inverse_depth);
  return kOctahedralNormals ? uvec4(i, packSnorm2x16(OctahedralEncode(s.normal)), 0u, 0u)
                            : uvec4(i, floatBitsToUint(s.normal));
}

// The slope relative to the inverse depth, which is independent of the unit of length, in 20 bits
// per component (sign, 5 bits of exponent from 2^-24 on, 14 of mantissa: far taps of the wavelet
// multiply its error by 32 pixels and a hundred tolerances), and 24 bits of the id. Only in half
// precision.
const float kSlopeScale = 1.97215226305252951e-31f;  // 2^-102
uint PackSlope(float slope) {
  float magnitude = min(abs(slope), 64.0f) * kSlopeScale;
  uint bits = min((floatBitsToUint(magnitude) + 0x100u) >> 9, 0x7ffffu);
  return bits < 0x4000u ? 0u : bits | (slope < 0.0f ? 0x80000u : 0u);
}
float UnpackSlope(uint bits) {
  float magnitude = uintBitsToFloat((bits & 0x7ffffu) << 9) / kSlopeScale;
  return (bits & 0x80000u) != 0u ? -magnitude : magnitude;
}
uint ShortId(uint id) {
  return id < 0x1000000u ? id : ((id * 0x9e3779b1u) >> 8) | 1u;
}

Detail UnpackDetail(uvec4 packed_detail, float inverse_depth) {
  Detail d;
#ifdef STILLRAY_HALF
  uint x = packed_detail.x & 0xfffffu;
  uint y = (packed_detail.x >> 20) | ((packed_detail.y & 0xffu) << 12);
  d.gradient = vec2(UnpackSlope(x), UnpackSlope(y)) * inverse_depth;
  d.id = packed_detail.y >> 8;
#else
  d.gradient = uintBitsToFloat(packed_detail.xy);
  d.id = packed_detail.z;
#endif
  return d;
}
uvec4 PackDetail(Detail d, float inverse_depth) {
#ifdef STILLRAY_HALF
  vec2 relative = inverse_depth > 0.0f ? d.gradient / inverse_depth : vec2(0.0f);
  uint x = PackSlope(relative.x);
  uint y = PackSlope(relative.y);
  return uvec4(x | (y << 20), (y >> 12) | (ShortId(d.id) << 8), 0u, 0u);
#else
  return uvec4(floatBitsToUint(d.gradient), d.id, 0u);
#endif
}

// Variances are stored as deviations, which have the range of the radiance in half precision. In
// the images of the wavelet a negative sign marks pixels without samples.
const float kLeastDeviation = 1e-4f;
float PackDeviation(float variance, bool valid) {
  float deviation = min(sqrt(max(variance, 0.0f)), kMostLight);
  return valid ? deviation : -max(deviation, kLeastDeviation);
}
bool IsValid(float packed_deviation) {
  return packed_deviation >= 0.0f;
}
float VarianceOf(float packed_deviation) {
  return packed_deviation * packed_deviation;
}

// Rounds to the nearest representable value. Devices may truncate to half precision, which would
// darken the radiance slightly in every stage and frame.
vec4 Stored(vec4 value) {
#ifdef STILLRAY_HALF
  uvec4 bits = floatBitsToUint(value);
  bits = (bits + 0xfffu + (bits >> 13 & 1u)) & 0xffffe000u;
  return uintBitsToFloat(bits);
#else
  return value;
#endif
}

vec3 ClampLight(vec3 light) {
  return clamp(light, vec3(-kMostLight), vec3(kMostLight));
}
