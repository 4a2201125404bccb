// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Frames of the denoiser's tests as a caller of the C API holds them.
#pragma once

#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/half.h"
#include "denoise/test_frames.h"
#include "stillray/stillray.h"

namespace stillray::test {

struct DenoiserRelease {
  void operator()(stillray_denoiser* d) const { stillray_denoiser_release(d); }
};
using DenoiserHandle = std::unique_ptr<stillray_denoiser, DenoiserRelease>;

inline DenoiserHandle MakeDenoiser(const char* preset = nullptr, int threads = 2) {
  stillray_device* device = nullptr;
  EXPECT_EQ(stillray_device_create(STILLRAY_ABI_VERSION, threads, &device), STILLRAY_OK);
  stillray_denoiser* denoiser = nullptr;
  EXPECT_EQ(stillray_denoiser_create(device, preset, &denoiser), STILLRAY_OK);
  stillray_device_release(device);
  return DenoiserHandle(denoiser);
}

enum class Layout { kInterleaved, kPlanar, kBottomUp, kPaddedRgba };

/// Memory of one image and its description.
struct Buffer {
  std::vector<char> bytes;
  stillray_image image = {};

  Buffer() = default;
  Buffer(int width, int height, int channels, stillray_format format, Layout layout) {
    const ptrdiff_t size = format == STILLRAY_FORMAT_HALF ? 2 : 4;
    const int stored = layout == Layout::kPaddedRgba ? 4 : channels;
    // Odd padding: elements are not aligned.
    const ptrdiff_t padding = layout == Layout::kPaddedRgba ? 13 : 0;
    const ptrdiff_t row = width * stored * size + padding;
    bytes.assign(static_cast<size_t>(row * height), 0x55);
    image = layout == Layout::kPlanar
                ? stillray_planar(bytes.data(), format, stored, width, height)
                : stillray_interleaved(bytes.data(), format, stored, width, height);
    if (layout == Layout::kPaddedRgba) {
      image.row_stride = row;
    } else if (layout == Layout::kBottomUp) {
      image.data = bytes.data() + row * (height - 1);
      image.row_stride = -row;
    }
  }
  Buffer(Buffer&&) = default;
  Buffer& operator=(Buffer&&) = default;

  char* At(int x, int y, int c) const {
    const ptrdiff_t size = image.format == STILLRAY_FORMAT_HALF ? 2 : 4;
    const ptrdiff_t pixel = image.pixel_stride != 0 ? image.pixel_stride : image.channels * size;
    const ptrdiff_t row = image.row_stride != 0 ? image.row_stride : pixel * image.width;
    const ptrdiff_t channel = image.channel_stride != 0 ? image.channel_stride : size;
    return static_cast<char*>(image.data) + y * row + x * pixel + c * channel;
  }
  void Set(int x, int y, int c, float value) {
    if (image.format == STILLRAY_FORMAT_HALF) {
      const uint16_t half = HalfFromFloat(value);
      std::memcpy(At(x, y, c), &half, 2);
    } else {
      std::memcpy(At(x, y, c), &value, 4);
    }
  }
  float Get(int x, int y, int c) const {
    if (image.format == STILLRAY_FORMAT_HALF) {
      uint16_t half = 0;
      std::memcpy(&half, At(x, y, c), 2);
      return FloatFromHalf(half);
    }
    float value = 0;
    std::memcpy(&value, At(x, y, c), 4);
    return value;
  }
};

/// The images of a frame by name, in the caller's memory.
struct CallerFrame {
  int width = 0;
  int height = 0;
  float jitter_x = 0;
  float jitter_y = 0;
  float focal_pixels = 0;
  stillray_format format = STILLRAY_FORMAT_FLOAT;
  Layout layout = Layout::kInterleaved;
  std::map<std::string, Buffer> inputs;
  Buffer colour;

