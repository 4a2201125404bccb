// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Any bytes as a picture: readers must return an error or a whole picture, and leave bounds on
// memory to the checks in front of them. The first byte picks the reader.
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "stillray/io.h"

/// Keeps the compiler from leaving reads out.
volatile double stillray_fuzz_sink = 0;

namespace {

/// Decoded images have the stated size, and all of their memory is readable.
void Use(const stillray::Image3& image) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    if (image[c].width() != image.width() || image[c].height() != image.height()) {
      std::abort();
    }
    for (int y = 0; y < image.height(); ++y) {
      sum += static_cast<double>(image[c](0, y)) + image[c](image.width() - 1, y);
    }
  }
  stillray_fuzz_sink = sum;
}

void UseExr(const stillray::ExrImage& image) {
  for (const stillray::Channel& channel : image.channels) {
    const bool integers = channel.type == stillray::PixelType::kUint32;
    const int width = integers ? channel.integers.width() : channel.values.width();
    const int height = integers ? channel.integers.height() : channel.values.height();
    if (width != image.width || height != image.height || width < 1 || height < 1) {
      std::abort();
    }
  }
  const stillray::Result<stillray::Image3> colour = stillray::ExrColour(image, "fuzz");
  if (colour.ok()) {
    Use(*colour);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) {
    return 0;
  }
  const uint8_t kind = data[0];
  ++data;
  --size;
  // The calling thread alone, so that a finding can be repeated.
  [[maybe_unused]] static const bool prepared = [] {
    stillray::SetExrThreads(0);
    return true;
  }();
  if (kind % 4 == 0) {
    const stillray::Result<stillray::ExrImage> image = stillray::DecodeExr(data, size, "fuzz");
    if (image.ok()) {
      UseExr(*image);
    }
  } else if (kind % 4 == 1) {
    const stillray::Result<stillray::Rgb8Image> image = stillray::DecodePng8(data, size, "fuzz");
    if (image.ok() && image->pixels.size() != static_cast<size_t>(image->width) *
                                                  static_cast<size_t>(image->height) * 3) {
      std::abort();
    }
  } else {
    const stillray::Result<stillray::Image3> image = stillray::DecodeImage(data, size, "fuzz");
    if (image.ok()) {
      Use(*image);
    }
  }
  return 0;
}
