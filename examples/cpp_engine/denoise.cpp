// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// How a renderer in C++ fills a stillray::Frame: a chequered floor that turns red at one side, a
/// shiny wall behind it, and sky, seen by a camera that pans, with one noisy sample per pixel.
/// Writes noisy.ppm and denoised.ppm of the last frame.
///   denoise_cpp_engine [FOLDER]
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

#include "stillray/denoise.hpp"

namespace {

using stillray::Image3;

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr int kFrames = 16;
constexpr int kPan = 2;       // pixels per frame
constexpr int kHorizon = 40;  // sky above
constexpr int kFloor = 110;   // wall above, floor from here on

float Uniform(int64_t frame, int x, int y, uint32_t dimension) {
  uint32_t h = static_cast<uint32_t>(frame) * 0x9E3779B9u ^
               static_cast<uint32_t>(y * kWidth + x) * 0x85EBCA6Bu ^ dimension * 0xC2B2AE35u;
  h = (h ^ h >> 16) * 0x7FEB352Du;
  h = (h ^ h >> 15) * 0x846CA68Bu;
  return static_cast<float>((h ^ h >> 16) >> 8) / 16777216.0f;
}

void Set(Image3* image, int x, int y, float r, float g, float b) {
  (*image)[0](x, y) = r;
  (*image)[1](x, y) = g;
  (*image)[2](x, y) = b;
}

/// One-sample estimate of the irradiance over pi: four times `arriving` with probability 1/4, else
/// 0.
float Sample(float arriving, float random) {
  return random < 0.25f ? 4.0f * arriving : 0.0f;
}

/// Allocates the images that this renderer provides; empty images are optional inputs that are
/// omitted.
stillray::Frame MakeFrame() {
  using stillray::Image1;
  stillray::Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  for (const auto kind :
       {stillray::SignalKind::kDirectDiffuse, stillray::SignalKind::kDirectSpecular}) {
    stillray::Signal signal;
    signal.kind = kind;
    signal.radiance = Image3(kWidth, kHeight);
    frame.signals.push_back(std::move(signal));
  }
  stillray::Guides& g = frame.guides;
  g.depth = Image1(kWidth, kHeight);
  g.normal = Image3(kWidth, kHeight);
  g.albedo = Image3(kWidth, kHeight);
  g.specular_albedo = Image3(kWidth, kHeight);
  g.motion = stillray::Image2(kWidth, kHeight);
  g.id = stillray::Plane<uint32_t>(kWidth, kHeight);
  frame.background = Image3(kWidth, kHeight);
  return frame;
}

/// Renders one pixel: the guides of its first hit, and one path from there.
void RenderPixel(int x, int y, stillray::Frame* frame, Image3* truth) {
  stillray::Guides& g = frame->guides;
  Image3& diffuse = frame->signals[0].radiance;
  Image3& specular = frame->signals[1].radiance;
  if (y < kHorizon) {  // the ray left the scene: no surface, and radiance without noise
    const float sky = 0.3f + 0.01f * static_cast<float>(y);
    g.depth(x, y) = std::numeric_limits<float>::infinity();
    Set(&frame->background, x, y, 0.6f * sky, 0.8f * sky, sky);
    Set(truth, x, y, 0.6f * sky, 0.8f * sky, sky);
    return;
  }
  const int u = x + kPan * static_cast<int>(frame->index);  // position on the surface
  const bool floor = y >= kFloor;
  const float arriving = 0.6f + 0.4f * std::sin(static_cast<float>(u) * 0.02f);
  const float shade = (u / 16 + y / 16) % 2 == 0 ? 0.8f : 0.3f;
  const float red = std::min(1.0f, 0.002f * static_cast<float>(u));
  const float albedo[3] = {shade, shade * (1 - 0.5f * red), shade * (1 - 0.5f * red)};
  // specular reflectance of the wall, equal for all colours
  const float shine = floor ? 0.0f : 0.2f;
  const float diffuse_sample = Sample(arriving, Uniform(frame->index, x, y, 0));
  const float specular_sample = Sample(2 * arriving, Uniform(frame->index, x, y, 1));

  // Linear view z: on the floor it decreases towards the lower edge, as 1 / (distance to the
  // horizon).
  g.depth(x, y) = floor ? 350.0f / static_cast<float>(y - kHorizon) : 5.0f;
  Set(&g.normal, x, y, 0, floor ? 1.0f : 0.0f, floor ? 0.0f : 1.0f);
  Set(&g.albedo, x, y, albedo[0], albedo[1], albedo[2]);
  Set(&g.specular_albedo, x, y, shine, shine, shine);
  g.motion[0](x, y) = kPan;  // previous minus current pixel position of the point
  g.motion[1](x, y) = 0;
  g.id(x, y) = floor ? 1 : 2;
  Set(&diffuse, x, y, albedo[0] * diffuse_sample, albedo[1] * diffuse_sample,
      albedo[2] * diffuse_sample);
  Set(&specular, x, y, shine * specular_sample, shine * specular_sample, shine * specular_sample);
  for (int c = 0; c < 3; ++c) {
    (*truth)[c](x, y) = albedo[c] * arriving + shine * 2 * arriving;
  }
}

double RmsError(const Image3& picture, const Image3& truth) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double difference = picture[c](x, y) - truth[c](x, y);
        sum += difference * difference;
      }
    }
  }
  return std::sqrt(sum / (3.0 * kWidth * kHeight));
}

void WritePpm(const std::string& path, const Image3& picture) {
  std::ofstream file(path, std::ios::binary);
  file << "P6\n" << kWidth << ' ' << kHeight << "\n255\n";
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float shown = std::pow(std::clamp(picture[c](x, y), 0.0f, 1.0f), 1 / 2.2f);
        file.put(static_cast<char>(static_cast<int>(shown * 255.0f + 0.5f)));
      }
    }
  }
  if (!file.flush()) {
    std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string folder = argc > 1 ? argv[1] : ".";
  stillray::Result<stillray::Denoiser> denoiser =
      stillray::Denoiser::Create(stillray::PresetSettings("default").value());
  if (!denoiser.ok()) {
    std::fprintf(stderr, "%s\n", denoiser.status().message().c_str());
    return 1;
  }
  stillray::Frame frame = MakeFrame();  // memory reused for all frames
  stillray::DenoisedFrame clean;
  Image3 truth(kWidth, kHeight);
  for (frame.index = 0; frame.index < kFrames; ++frame.index) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        RenderPixel(x, y, &frame, &truth);
      }
    }
    const stillray::Status status = denoiser->Denoise(frame, &clean);
    if (!status.ok()) {
      std::fprintf(stderr, "%s\n", status.message().c_str());
      return 1;
    }
    if (!clean.warning.empty()) {
      std::fprintf(stderr, "warning: %s\n", clean.warning.c_str());
    }
  }
  const Image3 noisy = stillray::SumOfLight(frame);
  std::printf("rms error: noisy %.4f, denoised %.4f\n", RmsError(noisy, truth),
              RmsError(clean.colour, truth));
  WritePpm(folder + "/noisy.ppm", noisy);
  WritePpm(folder + "/denoised.ppm", clean.colour);
  return 0;
}