  CallerFrame(const Frame& frame, stillray_format image_format = STILLRAY_FORMAT_FLOAT,
              Layout image_layout = Layout::kInterleaved)
      : width(frame.width),
        height(frame.height),
        jitter_x(frame.jitter_x),
        jitter_y(frame.jitter_y),
        focal_pixels(frame.focal_pixels),
        format(image_format),
        layout(image_layout) {
    for (const Signal& signal : frame.signals) {
      Add(SignalName(signal.kind), signal.radiance);
    }
    const Guides& g = frame.guides;
    Add("normal", g.normal);
    Add("previous_normal", g.previous_normal);
    Add("albedo", g.albedo);
    Add("specular_albedo", g.specular_albedo);
    Add("transmission_albedo", g.transmission_albedo);
    Add("motion", g.motion);
    Add("depth", g.depth);
    Add("roughness", g.roughness);
    Add("emission", frame.emission);
    Add("background", frame.background);
    Add("samples", frame.samples);
    Add("confidence", frame.confidence);
    AddIds("id", g.id);
    for (const auto& [name, image] :
         {std::pair("reflection", &frame.reflection), std::pair("refraction", &frame.refraction)}) {
      const std::string of = name;
      Add(of + "_depth", image->depth);
      Add(of + "_normal", image->normal);
      Add(of + "_albedo", image->albedo);
      Add(of + "_motion", image->motion);
      AddIds(of + "_id", image->id);
    }
    colour = Buffer(width, height, 3, format, layout);
  }

  Buffer& Make(const std::string& name, int channels) {
    return inputs[name] = Buffer(width, height, channels, format, layout);
  }
  template <int N>
  void Add(const std::string& name, const Planes<float, N>& planes) {
    if (planes.empty()) {
      return;
    }
    Buffer& buffer = Make(name, N);
    for (int c = 0; c < N; ++c) {
      Copy(planes[c], c, &buffer);
    }
  }
  void Add(const std::string& name, const Image1& plane) {
    if (!plane.empty()) {
      Copy(plane, 0, &Make(name, 1));
    }
  }
  void AddIds(const std::string& name, const Plane<uint32_t>& ids) {
    if (ids.empty()) {
      return;
    }
    Buffer& buffer = inputs[name] = Buffer(width, height, 1, STILLRAY_FORMAT_UINT32, layout);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        std::memcpy(buffer.At(x, y, 0), &ids(x, y), 4);
      }
    }
  }
  void Copy(const Image1& plane, int c, Buffer* buffer) const {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        buffer->Set(x, y, c, plane(x, y));
      }
    }
  }
  void Give(stillray_denoiser* denoiser) {
    for (auto& [name, buffer] : inputs) {
      ASSERT_EQ(stillray_denoiser_set_input(denoiser, name.c_str(), &buffer.image), STILLRAY_OK)
          << stillray_error_message(denoiser);
    }
    ASSERT_EQ(stillray_denoiser_set_jitter(denoiser, jitter_x, jitter_y), STILLRAY_OK)
        << stillray_error_message(denoiser);
    ASSERT_EQ(stillray_denoiser_set_focal_pixels(denoiser, focal_pixels), STILLRAY_OK)
        << stillray_error_message(denoiser);
    ASSERT_EQ(stillray_denoiser_set_output(denoiser, "colour", &colour.image), STILLRAY_OK)
        << stillray_error_message(denoiser);
  }
  /// Denoises this frame into `colour`.
  void Run(stillray_denoiser* denoiser) {
    Give(denoiser);
    ASSERT_EQ(stillray_denoiser_execute(denoiser), STILLRAY_OK) << stillray_error_message(denoiser);
  }
};

/// The frame with all values rounded to halves.
inline Frame RoundedToHalf(Frame frame) {
  const auto round_plane = [](Image1* plane) {
    for (int y = 0; y < plane->height(); ++y) {
      for (int x = 0; x < plane->width(); ++x) {
        (*plane)(x, y) = FloatFromHalf(HalfFromFloat((*plane)(x, y)));
      }
    }
  };
  const auto round_planes = [&](auto* planes) {
    for (Image1& plane : planes->channel) {
      round_plane(&plane);
    }
  };
  for (Signal& signal : frame.signals) {
    round_planes(&signal.radiance);
  }
  Guides& g = frame.guides;
  round_planes(&g.normal);
  round_planes(&g.previous_normal);
  round_planes(&g.albedo);
  round_planes(&g.specular_albedo);
  round_planes(&g.transmission_albedo);
  round_planes(&g.motion);
  round_plane(&g.depth);
  round_plane(&g.roughness);
  round_planes(&frame.emission);
  round_planes(&frame.background);
  round_plane(&frame.samples);
  round_plane(&frame.confidence);
  return frame;
}

}  // namespace stillray::test
