// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds layers that were compressed with loss.
#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "doctor/check.h"
#include "io/lossy.h"

namespace stillray::doctor {
namespace {

/// Maximum number of layers named in the message; further layers are counted.
constexpr size_t kNamed = 4;

class LossyCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  const AovLayout* layout_ = nullptr;
  int64_t seen_ = 0;
  std::vector<int64_t> frames_;
  std::vector<std::string> layers_;  ///< in the order of the layout
  std::string codec_;
};

bool IsLossy(const Exhibit& now, const AovSource& source) {
  return std::any_of(source.channels.begin(), source.channels.end(), [&](const std::string& name) {
    const Channel* channel = now.image->Find(name);
    return channel != nullptr && io::IsLossy(*now.image, *channel);
  });
}

void LossyCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  ++seen_;
  bool any = false;
  for (const AovSource& source : now.layout->sources) {
    if (source.aov == Aov::kResult || !IsLossy(now, source)) {
      continue;
    }
    any = true;
    const std::string layer = LayerText(*now.layout, source.aov);
    if (std::find(layers_.begin(), layers_.end(), layer) == layers_.end()) {
      layers_.push_back(layer);
    }
  }
  if (any) {
    frames_.push_back(now.number);
    codec_ = now.image->compression_name;
    std::transform(codec_.begin(), codec_.end(), codec_.begin(), [](char c) {
      return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    });
  }
}

void LossyCheck::Conclude(Verdict* verdict) {
  const auto count = static_cast<double>(layers_.size());
  verdict->Add(Measure{"lossy_layers", count, 0, !layers_.empty(), seen_});
  if (layers_.empty()) {
    return;
  }
  const size_t named = std::min(kNamed, layers_.size());
  const std::vector<std::string> names(layers_.begin(),
                                       layers_.begin() + static_cast<std::ptrdiff_t>(named));
  const std::string more =
      layers_.size() > named ? fmt::format(" and {} more", layers_.size() - named) : "";
  verdict->Add(Finding{
      "lossy_compression", frames_,
      fmt::format(
          "{} {} compressed with {}, which is lossy, in {}: {}{}; expected a lossless codec",
          layers_.size(), layers_.size() == 1 ? "layer is" : "layers are", codec_,
          FrameRanges(frames_), fmt::join(names, ", "), more),
      layout_->renderer == "blender"
          ? "set Output Properties > Output > Codec to ZIP (image_settings.exr_codec = 'ZIP') and "
            "render again: lossy codecs ring below zero beside bright samples and change guides"
          : "write the layers with ZIP, ZIPS or PIZ and render again: lossy codecs ring below zero "
            "beside bright samples and change guides",
      count, 0, ""});
}

}  // namespace

std::unique_ptr<Check> MakeLossyCheck() {
  return std::make_unique<LossyCheck>();
}

}  // namespace stillray::doctor
