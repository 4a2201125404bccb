// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds radiance that was clamped at a maximum, or tone-mapped to values below 1.
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "doctor/check.h"
#include "doctor/warp.h"
#include "io/text.h"

namespace stillray::doctor {
namespace {

/// Fraction of the values that equal the maximum. In unclamped noise a single value equals it,
/// except where radiance is naturally constant (see below).
constexpr double kPileUp = 5e-4;
constexpr int64_t kLeastValues = 20;
/// Of the pixels at the maximum, the fraction with a darker, nonzero neighbour on the same surface:
/// small for constant radiance (a sunlit floor), large for clamped noise.
constexpr double kSpeckled = 0.3;
/// Renderers clamp fireflies of indirect light (Blender at 10), which is no fault.
constexpr float kFireflies = 5.0f;
constexpr float kLittle = 1e-3f;
constexpr float kNearly = 0.98f;
/// Tone-mapped values come close to 1 in every frame and never exceed it.
constexpr float kCloseToOne = 0.9f;
constexpr int64_t kLeastFrames = 3;
constexpr double kAgreement = 0.7;

constexpr Aov kLights[] = {
    Aov::kColour,
    Aov::kDirectDiffuse,
    Aov::kIndirectDiffuse,
    Aov::kDirectSpecular,
    Aov::kIndirectSpecular,
    Aov::kDirectTransmission,
    Aov::kIndirectTransmission,
};

/// One layer in one frame.
struct Peak {
  int64_t number = 0;
  float maximum = 0;
  int64_t values = 0;   ///< in all channels that have it
  double piled = 0;     ///< fraction of the pixels of a channel that have it
  double speckled = 0;  ///< fraction of these with a darker neighbour on the same surface
  bool many_albedos = false;
  double noise = 0;  ///< mean difference of neighbours over mean light
};

/// Radiance with naturally frequent values: sky, and visible lamps.
bool IsUnfiltered(const Frame& frame, int x, int y) {
  if (!std::isfinite(frame.guides.depth(x, y))) {
    return true;
  }
  for (int c = 0; c < 3; ++c) {
    if ((!frame.emission.empty() && frame.emission[c](x, y) > 0) ||
        (!frame.background.empty() && frame.background[c](x, y) > 0)) {
      return true;
    }
  }
  return false;
}

bool SameSurface(const Guides& g, int x, int y, int other_x, int other_y) {
  float difference = 0;
  for (int c = 0; c < 3; ++c) {
    difference += std::fabs(g.normal[c](x, y) - g.normal[c](other_x, other_y)) +
                  std::fabs(g.albedo[c](x, y) - g.albedo[c](other_x, other_y));
  }
  return difference < 0.02f;
}

Peak PeakOf(const Exhibit& now, const Image3& light) {
  const Frame& f = now.frame;
  Peak peak;
  peak.number = now.number;
  const auto usable = [&](int x, int y) { return !IsUnfiltered(f, x, y); };
  int64_t count = 0;
  double sum = 0;
  double change = 0;
  for (int y = 0; y < f.height; ++y) {
    for (int x = 0; x < f.width; ++x) {
      for (int c = 0; c < 3 && usable(x, y); ++c) {
        const float v = light[c](x, y);
        if (std::isfinite(v)) {
          peak.maximum = std::max(peak.maximum, v);
          sum += v;
          ++count;
          if (x > 0 && std::isfinite(light[c](x - 1, y))) {
            change += std::fabs(v - light[c](x - 1, y));
          }
        }
      }
    }
  }
  if (count == 0 || peak.maximum <= 0) {
    return peak;
  }
  peak.noise = change / std::max(sum, 1e-30);
  int64_t piled = 0;
  int64_t speckled = 0;
  std::map<int, int64_t> albedos;
  for (int y = 1; y + 1 < f.height; ++y) {
    for (int x = 1; x + 1 < f.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        if (light[c](x, y) != peak.maximum || !usable(x, y)) {
          continue;
        }
        ++piled;
        const float albedo = f.guides.albedo[c](x, y);
        albedos[std::isfinite(albedo) ? static_cast<int>(32 * std::clamp(albedo, 0.0f, 1.0f))
                                      : 0]++;
        const auto darker = [&](int px, int py) {
          const float v = light[c](px, py);
          return v > kLittle * peak.maximum && v < kNearly * peak.maximum &&
                 SameSurface(f.guides, x, y, px, py);
        };
        speckled += darker(x - 1, y) || darker(x + 1, y) || darker(x, y - 1) || darker(x, y + 1);
      }
    }
  }
  peak.values = piled;
  peak.piled = static_cast<double>(piled) / static_cast<double>(count);
  peak.speckled = piled == 0 ? 0 : static_cast<double>(speckled) / static_cast<double>(piled);
  peak.many_albedos = std::count_if(albedos.begin(), albedos.end(), [&](const auto& entry) {
                        return entry.second * 20 >= piled;
                      }) >= 2;
  return peak;
}

class RangeCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  bool IsClamped(const Peak& peak, Aov aov) const;
  void ConcludeClamp(Verdict* verdict) const;
  void ConcludeToneMap(Verdict* verdict) const;

  const AovLayout* layout_ = nullptr;
  int64_t frames_ = 0;
  std::map<Aov, std::vector<Peak>> peaks_;
  float sky_ = 0;  ///< the largest radiance of the background
};

void RangeCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  ++frames_;
  const Image3 all = SumOfLight(now.frame);
  for (int y = 0; y < now.frame.height; ++y) {
    for (int x = 0; x < now.frame.width; ++x) {
      const bool sky = !std::isfinite(now.frame.guides.depth(x, y));
      for (int c = 0; c < 3; ++c) {
        const float v = sky                            ? all[c](x, y)
                        : now.frame.background.empty() ? 0.0f
                                                       : now.frame.background[c](x, y);
        sky_ = std::isfinite(v) ? std::max(sky_, v) : sky_;
      }
    }
  }
  for (const Aov aov : kLights) {
    if (layout_->Find(aov) == nullptr) {
      continue;
    }
    peaks_[aov].push_back(PeakOf(now, StoredColour(now, aov)));
  }
}

/// Under a uniform sky, undivided light reaches the sky's radiance times the largest albedo
/// wherever the sky is unoccluded, and divided light the sky's radiance: neither is a clamp.
bool RangeCheck::IsClamped(const Peak& peak, Aov aov) const {
  const bool divided = layout_->light_is_divided && aov != Aov::kColour;
  const bool indirect = aov == Aov::kIndirectDiffuse || aov == Aov::kIndirectSpecular ||
                        aov == Aov::kIndirectTransmission;
  if (indirect && peak.maximum >= kFireflies) {
    return false;
  }
  return peak.values >= kLeastValues && peak.piled >= kPileUp && peak.speckled >= kSpeckled &&
         peak.maximum > 1.02f * sky_ && (divided || peak.many_albedos);
}

void RangeCheck::ConcludeClamp(Verdict* verdict) const {
  std::vector<std::string> layers;
  std::vector<int64_t> frames;
  double worst = 0;
  float value = 0;
  for (const auto& [aov, peaks] : peaks_) {
    std::vector<int64_t> clamped;
    bool same = true;
    double piled = 0;
    for (const Peak& peak : peaks) {
      if (IsClamped(peak, aov)) {
        clamped.push_back(peak.number);
        same = same && peak.maximum == peaks.front().maximum;
        piled = std::max(piled, peak.piled);
      }
    }
    if (same &&
        static_cast<double>(clamped.size()) >= kAgreement * static_cast<double>(peaks.size())) {
      layers.push_back(LayerText(*layout_, aov));
      frames = clamped.size() > frames.size() ? clamped : frames;
      value = peaks.front().maximum;
      worst = std::max(worst, piled);
    }
    double least = 0;
    for (const Peak& peak : peaks) {
      least = std::max(least, IsClamped(peak, aov) ? peak.piled : 0);
    }
    verdict->Add(Measure{fmt::format("pile_up_{}", AovName(aov)), least, kPileUp,
                         !clamped.empty() && layers.size() > 0, frames_});
  }
  if (layers.empty()) {
    return;
  }
  verdict->Add(Finding{
      "light_clamped", frames,
      fmt::format("light is cut off: in {}, {:.2g} % of the values of {}{} are exactly the maximum "
                  "{:.4g} (expected below {} %)",
                  FrameRanges(frames), 100 * worst, io::OneLine(layers.front(), 100),
                  layers.size() > 1 ? fmt::format(" (and of {} more)", layers.size() - 1) : "",
                  value, 100 * kPileUp),
      "write scene-linear EXR from the renderer itself (no 8-bit or display format on the way, no "
      "view transform) and raise or switch off its clamp on light",
      worst, kPileUp, ""});
}

void RangeCheck::ConcludeToneMap(Verdict* verdict) const {
  float above = 0;
  const std::vector<Peak>* compressed = nullptr;
  Aov which = Aov::kColour;
  for (const auto& [aov, peaks] : peaks_) {
    bool all = static_cast<int64_t>(peaks.size()) >= kLeastFrames;
    for (const Peak& peak : peaks) {
      above = std::max(above, peak.maximum);
      // Unclamped noise does not reach the same maximum in every frame, and constant radiance is
      // not noise.
      all = all && peak.maximum >= kCloseToOne && peak.maximum <= 1 && peak.noise > 0.2 &&
            peak.maximum > 1.02f * sky_ && peak.piled < kPileUp;
    }
    if (all && compressed == nullptr) {
      compressed = &peaks;
      which = aov;
    }
  }
  verdict->Add(Measure{"largest_light", above, 1, compressed != nullptr && above <= 1, frames_});
  if (compressed == nullptr || above > 1 || verdict->Has("light_")) {
    return;
  }
  std::vector<int64_t> frames;
  for (const Peak& peak : *compressed) {
    frames.push_back(peak.number);
  }
  verdict->Add(Finding{
      "light_tone_mapped", frames,
      fmt::format(
          "light is compressed: the maximum of {} lies between {:.1f} and 1 in every one of "
          "{} frames and never above (largest {:.4g}; noise without a limit varies)",
          LayerText(*layout_, which), kCloseToOne, frames.size(), above),
      "write scene-linear light: no tone mapping, film curve or view transform before the EXR file",
      above, 1, ""});
}

void RangeCheck::Conclude(Verdict* verdict) {
  if (layout_ == nullptr) {
    return;
  }
  ConcludeClamp(verdict);
  ConcludeToneMap(verdict);
}

}  // namespace

std::unique_ptr<Check> MakeRangeCheck() {
  return std::make_unique<RangeCheck>();
}

}  // namespace stillray::doctor
