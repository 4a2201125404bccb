// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_remainder.h"

#include <algorithm>
#include <cmath>

#include "io/aov_light.h"
#include "io/lossy.h"

namespace stillray::io {
namespace {

/// Fraction of the passes' radiance that may be missing in the colour. Measured: below 1e-4 in
/// clean frames of Blender and of stillray, 0.4 for a denoised colour beside passes of 1 spp, 0.02
/// of 256 spp.
constexpr double kMayLack = 0.02;
/// The limit for lossy files, whose layers have ringing artefacts.
constexpr double kMayLackLossy = 0.1;
/// The passes must have this fraction of the colour's radiance, or the image would lose the
/// remainder.
constexpr double kComplete = 0.9;
constexpr float kOpaque = 0.999f;
/// Minimum number of usable pixels.
constexpr int64_t kLeastPixels = 256;

const Channel* ChannelOf(const ExrImage& image, const AovLayout& layout, Aov aov,
                         size_t component) {
  const AovSource* source = layout.Find(aov);
  const Channel* channel = source == nullptr ? nullptr : image.Find(source->channels[component]);
  return channel == nullptr || channel->type == PixelType::kUint32 ? nullptr : channel;
}

struct Balance {
  int64_t pixels = 0;
  double colour = 0;
  double passes = 0;
  double lacking = 0;  ///< radiance of the passes that is missing in the colour
};

Balance Weigh(const ExrImage& image, const AovLayout& layout, const Frame& frame) {
  const Image3 sum = SumOfLight(frame);
  const Channel* alpha = ChannelOf(image, layout, Aov::kAlpha, 0);
  Balance balance;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (alpha != nullptr && alpha->values(x, y) < kOpaque) {
        continue;
      }
      ++balance.pixels;
      for (int c = 0; c < 3; ++c) {
        const Channel* channel = ChannelOf(image, layout, Aov::kColour, static_cast<size_t>(c));
        const float a = channel == nullptr ? NAN : channel->values(x, y);
        const float b = sum[c](x, y);
        const float sky = frame.background.empty() ? 0.0f : frame.background[c](x, y);
        if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(sky) || sky != 0) {
          continue;
        }
        balance.colour += std::max(a, 0.0f);
        balance.passes += std::max(b, 0.0f);
        balance.lacking += b - a > kRoundingPart * std::fabs(b) ? b - a : 0.0f;
      }
    }
  }
  return balance;
}

}  // namespace

bool ColourIsOfOtherLight(const ExrImage& image, const AovLayout& layout, const std::string& name,
                          double* part) {
  *part = 0;
  AovLayout passes = layout;
  for (const Aov aov : {Aov::kColour, Aov::kSeenDepth, Aov::kSeenNormal, Aov::kSeenAlbedo}) {
    Drop(aov, &passes);
  }
  const Result<Frame> frame = ImportFrame(image, passes, {0, 0}, name);
  if (!frame.ok()) {
    return false;
  }
  const Balance balance = Weigh(image, layout, *frame);
  if (balance.pixels < kLeastPixels || !(balance.passes > 0)) {
    return false;
  }
  *part = balance.lacking / balance.passes;
  const Channel* red = ChannelOf(image, layout, Aov::kColour, 0);
  const bool lossy = red != nullptr && IsLossy(image, *red);
  return *part > (lossy ? kMayLackLossy : kMayLack) && balance.passes >= kComplete * balance.colour;
}

}  // namespace stillray::io
