// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/frame_store.h"

#include <algorithm>

#include "render/sampler.h"

namespace stillray::render {
namespace {

// Calls body(plane) for the planes of light that hold zero where no path was traced.
template <typename F, typename Body>
void ForEachLightPlane(F& frame, const Body& body) {
  for (auto& signal : frame.signals) {
    for (auto& plane : signal.radiance.channel) {
      body(plane);
    }
  }
}

// ... and for those of guides, emission and background.
template <typename F, typename Body>
void ForEachGuidePlane(F& frame, const Body& body) {
  auto& guides = frame.guides;
  body(guides.depth);
  body(guides.id);
  body(guides.roughness);
  for (auto& plane : guides.motion.channel) {
    body(plane);
  }
  for (auto* image : {&guides.normal, &guides.albedo, &guides.specular_albedo, &frame.emission,
                      &frame.background}) {
    for (auto& plane : image->channel) {
      body(plane);
    }
  }
}

template <typename T>
void ClearRow(const Tile& region, int y, Plane<T>* plane) {
  std::fill_n(plane->Row(y) + region.x0, region.width, T(0));
}

void ClearAll(const Tile& region, bool with_guides, Frame* frame) {
  const auto clear = [&](auto& plane) {
    for (int y = region.y0; y < region.y0 + region.height; ++y) {
      ClearRow(region, y, &plane);
    }
  };
  clear(frame->samples);
  ForEachLightPlane(*frame, clear);
  if (with_guides) {
    ForEachGuidePlane(*frame, clear);
  }
}

void ClearTraced(const Tile& region, bool with_guides, Frame* frame) {
  for (int y = region.y0; y < region.y0 + region.height; ++y) {
    float* samples = frame->samples.Row(y);
    for (int x = region.x0; x < region.x0 + region.width; ++x) {
      if (samples[x] == 0.0f) {
        continue;
      }
      samples[x] = 0.0f;
      const auto clear = [&](auto& plane) { plane(x, y) = 0; };
      ForEachLightPlane(*frame, clear);
      if (with_guides) {
        ForEachGuidePlane(*frame, clear);
      }
    }
  }
}

}  // namespace

void StorePixel(Image3* image, int x, int y, vec3 value) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

void StoreGuides(const PixelGuides& guides, int x, int y, Frame* frame) {
  frame->guides.depth(x, y) = guides.depth;
  StorePixel(&frame->guides.normal, x, y, guides.normal);
  StorePixel(&frame->guides.albedo, x, y, guides.albedo);
  StorePixel(&frame->guides.specular_albedo, x, y, guides.specular_albedo);
  frame->guides.motion[0](x, y) = guides.motion.x;
  frame->guides.motion[1](x, y) = guides.motion.y;
  frame->guides.id(x, y) = guides.id;
  frame->guides.roughness(x, y) = guides.roughness;
  StorePixel(&frame->emission, x, y, guides.emission);
  StorePixel(&frame->background, x, y, guides.background);
}

void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, Frame* frame) {
  const int w = settings.width;
  const int h = settings.height;
  frame->width = w;
  frame->height = h;
  frame->index = moment.frame_index;
  const vec2 jitter = settings.jitter ? FrameJitter(moment.frame_index) : vec2(0.0f);
  frame->jitter_x = jitter.x;
  frame->jitter_y = jitter.y;
  frame->signals.resize(kTracedSignalCount);
  for (int k = 0; k < kTracedSignalCount; ++k) {
    Signal& signal = frame->signals[static_cast<size_t>(k)];
    signal.kind = static_cast<SignalKind>(k);
    ResizeImage(&signal.radiance, w, h);
    if (settings.spp > 1) {
      ResizeImage(&signal.second_moment, w, h);
    } else {
      signal.second_moment = Image1();
    }
  }
  frame->guides.transmission_albedo = Image3();
  ForEachGuidePlane(*frame, [&](auto& plane) { ResizeImage(&plane, w, h); });
  if (settings.spp > 1 || settings.cycle > 1) {
    ResizeImage(&frame->samples, w, h);
    if (settings.spp > 1) {
      frame->samples.Fill(static_cast<float>(settings.spp));
    }
  } else {
    frame->samples = Image1();
  }
}

SparseFrameCleaner::Stamp SparseFrameCleaner::MakeStamp(GuideCoverage guides, const Frame& frame) {
  Stamp stamp;
  const auto add = [&](const auto& plane) { stamp.planes.push_back(plane.Row(0)); };
  add(frame.samples);
  ForEachLightPlane(frame, add);
  ForEachGuidePlane(frame, add);
  stamp.width = frame.width;
  stamp.height = frame.height;
  stamp.index = frame.index;
  stamp.guides = guides;
  return stamp;
}

void SparseFrameCleaner::Begin(const RenderSettings& settings, const Frame& frame) {
  guides_ = settings.guides;
  only_traced_ = known_ == MakeStamp(settings.guides, frame);
  known_ = Stamp();
}

void SparseFrameCleaner::Clear(const Tile& region, Frame* frame) const {
  const bool with_guides = guides_ == GuideCoverage::kSparse;
  if (only_traced_) {
    ClearTraced(region, with_guides, frame);
  } else {
    ClearAll(region, with_guides, frame);
  }
}

void SparseFrameCleaner::End(const RenderSettings& settings, const Frame& frame) {
  known_ = MakeStamp(settings.guides, frame);
}

}  // namespace stillray::render
