// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds invalid values (NaN, infinity, negative radiance, confidence outside 0 to 1), and missing
// layers.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/negative_limit.h"
#include "doctor/check.h"
#include "io/lossy.h"
#include "io/text.h"

namespace stillray::doctor {
namespace {

/// The positions of invalid values of one kind.
struct Places {
  std::vector<int64_t> frames;
  int64_t count = 0;
  std::string layer;  ///< of the first position
  int64_t frame = 0;
  int x = 0;
  int y = 0;
  float value = 0;

  void Add(const Exhibit& now, const std::string& name, int px, int py, float v) {
    if (count++ == 0) {
      layer = name;
      frame = now.number;
      x = px;
      y = py;
      value = v;
    }
    if (frames.empty() || frames.back() != now.number) {
      frames.push_back(now.number);
    }
  }
  std::string Text() const {
    return fmt::format("{} values in {}; the first in {} of frame {} at x {}, y {}", count,
                       FrameRanges(frames), io::OneLine(layer), frame, x, y);
  }
};

bool IsLight(Aov aov) {
  return aov == Aov::kColour || aov >= Aov::kDirectDiffuse;
}

/// The lower limit of radiance in a layer: the denoiser's limit for rounding, relative to the layer
/// or to all radiance of the frame; in lossy layers the ringing of the compression.
float NegativeLimit(const Exhibit& now, const AovSource& source, const Channel& channel,
                    float of_frame) {
  float limit = std::max(of_frame, NegativeLimitOf(StoredColour(now, source.aov)));
  for (int y = 0; io::IsLossy(*now.image, channel) && y < channel.values.height(); ++y) {
    const float* row = channel.values.Row(y);
    for (int x = 0; x < channel.values.width(); ++x) {
      limit = std::isfinite(row[x]) ? std::max(limit, io::kRinging * row[x]) : limit;
    }
  }
  return limit;
}

class DamageCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  /// \param limit  magnitude of the lowest valid radiance, >= 0
  void LookAt(const Exhibit& now, const AovSource& source, const Channel& channel, float limit);

  int64_t frames_ = 0;
  Places broken_;
  Places negative_;
  Places out_of_range_;
};

void DamageCheck::LookAt(const Exhibit& now, const AovSource& source, const Channel& channel,
                         float limit) {
  const bool depth = source.aov == Aov::kDepth || source.aov == Aov::kReflectionDepth ||
                     source.aov == Aov::kRefractionDepth || source.aov == Aov::kHitDistance;
  const bool light = IsLight(source.aov);
  for (int y = 0; y < channel.values.height(); ++y) {
    const float* row = channel.values.Row(y);
    for (int x = 0; x < channel.values.width(); ++x) {
      // Infinite depth is the background, and an infinite hit distance the sky.
      if (std::isnan(row[x]) || (std::isinf(row[x]) && !depth)) {
        broken_.Add(now, channel.name, x, y, row[x]);
      } else if (light && row[x] < -limit) {
        negative_.Add(now, channel.name, x, y, row[x]);
      } else if (source.aov == Aov::kConfidence && (row[x] < 0 || row[x] > 1)) {
        out_of_range_.Add(now, channel.name, x, y, row[x]);
      }
    }
  }
}

void DamageCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  ++frames_;
  const float of_frame = NegativeLimitOf(now.frame, /*sparse=*/false);
  for (const AovSource& source : now.layout->sources) {
    // The bits of a hash form any float.
    if (source.aov == Aov::kCryptomatte || source.aov == Aov::kResult) {
      continue;
    }
    for (const std::string& name : source.channels) {
      const Channel* channel = now.image->Find(name);
      if (channel != nullptr && channel->type != PixelType::kUint32) {
        LookAt(now, source, *channel,
               IsLight(source.aov) ? NegativeLimit(now, source, *channel, of_frame) : 0.0f);
      }
    }
  }
}

