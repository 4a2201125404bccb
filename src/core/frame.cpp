// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "stillray/frame.h"

namespace stillray {

const char* SignalName(SignalKind kind) {
  switch (kind) {
    case SignalKind::kDirectDiffuse:
      return "direct_diffuse";
    case SignalKind::kIndirectDiffuse:
      return "indirect_diffuse";
    case SignalKind::kDirectSpecular:
      return "direct_specular";
    case SignalKind::kIndirectSpecular:
      return "indirect_specular";
    case SignalKind::kDirectTransmission:
      return "direct_transmission";
    case SignalKind::kIndirectTransmission:
      return "indirect_transmission";
  }
  return "unknown";
}

const Signal* Frame::Find(SignalKind kind) const {
  for (const Signal& signal : signals) {
    if (signal.kind == kind) {
      return &signal;
    }
  }
  return nullptr;
}

Result<const Frame*> OnHost(const Frame& frame, Frame* room, uint32_t planes) {
  if (frame.on_device == nullptr) {
    return &frame;
  }
  room->width = frame.width;
  room->height = frame.height;
  room->index = frame.index;
  room->jitter_x = frame.jitter_x;
  room->jitter_y = frame.jitter_y;
  room->focal_pixels = frame.focal_pixels;
  room->on_device = nullptr;
  STILLRAY_RETURN_IF_ERROR(frame.on_device->Download(planes, room));
  return static_cast<const Frame*>(room);
}

size_t FrameBytes(const Frame& frame) {
  const Guides& g = frame.guides;
  size_t bytes = g.depth.bytes() + g.normal.bytes() + g.albedo.bytes() + g.specular_albedo.bytes() +
                 g.transmission_albedo.bytes() + g.motion.bytes() + g.id.bytes() +
                 g.roughness.bytes() + g.previous_normal.bytes() + frame.reflection.bytes() +
                 frame.refraction.bytes() + frame.confidence.bytes() + frame.emission.bytes() +
                 frame.background.bytes() + frame.samples.bytes();
  for (const Signal& signal : frame.signals) {
    bytes += signal.radiance.bytes() + signal.second_moment.bytes();
  }
  return bytes + (frame.on_device != nullptr ? frame.on_device->bytes() : 0);
}

Image3 SumOfLight(const Frame& frame) {
  Image3 sum(frame.width, frame.height);
  const auto add = [&](const Image3& image) {
    if (image.empty()) {
      return;
    }
    for (int c = 0; c < 3; ++c) {
      for (int y = 0; y < frame.height; ++y) {
        const float* in = image[c].Row(y);
        float* out = sum[c].Row(y);
        for (int x = 0; x < frame.width; ++x) {
          out[x] += in[x];
        }
      }
    }
  };
  for (const Signal& signal : frame.signals) {
    add(signal.radiance);
  }
  add(frame.emission);
  add(frame.background);
  return sum;
}

}  // namespace stillray
