// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// A renderer loop in C++ with adaptive sampling: after every frame the denoiser returns the
/// remaining variance, and noisy pixels get more samples in the next frame. Planar images, one
/// plane per channel.
///   c++ -std=c++17 denoise.cpp $(pkg-config --cflags --libs stillray) && ./a.out [FOLDER]
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <stillray/stillray.hpp>

namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr int kPixels = kWidth * kHeight;
constexpr int kFrames = 16;
constexpr int kMostSamples = 8;

struct Images {
  std::vector<float> light = std::vector<float>(kPixels * 3);
  std::vector<float> second_moment = std::vector<float>(kPixels);
  std::vector<float> samples = std::vector<float>(kPixels);
  std::vector<float> truth = std::vector<float>(kPixels * 3);
  std::vector<float> albedo = std::vector<float>(kPixels * 3);
  std::vector<float> normal = std::vector<float>(kPixels * 3);
  std::vector<float> depth = std::vector<float>(kPixels, 5.0f);
  std::vector<float> motion = std::vector<float>(kPixels * 2);
  std::vector<float> clean = std::vector<float>(kPixels * 3);
  std::vector<float> variance = std::vector<float>(kPixels);
};

float Uniform(uint32_t frame, uint32_t pixel, uint32_t sample) {
  uint32_t h = (frame * 64u + sample) * 0x9E3779B9u ^ pixel * 0x85EBCA6Bu;
  h = (h ^ h >> 16) * 0x7FEB352Du;
  h = (h ^ h >> 15) * 0x846CA68Bu;
  return static_cast<float>((h ^ h >> 16) >> 8) / 16777216.0f;
}

int SamplesFor(float variance, int frame) {
  // Sample count for an error of 1 %, clamped.
  return frame == 0 ? 1 : std::clamp(static_cast<int>(variance / 1e-4f), 1, kMostSamples);
}

/// Renders a wall whose left half is evenly lit and whose right half is noisy.
void Render(int frame, Images* images) {
  for (int i = 0; i < kPixels; ++i) {
    const int x = i % kWidth;
    const int y = i / kWidth;
    const float arriving = 0.6f + 0.4f * std::sin(0.02f * static_cast<float>(x + y));
    const float chance = x < kWidth / 2 ? 0.95f : 0.2f;
    const int count = SamplesFor(images->variance[i], frame);
    float sum = 0;
    float squares = 0;
    for (int s = 0; s < count; ++s) {
      const bool hit = Uniform(static_cast<uint32_t>(frame), static_cast<uint32_t>(i),
                               static_cast<uint32_t>(s)) < chance;
      const float sample = hit ? arriving / chance : 0.0f;
      sum += sample;
      squares += sample * sample;
    }
    images->samples[i] = static_cast<float>(count);
    images->second_moment[i] = squares / static_cast<float>(count);
    for (int c = 0; c < 3; ++c) {
      const float albedo = (x / 16 + y / 16) % 2 == 0 ? 0.8f : 0.2f + 0.2f * static_cast<float>(c);
      const int at = c * kPixels + i;
      images->albedo[at] = albedo;
      images->truth[at] = albedo * arriving;
      images->light[at] = albedo * sum / static_cast<float>(count);
      images->normal[at] = c == 2 ? 1.0f : 0.0f;
    }
  }
}

double RmsError(const std::vector<float>& picture, const std::vector<float>& truth) {
  double sum = 0;
  for (size_t i = 0; i < picture.size(); ++i) {
    sum += (picture[i] - truth[i]) * (picture[i] - truth[i]);
  }
  return std::sqrt(sum / static_cast<double>(picture.size()));
}

/// Writes scene-linear 32-bit floats, rows from the bottom, as defined by the format.
void WritePfm(const std::string& path, const std::vector<float>& planes) {
  std::ofstream file(path, std::ios::binary);
  file << "PF\n" << kWidth << " " << kHeight << "\n-1.0\n";
  for (int y = kHeight - 1; y >= 0; --y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = planes[static_cast<size_t>(c * kPixels + y * kWidth + x)];
        file.write(reinterpret_cast<const char*>(&value), sizeof(value));
      }
    }
  }
  if (!file.flush()) {
    std::fprintf(stderr, "cannot write %s\n", path.c_str());
    std::exit(1);
  }
}

void Check(const stillray::api::Error& error) {
  if (!error.ok()) {
    std::fprintf(stderr, "%s: %s\n", stillray_error_name(error.code), error.message.c_str());
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : ".";
  Images images;
  stillray::api::Device device;
  stillray::api::Denoiser denoiser;
  Check(device.Create());
  Check(denoiser.Create(device, "default"));

  const auto planar = [](std::vector<float>& data, int channels) {
    return stillray::api::Planar(data.data(), channels, kWidth, kHeight);
  };
  Check(denoiser.SetInput("direct_diffuse", planar(images.light, 3)));
  Check(denoiser.SetInput("direct_diffuse.second_moment", planar(images.second_moment, 1)));
  Check(denoiser.SetInput("samples", planar(images.samples, 1)));
  Check(denoiser.SetInput("albedo", planar(images.albedo, 3)));
  Check(denoiser.SetInput("normal", planar(images.normal, 3)));
  Check(denoiser.SetInput("depth", planar(images.depth, 1)));
  Check(denoiser.SetInput("motion", planar(images.motion, 2)));
  Check(denoiser.SetOutput("colour", planar(images.clean, 3)));
  Check(denoiser.SetOutput("variance", planar(images.variance, 1)));

  for (int frame = 0; frame < kFrames; ++frame) {
    Render(frame, &images);
    Check(denoiser.Execute());
  }
  double left = 0;
  double right = 0;
  for (int i = 0; i < kPixels; ++i) {
    (i % kWidth < kWidth / 2 ? left : right) += images.samples[i] / (kPixels / 2);
  }
  std::printf("samples of the last frame: even half %.2f, noisy half %.2f per pixel\n", left,
              right);
  std::printf("rms error: noisy %.4f, denoised %.4f\n", RmsError(images.light, images.truth),
              RmsError(images.clean, images.truth));
  WritePfm(folder + "/noisy.pfm", images.light);
  WritePfm(folder + "/denoised.pfm", images.clean);
  return 0;
}
