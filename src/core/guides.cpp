// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "core/guides.h"

#include <algorithm>

namespace stillray {
namespace {

/// Whether no channel is given. A single missing channel is an error.
template <int N>
bool IsLeftOut(const Planes<float, N>& planes) {
  return std::all_of(planes.channel.begin(), planes.channel.end(),
                     [](const Image1& plane) { return plane.empty(); });
}

bool IsMissing(const Frame& frame, const Image3& albedo, bool demodulate) {
  return demodulate && IsLeftOut(albedo) && DividesLight(frame, albedo);
}

Image3 Constant(int width, int height, float x, float y, float z) {
  Image3 image(width, height);
  image[0].Fill(x);
  image[1].Fill(y);
  image[2].Fill(z);
  return image;
}

}  // namespace

const Image3& AlbedoOf(const Guides& guides, SignalKind kind) {
  switch (kind) {
    case SignalKind::kDirectSpecular:
    case SignalKind::kIndirectSpecular:
      return guides.specular_albedo;
    case SignalKind::kDirectTransmission:
    case SignalKind::kIndirectTransmission:
      return guides.transmission_albedo;
    default:
      return guides.albedo;
  }
}

bool DividesLight(const Frame& frame, const Image3& albedo) {
  return std::any_of(frame.signals.begin(), frame.signals.end(), [&](const Signal& signal) {
    return &AlbedoOf(frame.guides, signal.kind) == &albedo;
  });
}

Image1 FlatDepth(int width, int height) {
  Image1 depth(width, height);
  depth.Fill(1);
  return depth;
}

Image3 FlatNormal(int width, int height) {
  return Constant(width, height, 0, 0, 1);
}

Image3 WhiteAlbedo(int width, int height) {
  return Constant(width, height, 1, 1, 1);
}

bool HasGuides(const Frame& frame, bool demodulate) {
  const Guides& g = frame.guides;
  return !g.depth.empty() && !IsLeftOut(g.normal) && !IsMissing(frame, g.albedo, demodulate) &&
         !IsMissing(frame, g.specular_albedo, demodulate) &&
         !IsMissing(frame, g.transmission_albedo, demodulate);
}

void FillMissingGuides(bool demodulate, Frame* frame) {
  Guides& g = frame->guides;
  if (g.depth.empty()) {
    g.depth = FlatDepth(frame->width, frame->height);
  }
  if (IsLeftOut(g.normal)) {
    g.normal = FlatNormal(frame->width, frame->height);
  }
  for (Image3* albedo : {&g.albedo, &g.specular_albedo, &g.transmission_albedo}) {
    if (IsMissing(*frame, *albedo, demodulate)) {
      *albedo = WhiteAlbedo(frame->width, frame->height);
    }
  }
}

}  // namespace stillray
