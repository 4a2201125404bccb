// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "render/frame_store.h"

#include <algorithm>
#include <utility>

#include "render/sampler.h"

namespace stillray::render {
namespace {

bool SeparatesTransmission(const Frame& frame) {
  return frame.signals.size() > kTracedSignalCount;
}

/// Calls body(plane) for the radiance planes, which are zero in pixels without a path.
template <typename F, typename Body>
void ForEachLightPlane(F& frame, const Body& body) {
  for (auto& signal : frame.signals) {
    for (auto& plane : signal.radiance.channel) {
      body(plane);
    }
  }
}

/// Calls body(plane) for the planes of guides, emission and background.
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
  for (auto& plane : guides.transmission_albedo.channel) {
    if (SeparatesTransmission(frame)) {
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

/// Bits of the values that are zero in many pixels; bits 0 to 5 are the signals.
constexpr uint32_t kEmissionBit = 1u << 6;
constexpr uint32_t kBackgroundBit = 1u << 7;
constexpr uint32_t kMotionBit = 1u << 8;
constexpr uint32_t kAlbedoBit = 1u << 9;
constexpr uint32_t kSpecularAlbedoBit = 1u << 10;
constexpr uint32_t kGuideBits = 1u << 11;  // depth, normal, id, roughness
static_assert(kMostTracedSignals <= 6);

/// Stores the value in a cleared pixel unless it is zero. Returns `bit` if it was stored, else 0.
uint32_t StoreUnlessZero(Image3* image, int x, int y, vec3 value, uint32_t bit) {
  if (value == vec3(0.0f)) {
    return 0;
  }
  StorePixel(image, x, y, value);
  return bit;
}

uint32_t StoreSparseGuides(const PixelGuides& guides, int x, int y, Frame* frame) {
  Guides& g = frame->guides;
  g.depth(x, y) = guides.depth;
  StorePixel(&g.normal, x, y, guides.normal);
  g.id(x, y) = guides.id;
  g.roughness(x, y) = guides.roughness;
  if (!g.previous_normal.empty()) {
    StorePixel(&g.previous_normal, x, y, guides.previous_normal);
  }
  uint32_t kinds = kGuideBits;
  if (guides.motion != vec2(0.0f)) {
    g.motion[0](x, y) = guides.motion.x;
    g.motion[1](x, y) = guides.motion.y;
    kinds |= kMotionBit;
  }
  kinds |= StoreUnlessZero(&g.albedo, x, y, guides.albedo, kAlbedoBit);
  kinds |= StoreUnlessZero(&g.specular_albedo, x, y, guides.specular_albedo, kSpecularAlbedoBit);
  kinds |= StoreUnlessZero(&frame->emission, x, y, guides.emission, kEmissionBit);
  kinds |= StoreUnlessZero(&frame->background, x, y, guides.background, kBackgroundBit);
  return kinds;
}

void ClearKinds(uint32_t kinds, int x, int y, Frame* frame) {
  frame->samples(x, y) = 0.0f;
  for (size_t k = 0; k < frame->signals.size(); ++k) {
    if ((kinds & (1u << k)) != 0) {
      StorePixel(&frame->signals[k].radiance, x, y, vec3(0.0f));
    }
  }
  Guides& g = frame->guides;
  if ((kinds & kGuideBits) != 0) {
    g.depth(x, y) = 0.0f;
    StorePixel(&g.normal, x, y, vec3(0.0f));
    g.id(x, y) = 0;
    g.roughness(x, y) = 0.0f;
  }
  if ((kinds & kMotionBit) != 0) {
    g.motion[0](x, y) = 0.0f;
    g.motion[1](x, y) = 0.0f;
  }
  const std::pair<uint32_t, Image3*> images[] = {{kAlbedoBit, &g.albedo},
                                                 {kSpecularAlbedoBit, &g.specular_albedo},
                                                 {kEmissionBit, &frame->emission},
                                                 {kBackgroundBit, &frame->background}};
  for (const auto& [bit, image] : images) {
    if ((kinds & bit) != 0) {
      StorePixel(image, x, y, vec3(0.0f));
    }
  }
}

}  // namespace

void StorePixel(Image3* image, int x, int y, vec3 value) {
  for (int c = 0; c < 3; ++c) {
    (*image)[c](x, y) = value[c];
  }
}

void StoreGuides(const Tile& tile, const PixelGuides* guides, Frame* frame) {
  Guides& g = frame->guides;
  const auto store = [&](auto* plane, const auto& value) {
    for (int y = 0; y < tile.height; ++y) {
      auto* row = plane->Row(tile.y0 + y) + tile.x0;
      const PixelGuides* from = guides + y * tile.width;
      for (int x = 0; x < tile.width; ++x) {
        row[x] = value(from[x]);
      }
    }
  };
  const auto store3 = [&](Image3* image, vec3 PixelGuides::*member) {
    for (int c = 0; c < 3; ++c) {
      store(&(*image)[c], [member, c](const PixelGuides& pixel) { return (pixel.*member)[c]; });
    }
  };
  store(&g.depth, [](const PixelGuides& pixel) { return pixel.depth; });
  store(&g.motion[0], [](const PixelGuides& pixel) { return pixel.motion.x; });
  store(&g.motion[1], [](const PixelGuides& pixel) { return pixel.motion.y; });
  store(&g.id, [](const PixelGuides& pixel) { return pixel.id; });
  store(&g.roughness, [](const PixelGuides& pixel) { return pixel.roughness; });
  store3(&g.normal, &PixelGuides::normal);
  store3(&g.albedo, &PixelGuides::albedo);
  store3(&g.specular_albedo, &PixelGuides::specular_albedo);
  if (SeparatesTransmission(*frame)) {
    store3(&g.transmission_albedo, &PixelGuides::transmission_albedo);
  }
  store3(&frame->emission, &PixelGuides::emission);
  store3(&frame->background, &PixelGuides::background);
  if (!g.previous_normal.empty()) {
    store3(&g.previous_normal, &PixelGuides::previous_normal);
  }
}

void StoreLight(const Tile& tile, int spp, const SampleLight* sums, const SampleSquares* squares,
                Frame* frame) {
  const float scale = 1.0f / static_cast<float>(spp);
  for (size_t k = 0; k < frame->signals.size(); ++k) {
    Signal& signal = frame->signals[k];
    for (int y = 0; y < tile.height; ++y) {
      const SampleLight* from = sums + y * tile.width;
      for (int c = 0; c < 3; ++c) {
        float* row = signal.radiance[c].Row(tile.y0 + y) + tile.x0;
        for (int x = 0; x < tile.width; ++x) {
          row[x] = from[x][k][c] * scale;
        }
      }
      if (spp > 1) {
        float* row = signal.second_moment.Row(tile.y0 + y) + tile.x0;
        for (int x = 0; x < tile.width; ++x) {
          row[x] = squares[y * tile.width + x][k] * scale;
        }
      }
    }
  }
}

namespace {

/// Sets all members of a frame that are not planes.
void SetFacts(const RenderSettings& settings, const RenderMoment& moment, bool separates,
              Frame* frame) {
  frame->width = settings.width;
  frame->height = settings.height;
  frame->index = moment.frame_index;
  const vec2 jitter = settings.jitter ? FrameJitter(moment.frame_index) : vec2(0.0f);
  frame->jitter_x = jitter.x;
  frame->jitter_y = jitter.y;
  frame->signals.resize(separates ? kMostTracedSignals : kTracedSignalCount);
  for (size_t k = 0; k < frame->signals.size(); ++k) {
    frame->signals[k].kind = static_cast<SignalKind>(k);
  }
}

}  // namespace

void DescribeFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                   Frame* frame) {
  *frame = Frame();
  SetFacts(settings, moment, separates, frame);
}

void PrepareFrame(const RenderSettings& settings, const RenderMoment& moment, bool separates,
                  Frame* frame) {
  const int w = settings.width;
  const int h = settings.height;
  SetFacts(settings, moment, separates, frame);
  frame->on_device = nullptr;
  for (Signal& signal : frame->signals) {
    ResizeImage(&signal.radiance, w, h);
    if (settings.spp > 1) {
      ResizeImage(&signal.second_moment, w, h);
    } else {
      signal.second_moment = Image1();
    }
  }
  if (!separates) {
    frame->guides.transmission_albedo = Image3();
  }
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

SparseFrameWriter::Stamp SparseFrameWriter::MakeStamp(GuideCoverage guides, const Frame& frame) {
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

std::vector<SparseFrameWriter::StoredPixel>& SparseFrameWriter::StoredIn(const Tile& region) {
  return stored_[static_cast<size_t>(region.y0 / kSparseRegion.height * columns_ +
                                     region.x0 / kSparseRegion.width)];
}

void SparseFrameWriter::Begin(const RenderSettings& settings, const Frame& frame) {
  guides_ = settings.guides;
  is_known_ = known_ == MakeStamp(settings.guides, frame) && frame.width == settings.width &&
              frame.height == settings.height;
  known_ = Stamp();
  columns_ = (settings.width + kSparseRegion.width - 1) / kSparseRegion.width;
  const int rows = (settings.height + kSparseRegion.height - 1) / kSparseRegion.height;
  stored_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows));
}

void SparseFrameWriter::Clear(const Tile& region, Frame* frame) {
  std::vector<StoredPixel>& stored = StoredIn(region);
  if (is_known_) {
    for (const StoredPixel& pixel : stored) {
      ClearKinds(pixel.kinds, pixel.x, pixel.y, frame);
    }
  } else {
    ClearAll(region, guides_ == GuideCoverage::kSparse, frame);
  }
  stored.clear();
}

void SparseFrameWriter::Store(const Tile& region, int x, int y, const SampleLight& light,
                              const PixelGuides& guides, Frame* frame) {
  frame->samples(x, y) = 1.0f;
  uint32_t kinds = guides_ == GuideCoverage::kSparse ? StoreSparseGuides(guides, x, y, frame) : 0u;
  for (size_t k = 0; k < frame->signals.size(); ++k) {
    kinds |= StoreUnlessZero(&frame->signals[k].radiance, x, y, light[k], 1u << k);
  }
  StoredIn(region).push_back({static_cast<uint16_t>(x), static_cast<uint16_t>(y), kinds});
}

void SparseFrameWriter::End(const Frame& frame) {
  known_ = MakeStamp(guides_, frame);
}

}  // namespace stillray::render
