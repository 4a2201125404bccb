// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Denoises a sequence with past and future frames: frames are pushed as they are rendered, and
/// pulled some frames later. The camera pans over a wall that is lit with one noisy sample per
/// pixel. Prints the error of the first frame, which has no past.
///   denoise_sequence_cpp_engine
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "stillray/two_way.hpp"

namespace {

using stillray::Image3;

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr int kFrames = 40;
constexpr int kPan = 2;  // pixels per frame
constexpr float kAlbedo[3] = {0.3f, 0.5f, 0.7f};

float Uniform(int64_t frame, int x, int y) {
  uint32_t h = static_cast<uint32_t>(frame) * 0x9E3779B9u ^
               static_cast<uint32_t>(y * kWidth + x) * 0x85EBCA6Bu;
  h = (h ^ h >> 16) * 0x7FEB352Du;
  h = (h ^ h >> 15) * 0x846CA68Bu;
  return static_cast<float>((h ^ h >> 16) >> 8) / 16777216.0f;
}

/// Irradiance over pi at the point of the wall that is visible in a pixel of a frame.
float Arriving(int64_t frame, int x, int y) {
  const auto u = static_cast<float>(x + kPan * frame);
  return 0.6f + 0.4f * std::sin(0.02f * u) * std::cos(0.03f * static_cast<float>(y));
}

stillray::Frame Render(int64_t index) {
  stillray::Frame frame;
  frame.width = kWidth;
  frame.height = kHeight;
  frame.index = index;
  frame.signals.push_back(
      {stillray::SignalKind::kDirectDiffuse, Image3(kWidth, kHeight), stillray::Image1()});
  stillray::Guides& g = frame.guides;
  g.depth = stillray::Image1(kWidth, kHeight);
  g.depth.Fill(5.0f);
  g.normal = Image3(kWidth, kHeight);
  g.normal[2].Fill(1.0f);
  g.albedo = Image3(kWidth, kHeight);
  g.motion = stillray::Image2(kWidth, kHeight);
  g.motion[0].Fill(kPan);
  for (int c = 0; c < 3; ++c) {
    g.albedo[c].Fill(kAlbedo[c]);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const float sample = Uniform(index, x, y) < 0.25f ? 4 * Arriving(index, x, y) : 0.0f;
        frame.signals[0].radiance[c](x, y) = kAlbedo[c] * sample;
      }
    }
  }
  return frame;
}

double RmsError(const Image3& picture, int64_t frame) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        sum += std::pow(picture[c](x, y) - kAlbedo[c] * Arriving(frame, x, y), 2.0);
      }
    }
  }
  return std::sqrt(sum / (3.0 * kWidth * kHeight));
}

/// Pulls all finished frames. \param done [in,out] number of pulled frames
stillray::Status PullReady(stillray::TwoWayDenoiser* denoiser, int* done) {
  while (denoiser->ready()) {
    stillray::DenoisedFrame clean;
    stillray::Frame noisy;
    STILLRAY_RETURN_IF_ERROR(denoiser->Pull(&clean, &noisy).status());
    if (noisy.index == 0) {
      std::printf("rms error: noisy %.4f, denoised %.4f\n",
                  RmsError(stillray::SumOfLight(noisy), 0), RmsError(clean.colour, 0));
    }
    ++*done;
  }
  return stillray::Status::Ok();
}

stillray::Status Run() {
  const stillray::Settings settings = stillray::PresetSettings("default").value();
  const auto need = stillray::TwoWayDenoiser::MemoryNeed(settings, Render(0));
  STILLRAY_RETURN_IF_ERROR(need.status());
  std::printf("memory: %.0f MB at most\n", static_cast<double>(need->most) / 1e6);
  stillray::Result<stillray::TwoWayDenoiser> denoiser = stillray::TwoWayDenoiser::Create(settings);
  STILLRAY_RETURN_IF_ERROR(denoiser.status());
  int done = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    STILLRAY_RETURN_IF_ERROR(denoiser->Push(Render(frame)));
    STILLRAY_RETURN_IF_ERROR(PullReady(&*denoiser, &done));
  }
  denoiser->Finish();
  STILLRAY_RETURN_IF_ERROR(PullReady(&*denoiser, &done));
  std::printf("%d frames\n", done);
  return stillray::Status::Ok();
}

}  // namespace

int main() {
  const stillray::Status status = Run();
  if (!status.ok()) {
    std::fprintf(stderr, "%s\n", status.message().c_str());
    return 1;
  }
  return 0;
}
