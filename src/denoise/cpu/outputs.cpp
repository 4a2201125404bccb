// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "denoise/cpu/outputs.h"

#include <algorithm>

#include <fmt/format.h>

#include "denoise/copy_image.h"

namespace stillray {

bool FrameOutputs::Wants(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

void FrameOutputs::KeepPlane(const char* kind, const SignalGroup& signal, const Image1& plane) {
  if (!any()) {
    return;
  }
  const std::string name = fmt::format("{}.{}", kind, signal.name);
  if (Wants(name)) {
    Image1 copy(plane.width(), plane.height());
    for (int y = 0; y < plane.height(); ++y) {
      std::copy_n(plane.Row(y), plane.width(), copy.Row(y));
    }
    out_->images.push_back({name, {std::move(copy)}});
  }
}

void FrameOutputs::KeepLight(const char* kind, const SignalGroup& signal, const LumaImage3& light) {
  if (!any()) {
    return;
  }
  const std::string name = fmt::format("{}.{}", kind, signal.name);
  if (Wants(name)) {
    Image3 copy(light.width(), light.height());
    const SignalLight whole = {&light, AlbedoSum()};
    stages_.remodulate({&whole, 1}, {}, {demodulate_.luminance_rec601 != 0, /*add=*/false}, &copy);
    out_->images.push_back({name, {copy[0], copy[1], copy[2]}});
  }
}

void FrameOutputs::KeepPicture(const char* name, const Image3& picture) {
  if (Wants(name)) {
    out_->images.push_back({name, {picture[0], picture[1], picture[2]}});
  }
}

void FrameOutputs::AddToPicture(const std::string& name, const LumaImage3& light,
                                const AlbedoSum& albedo, Image3* scratch) {
  const bool compressed = demodulate_.firefly == static_cast<int>(Firefly::kCompress);
  LumaImage3 expanded;
  if (compressed) {
    expanded.channel.swap(scratch->channel);
    CopyImage(light, &expanded);
    stages_.expand_light(&expanded);
  }
  auto sum = std::find_if(sums_.begin(), sums_.end(),
                          [&](const auto& known) { return known.first == name; });
  if (sum == sums_.end()) {
    sum = sums_.emplace(sums_.end(), name, Image3(light.width(), light.height()));
  }
  const SignalLight part = {compressed ? &expanded : &light, albedo};
  stages_.remodulate({&part, 1}, {}, {demodulate_.luminance_rec601 != 0, /*add=*/true},
                     &sum->second);
  if (compressed) {
    scratch->channel.swap(expanded.channel);
  }
}

void FrameOutputs::AddUnfiltered(std::span<const Image3* const> unfiltered) {
  for (auto& [name, sum] : sums_) {
    stages_.remodulate({}, unfiltered, {demodulate_.luminance_rec601 != 0, /*add=*/true}, &sum);
  }
}

void FrameOutputs::Finish() {
  for (auto& [name, sum] : sums_) {
    out_->images.push_back({name, {std::move(sum[0]), std::move(sum[1]), std::move(sum[2])}});
  }
  sums_.clear();
}

}  // namespace stillray
