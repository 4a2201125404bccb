// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#version 450
#extension GL_GOOGLE_include_directive : require

// antialias: see stages/antialias.h. Also writes the result to the caller's image. If layers have
// been denoised before, the emission's alpha is a history length: see add_layer.comp.
#include "denoise/vulkan/common.glsl"
#include "denoise/stages/antialias_shared.h"
#include "denoise/stages/follow_light_shared.h"
#include "denoise/stages/sum_albedo_shared.h"

layout(set = 1, binding = 0) uniform utexture2D surface_image;
layout(set = 1, binding = 1) uniform utexture2D detail_image;
layout(set = 1, binding = 2) uniform texture2DArray moments;
layout(set = 1, binding = 3) uniform texture2D picture;
layout(set = 1, binding = 4) uniform texture2D picture_before;
layout(set = 1, binding = 5) uniform texture2DArray coefficients;
layout(set = 1, binding = 6) uniform texture2D followed_ratio;
layout(set = 1, binding = 7) uniform texture2D albedo_sum;
layout(set = 1, binding = 8) uniform texture2DArray albedo_range;
layout(set = 1, binding = 9) uniform texture2D albedo_before;
layout(set = 1, binding = 10) uniform texture2DArray albedo_coefficients;
layout(set = 1, binding = 11) uniform utexture2D surface_before;
layout(set = 1, binding = 12, LIGHT_FORMAT) writeonly uniform image2D picture_out;
layout(set = 1, binding = 13, LIGHT_FORMAT) writeonly uniform image2D albedo_out;

layout(push_constant) uniform Push {
  int has_albedo;  // 1: the antialiased albedo of the last frame exists
};

vec3 Load(ivec2 p) {
  return texelFetch(picture, ClampToPicture(p), 0).xyz;
}

float InverseDepth(ivec2 p) {
  return uintBitsToFloat(texelFetch(surface_image, p, 0).x);
}

vec2 Gradient(ivec2 p) {
  return UnpackDetail(texelFetch(detail_image, p, 0), InverseDepth(p)).gradient;
}

// Motion of the nearest surface of the 3x3 neighbourhood in front of the centre, else that of the
// centre; of equal depths the first in row order.
vec2 NearestMotion(ivec2 p) {
  float centre = InverseDepth(p);
  vec2 gradient = Gradient(p);
  float nearest = centre;
  ivec2 place = p;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = ClampToPicture(p + ivec2(dx, dy));
      float i = InverseDepth(q);
      if (i > nearest && StandsInFront(centre, i, gradient, vec2(q - p))) {
        nearest = i;
        place = q;
      }
    }
  }
  vec2 motion = texelFetch(motion_image, place, 0).xy;
  if (antialias.extrapolate_motion == 0 || !(nearest > centre)) {
    return motion;
  }
  vec2 gradient_of_nearest = Gradient(place);
  vec2 next[2];
  for (int k = 0; k < 2; ++k) {
    ivec2 offset = (k + 1) * (place - p);
    ivec2 q = ClampToPicture(place + offset);
    if (!IsOnPlane(nearest, gradient_of_nearest, InverseDepth(q), vec2(offset))) {
      return motion;
    }
    next[k] = texelFetch(motion_image, q, 0).xy;
  }
  return ExtrapolatedMotion(motion, next[0], next[1]);
}

// History length of a pixel's visible radiance: see TakeLengths of picture_motion.h.
float Length(ivec2 p) {
  float of_image = antialias.image_length != 0 ? texelFetch(emission_image, p, 0).w : 0.0f;
  return of_image > 0.0f ? of_image : texelFetch(moments, ivec3(p, 0), 0).z;
}

// The longest history in the 3x3 neighbourhood.
float LongestAround(ivec2 p) {
  float longest = 0.0f;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      longest = max(longest, Length(ClampToPicture(p + ivec2(dx, dy))));
    }
  }
  return longest;
}

// The antialiased image and albedo of the last frame.
struct Previous {
  vec3 picture;
  vec3 albedo;  // 0 unless has_albedo
};

vec3 ResampleSubcell(vec3 taps[4], float t) {
  return vec3(ResampleSubcell(taps[0].x, taps[1].x, taps[2].x, taps[3].x, t),
              ResampleSubcell(taps[0].y, taps[1].y, taps[2].y, taps[3].y, t),
              ResampleSubcell(taps[0].z, taps[1].z, taps[2].z, taps[3].z, t));
}

vec3 SampleSubcell(texture2D image, ivec2 first, vec2 t) {
  vec3 rows[4];
  for (int j = 0; j < 4; ++j) {
    vec3 taps[4];
    for (int i = 0; i < 4; ++i) {
      taps[i] = texelFetch(image, ClampToPicture(first + ivec2(i, j)), 0).xyz;
    }
    rows[j] = ResampleSubcell(taps, t.x);
  }
  return ResampleSubcell(rows, t.y);
}

