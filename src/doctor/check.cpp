// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "doctor/check.h"

#include <fmt/format.h>

#include "io/text.h"

namespace stillray::doctor {

std::string LayerText(const AovLayout& layout, Aov aov) {
  const AovSource* source = layout.Find(aov);
  if (source == nullptr) {
    return AovName(aov);
  }
  return source->layer.empty() ? "the main picture" : io::OneLine(source->layer, 100);
}

std::string MappingText(const AovLayout& layout, Aov aov, const std::string& words) {
  const AovSource* source = layout.Find(aov);
  std::string text = fmt::format("{}={}", AovName(aov), source == nullptr ? "" : source->layer);
  std::string tight = words;
  std::erase(tight, ' ');
  return tight.empty() ? text : text + "," + tight;
}

std::string MappingCure(const std::string& mapping) {
  return fmt::format("stillray denoise with --aov '{}'", io::OneLine(mapping));
}

double MeanLight(const Exhibit& exhibit) {
  const Image1& light = exhibit.light;
  double sum = 0;
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) {
      sum += light(x, y);
    }
  }
  return sum / (static_cast<double>(light.width()) * light.height());
}

Image1 StoredPlane(const Exhibit& exhibit, Aov aov, size_t component) {
  const AovSource* source = exhibit.layout->Find(aov);
  if (source == nullptr || component >= source->channels.size()) {
    return {};
  }
  const Channel* channel = exhibit.image->Find(source->channels[component]);
  if (channel == nullptr) {
    return {};
  }
  if (channel->type != PixelType::kUint32) {
    return channel->values;
  }
  Image1 values(exhibit.image->width, exhibit.image->height);
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      values(x, y) = static_cast<float>(channel->integers(x, y));
    }
  }
  return values;
}

Image3 StoredColour(const Exhibit& exhibit, Aov aov) {
  Image3 image;
  for (int c = 0; c < 3; ++c) {
    image[c] = StoredPlane(exhibit, aov, static_cast<size_t>(c));
  }
  return image;
}

}  // namespace stillray::doctor
