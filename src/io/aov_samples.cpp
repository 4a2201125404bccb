// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "io/aov_samples.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "core/pixels.h"
#include "io/aov_light.h"
#include "io/text.h"

namespace stillray::io {
namespace {

constexpr std::string_view kFractions = "Debug Sample Count";

}  // namespace

bool HoldsFractions(const AovSource& samples) {
  return samples.layer == kFractions || samples.layer.ends_with(fmt::format(".{}", kFractions));
}

std::string SamplesAttribute(const AovSource& samples) {
  const std::string view_layer = samples.layer.substr(0, samples.layer.size() - kFractions.size());
  return fmt::format("cycles.{}samples", view_layer.empty() ? "ViewLayer." : view_layer);
}

int CyclesSamples(const ExrImage& image, const AovSource& samples) {
  const auto at = image.attributes.find(SamplesAttribute(samples));
  if (at == image.attributes.end()) {
    return 0;
  }
  const std::string& text = at->second;
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() && number > 0 ? number : 0;
}

int StatedSamples(const ExrImage& image) {
  int most = 0;
  for (const auto& [name, text] : image.attributes) {
    const std::string_view attribute = name;
    int samples = 0;
    const char* end = text.data() + text.size();
    if (attribute.starts_with("cycles.") && attribute.ends_with(".samples") &&
        std::from_chars(text.data(), end, samples).ptr == end) {
      most = std::max(most, samples);
    }
  }
  return most;
}

void ToCounts(int samples, Image1* fractions) {
  ForEachPixel(fractions->width(), fractions->height(), [&](int x, int y) {
    float& value = (*fractions)(x, y);
    const bool sampled = std::isfinite(value) && value > 0;
    value = sampled ? std::max(std::round(value * static_cast<float>(samples)), 1.0f) : 0.0f;
  });
}

void DecideSamples(const ExrImage& image, AovLayout* layout) {
  const AovSource* samples = layout->Find(Aov::kSamples);
  if (samples == nullptr || !HoldsFractions(*samples) || CyclesSamples(image, *samples) > 0) {
    return;
  }
  layout->notes.push_back(
      fmt::format("{} is not used: it holds fractions of the number of samples, and the file has "
                  "no attribute {} with that number",
                  OneLine(samples->layer), OneLine(SamplesAttribute(*samples))));
  Drop(Aov::kSamples, layout);
}

void DecideSecondMoments(const ExrImage& image, AovLayout* layout) {
  if (layout->renderer != "stillray" || layout->from_colour ||
      layout->Find(Aov::kSamples) == nullptr) {
    return;
  }
  for (int k = 0; k < kSignalKindCount; ++k) {
    const std::string_view light = SignalName(static_cast<SignalKind>(k));
    const bool is_read =
        std::any_of(layout->sources.begin(), layout->sources.end(),
                    [&](const AovSource& source) { return AovName(source.aov) == light; });
    const std::string name = fmt::format("{}.second_moment.X", light);
    const Channel* moment = is_read ? image.Find(name) : nullptr;
    if (moment != nullptr && moment->type != PixelType::kUint32) {
      layout->second_moments[static_cast<size_t>(k)] = name;
    }
  }
}

}  // namespace stillray::io