Previous SamplePrevious(vec2 place) {
  vec2 corner = floor(place);
  vec2 t = place - corner;
  ivec2 first = ivec2(corner) - 1;
  Previous at = Previous(vec3(0.0f), vec3(0.0f));
  if (t == vec2(0.0f)) {
    ivec2 q = ClampToPicture(first + 1);
    at.picture = texelFetch(picture_before, q, 0).xyz * picture_ratio;
    if (has_albedo != 0) {
      at.albedo = texelFetch(albedo_before, q, 0).xyz;
    }
    return at;
  }
  if (antialias.resampling == kSubcell) {
    at.picture = SampleSubcell(picture_before, first, t) * picture_ratio;
    if (has_albedo != 0) {
      at.albedo = SampleSubcell(albedo_before, first, t);
    }
    return at;
  }
  bool spline = antialias.resampling == kSpline;
  vec4 wx = spline ? CubicSpline(t.x) : CatmullRom(t.x);
  vec4 wy = spline ? CubicSpline(t.y) : CatmullRom(t.y);
  for (int j = 0; j < 4; ++j) {
    Previous row = Previous(vec3(0.0f), vec3(0.0f));
    for (int i = 0; i < 4; ++i) {
      ivec2 q = ClampToPicture(first + ivec2(i, j));
      row.picture += wx[i] * (spline ? texelFetch(coefficients, ivec3(q, 0), 0).xyz
                                     : texelFetch(picture_before, q, 0).xyz);
      if (has_albedo != 0) {
        row.albedo += wx[i] * (spline ? texelFetch(albedo_coefficients, ivec3(q, 0), 0).xyz
                                      : texelFetch(albedo_before, q, 0).xyz);
      }
    }
    at.picture += wy[j] * row.picture;
    at.albedo += wy[j] * row.albedo;
  }
  at.picture *= picture_ratio;
  return at;
}

vec3 Albedo(ivec2 p) {
  return texelFetch(albedo_sum, ClampToPicture(p), 0).xyz;
}

vec3 LightOfPicture(vec3 c, vec3 albedo) {
  return vec3(LightOfPicture(c.x, albedo.x), LightOfPicture(c.y, albedo.y),
              LightOfPicture(c.z, albedo.z));
}

vec3 PictureOfLight(vec3 l, vec3 albedo) {
  return vec3(PictureOfLight(l.x, albedo.x), PictureOfLight(l.y, albedo.y),
              PictureOfLight(l.z, albedo.z));
}

struct Range {
  vec3 low;
  vec3 high;
};

void AddTo(inout Range range, vec3 value) {
  range.low = min(range.low, value);
  range.high = max(range.high, value);
}

// Whether another surface is within kTextureClear pixels along an axis.
bool IsBesideSurface(ivec2 p) {
  float here = InverseDepth(p);
  vec2 gradient = Gradient(p);
  for (int k = 1; k <= kTextureClear; ++k) {
    for (int side = 0; side < 4; ++side) {
      int offset = side < 2 ? -k : k;
      ivec2 q = ClampToPicture(p + (side % 2 == 0 ? ivec2(offset, 0) : ivec2(0, offset)));
      if (!IsOnPlane(here, gradient, InverseDepth(q), vec2(q - p))) {
        return true;
      }
    }
  }
  return false;
}

float DepthBefore(ivec2 p) {
  return uintBitsToFloat(texelFetch(surface_before, ClampToPicture(p), 0).x);
}

// WasBesideSurface for the pixel of the last frame that is nearest to a position.
bool WasBesideSurface(vec2 place) {
  ivec2 p = ivec2(floor(place + 0.5f));
  float here = DepthBefore(p);
  for (int k = 1; k <= kTextureClear; ++k) {
    if (WasBesideSurface(here, DepthBefore(p - ivec2(k, 0)), DepthBefore(p + ivec2(k, 0))) ||
        WasBesideSurface(here, DepthBefore(p - ivec2(0, k)), DepthBefore(p + ivec2(0, k)))) {
      return true;
    }
  }
  return false;
}

// The previous albedo, clamped to the range of values that this surface may have. around: the range
// of the albedo in 3x3 pixels.
vec3 ClampAlbedo(ivec2 p, vec2 place, vec3 albedo, Range around) {
  ivec2 last = ivec2(AlbedoBlocks(width), AlbedoBlocks(height)) - 1;
  vec4 low = vec4(kMostLight);
  vec4 high = vec4(0.0f, 0.0f, 0.0f, kNoImage);
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      ivec2 block = clamp(p / kAlbedoBlock + ivec2(i, j), ivec2(0), last);
      low = min(low, texelFetch(albedo_range, ivec3(block, 0), 0));
      high = max(high, texelFetch(albedo_range, ivec3(block, 1), 0));
    }
  }
  albedo = min(max(albedo, low.xyz), high.xyz);
  bool beside_image = antialias.image_albedo != 0 &&
                      IsBesideImageByLog(texelFetch(albedo_sum, p, 0).w, low.w, high.w);
  if (!IsYoung(Length(p), GivenSamples(p)) && !IsBesideSurface(p) && !WasBesideSurface(place) &&
      !beside_image) {
    return albedo;
  }
  return min(max(albedo, around.low), around.high);
}