void DamageCheck::Conclude(Verdict* verdict) {
  verdict->Add(Measure{"not_finite_values", static_cast<double>(broken_.count), 0,
                       broken_.count > 0, frames_});
  verdict->Add(Measure{"negative_values", static_cast<double>(negative_.count), 0,
                       negative_.count > 0, frames_});
  verdict->Add(Measure{"confidence_out_of_range", static_cast<double>(out_of_range_.count), 0,
                       out_of_range_.count > 0, frames_});
  if (broken_.count > 0) {
    verdict->Add(Finding{
        "not_finite", broken_.frames,
        fmt::format("NaN or infinite: {} ({}); expected none", broken_.Text(), broken_.value),
        "find the material or light that makes them and render these frames again; stillray "
        "denoise "
        "leaves such pixels out and fills them from their neighbours",
        static_cast<double>(broken_.count), 0, ""});
  }
  if (negative_.count > 0) {
    verdict->Add(Finding{
        "negative_light", negative_.frames,
        fmt::format("light below zero: {} ({:.4g}); expected none", negative_.Text(),
                    negative_.value),
        "write scene-linear light, not a difference, and use a pixel filter without negative lobes "
        "(Box or Blackman-Harris, not Mitchell or sinc); such pixels are left out",
        static_cast<double>(negative_.count), 0, ""});
  }
  if (out_of_range_.count > 0) {
    verdict->Add(Finding{
        "confidence_range", out_of_range_.frames,
        fmt::format(
            "confidence outside 0 to 1: {} ({:.4g}); expected 1 where the light of the last "
            "frame still holds, 0 where it does not",
            out_of_range_.Text(), out_of_range_.value),
        "divide it by its largest value; such values are clamped",
        static_cast<double>(out_of_range_.count), 0, ""});
  }
}

/// Finds missing layers that would improve the denoiser's result.
class MissingLayersCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  const AovLayout* layout_ = nullptr;
  std::vector<int64_t> frames_;
};

void MissingLayersCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  frames_.push_back(now.number);
}

/// The setting that enables the pass in Blender.
std::string SettingFor(const AovLayout& layout, const char* blender, const char* other) {
  return layout.renderer == "blender"
             ? fmt::format("switch on {} in View Layer Properties > Passes", blender)
             : fmt::format("write {}, or name its layer with --aov", other);
}

void MissingLayersCheck::Conclude(Verdict* verdict) {
  if (layout_ == nullptr) {
    return;
  }
  const auto missing = [&](const char* name, const std::string& what, const std::string& cure) {
    verdict->Add(Finding{name, frames_, what, cure, 0, 1, ""});
  };
  if (!layout_->other_view_layers.empty()) {
    const std::string others =
        io::OneLine(fmt::format("{}", fmt::join(layout_->other_view_layers, ", ")));
    missing(
        "view_layer_left",
        fmt::format("of several view layers only {} would be denoised, {} not",
                    io::OneLine(layout_->view_layer), others),
        fmt::format("run check and denoise once for each, with --view-layer '{}' and so on, each "
                    "on the files that the one before wrote",
                    io::OneLine(layout_->other_view_layers.front())));
  }
  if (layout_->single_layer) {
    missing(
        "single_layer",
        "the files hold the picture alone, without passes: every frame would be denoised on its "
        "own, and textures would lose detail",
        layout_->renderer == "blender"
            ? "choose OpenEXR MultiLayer, not OpenEXR, in Output Properties > Output > File "
              "Format, and switch on the passes of docs/inputs.md"
            : "write the light passes and guides as layers of the same files");
    return;
  }
  if (layout_->from_colour) {
    missing(
        "passes_missing",
        "the colour alone is there, without light passes: all light would be filtered as one, "
        "and reflections keep less detail",
        SettingFor(*layout_,
                   "Light > Diffuse, Glossy and Transmission (Direct, Indirect, Color of each), "
                   "Emission and Environment",
                   "direct and indirect diffuse, specular and transmitted light"));
  }
  if (layout_->Find(Aov::kMotion) == nullptr && frames_.size() > 1) {
    missing("motion_missing",
            "no layer of motion was found: stillray denoise derives it from cameras and guides as "
            "far as these tell (--motion auto)",
            SettingFor(*layout_, "Data > Vector (and motion blur off)",
                       "motion to the previous frame"));
  }
  if (layout_->Find(Aov::kDepth) == nullptr) {
    missing("depth_missing",
            "no layer of depth was found: only normals and light stop the filter at edges",
            SettingFor(*layout_, "Data > Z", "linear depth"));
  }
  if (layout_->Find(Aov::kNormal) == nullptr) {
    missing("normal_missing",
            "no layer of normals was found: only depth and light stop the filter at edges",
            SettingFor(*layout_, "Data > Normal", "world-space normals"));
  }
  if (layout_->Find(Aov::kAlbedo) == nullptr && layout_->Find(Aov::kFallbackAlbedo) == nullptr) {
    missing("albedo_missing",
            "no layer of albedo was found: textures are filtered with the light and lose detail",
            SettingFor(*layout_, "Light > Diffuse > Color", "the diffuse reflectance"));
  }
}

}  // namespace

std::unique_ptr<Check> MakeDamageCheck() {
  return std::make_unique<DamageCheck>();
}

std::unique_ptr<Check> MakeMissingLayersCheck() {
  return std::make_unique<MissingLayersCheck>();
}

}  // namespace stillray::doctor