// The range of the image, widened by WidenedLow and WidenedHigh.
Range Widen(Range colours, vec3 albedo, Range albedos) {
  Range wide;
  for (int c = 0; c < 3; ++c) {
    wide.low[c] = WidenedLow(colours.low[c], albedo[c], albedos.low[c]);
    wide.high[c] = WidenedHigh(colours.high[c], albedo[c], albedos.high[c]);
  }
  return wide;
}

// The ratio of follow_light, interpolated between blocks.
float RatioAt(ivec2 p) {
  vec2 place = (vec2(p) - 0.5f * float(kFollowBlock)) / float(kFollowBlock);
  ivec2 corner = ivec2(floor(place));
  vec2 t = place - vec2(corner);
  ivec2 last = ivec2(FollowSize(width), FollowSize(height)) - 1;
  float ratio[4];
  for (int k = 0; k < 4; ++k) {
    ivec2 block = clamp(corner + ivec2(k & 1, k >> 1), ivec2(0), last);
    ratio[k] = texelFetch(followed_ratio, block, 0).x;
  }
  float above = ratio[0] + t.x * (ratio[1] - ratio[0]);
  float below = ratio[2] + t.x * (ratio[3] - ratio[2]);
  return above + t.y * (below - above);
}

// Writes the antialiased albedo.
void KeepAlbedo(ivec2 p, vec3 albedo) {
  if (antialias.clamp_light != 0) {
    imageStore(albedo_out, p, Stored(vec4(albedo, 1.0f)));
  }
}

vec3 Antialiased(ivec2 p, vec3 now) {
  vec2 motion = NearestMotion(p);
  vec2 place = vec2(p) + motion;
  bool inside = place.x > -0.5f && place.y > -0.5f && place.x < float(width) - 0.5f &&
                place.y < float(height) - 0.5f && !IsNaN(motion.x) && !IsNaN(motion.y);
  vec3 albedo = antialias.clamp_light != 0 ? Albedo(p) : vec3(0.0f);
  if (!inside) {
    KeepAlbedo(p, albedo);
    return now;
  }
  Range colours = Range(now, now);
  Range albedos_around = Range(albedo, albedo);
  Range lights_around = Range(LightOfPicture(now, albedo), LightOfPicture(now, albedo));
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      ivec2 q = p + ivec2(dx, dy);
      vec3 c = Load(q);
      AddTo(colours, c);
      if (has_albedo != 0) {
        vec3 a = Albedo(q);
        AddTo(albedos_around, a);
        AddTo(lights_around, LightOfPicture(c, a));
      }
    }
  }
  float ratio = antialias.follow_light != 0 ? RatioAt(p) : 1.0f;
  Previous previous = SamplePrevious(place);
  vec3 before = ratio * previous.picture;
  if (has_albedo != 0) {
    previous.albedo = ClampAlbedo(p, place, previous.albedo, albedos_around);
    vec3 l = LightOfPicture(before, previous.albedo);
    before = PictureOfLight(min(max(l, lights_around.low), lights_around.high), previous.albedo);
    colours = Widen(colours, previous.albedo, albedos_around);
  }
  before = min(max(before, colours.low), colours.high);
  float agreement = 1.0f;
  for (int c = 0; c < 3 && has_albedo != 0; ++c) {
    agreement = min(agreement, AlbedoAgreement(albedo[c], previous.albedo[c]));
  }
  float least = MovingAlpha(antialias.taa_alpha, antialias.taa_moving_alpha, motion, agreement);
  float alpha = antialias.weigh_by_length != 0
                    ? NewPictureWeight(ConfidentAlpha(least, Confidence(p)), LongestAround(p),
                                       GivenSamples(p))
                    : least;
  KeepAlbedo(p, has_albedo != 0 ? previous.albedo + alpha * (albedo - previous.albedo) : albedo);
  if (antialias.tone_scale > 0.0f) {
    float scale = antialias.tone_scale / picture_exposure;
    return vec3(BlendTonemapped(before.x, now.x, alpha, scale),
                BlendTonemapped(before.y, now.y, alpha, scale),
                BlendTonemapped(before.z, now.z, alpha, scale));
  }
  return before + alpha * (now - before);
}

void main() {
  ivec2 p = ivec2(gl_GlobalInvocationID.xy);
  if (!Inside(p)) {
    return;
  }
  vec3 c = Load(p);
  if (has_picture != 0) {
    c = Antialiased(p, c);
  } else if (antialias.clamp_light != 0) {
    KeepAlbedo(p, Albedo(p));
  }
  imageStore(picture_out, p, Stored(vec4(c, 1.0f)));
  float alpha = keeps_length != 0 ? texelFetch(moments, ivec3(p, 0), 0).z : 1.0f;
  vec4 result = vec4(c / picture_exposure, alpha);
  if (colour_is_half != 0) {
    imageStore(colour_half, p,
               Stored(vec4(clamp(result.xyz, vec3(-65504.0f), vec3(65504.0f)), 1.0f)));
  } else {
    imageStore(colour_float, p, result);
  }
}
