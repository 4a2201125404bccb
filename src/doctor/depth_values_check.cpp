// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds depth that is wrong for any surface: constant, not positive, or between 0 and 1; and finite
// depth of the background.
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

/// Fraction of pixels; single ones may be wrong.
constexpr double kNotPositive = 0.005;
constexpr double kBackground = 0.005;
/// Background has a single value; pixels without a normal for other reasons have many.
constexpr double kOneValue = 0.9;
constexpr double kAgreement = 0.7;

struct Values {
  int64_t number = 0;
  float least = 0;  ///< stored, finite
  float largest = 0;
  double not_positive = 0;  ///< fraction of pixels, after conversion
  double no_surface = 0;    ///< fraction of pixels without a normal, but with finite depth
  double one_value = 0;     ///< fraction of these with the most frequent stored value
  float value = 0;          ///< that value
  float farthest = 0;       ///< stored on surfaces
};

bool HasSurface(const Exhibit& now) {
  if (now.layout->Find(Aov::kNormal) == nullptr) {
    return false;
  }
  int64_t surfaces = 0;
  for (int y = 0; y < now.frame.height; ++y) {
    for (int x = 0; x < now.frame.width; ++x) {
      surfaces += !IsZeroNormal(now.frame.guides.normal, x, y);
    }
  }
  return static_cast<double>(surfaces) > kBackground * now.frame.width * now.frame.height;
}

class DepthValuesCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  bool ConcludeBackground(Verdict* verdict) const;
  std::vector<int64_t> Frames(bool (*bad)(const Values&)) const;
  bool Enough(const std::vector<int64_t>& frames) const {
    return !frames.empty() &&
           static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(frames_.size());
  }

  const AovLayout* layout_ = nullptr;
  std::vector<Values> frames_;
};

void DepthValuesCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  if (layout_->Find(Aov::kDepth) == nullptr) {
    return;
  }
  const Image1 stored = StoredPlane(now, Aov::kDepth, 0);
  const bool has_normal = layout_->Find(Aov::kNormal) != nullptr;
  Values v;
  v.number = now.number;
  bool first = true;
  int64_t bad = 0;
  int64_t empty = 0;
  std::map<float, int64_t> counts;
  for (int y = 0; y < now.frame.height; ++y) {
    for (int x = 0; x < now.frame.width; ++x) {
      const float s = stored(x, y);
      if (!std::isfinite(s) || !std::isfinite(now.frame.guides.depth(x, y))) {
        continue;
      }
      v.least = first ? s : std::min(v.least, s);
      v.largest = first ? s : std::max(v.largest, s);
      first = false;
      if (has_normal && IsZeroNormal(now.frame.guides.normal, x, y)) {
        ++empty;
        ++counts[s];
        continue;
      }
      v.farthest = std::max(v.farthest, s);
      bad += !(now.frame.guides.depth(x, y) > 0);
    }
  }
  const double pixels = static_cast<double>(now.frame.width) * now.frame.height;
  v.not_positive = static_cast<double>(bad) / pixels;
  v.no_surface = static_cast<double>(empty) / pixels;
  for (const auto& [value, count] : counts) {
    const double part = static_cast<double>(count) / static_cast<double>(empty);
    if (part > v.one_value) {
      v.one_value = part;
      v.value = value;
    }
  }
  if (first && HasSurface(now)) {
    // No depth at all, although normals show surfaces.
    v.least = v.largest = stored(0, 0);
    first = false;
  }
  if (!first) {
    frames_.push_back(v);
  }
}

std::vector<int64_t> DepthValuesCheck::Frames(bool (*bad)(const Values&)) const {
  std::vector<int64_t> frames;
  for (const Values& v : frames_) {
    if (bad(v)) {
      frames.push_back(v.number);
    }
  }
  return frames;
}

bool DepthValuesCheck::ConcludeBackground(Verdict* verdict) const {
  const std::vector<int64_t> frames = Frames([](const Values& v) {
    return v.no_surface > kBackground && v.no_surface < 1 && v.one_value > kOneValue &&
           v.largest > v.least;
  });
  double part = 0;
  float value = 0;
  float farthest = 0;
  for (const Values& v : frames_) {
    part = std::max(part, v.one_value > kOneValue ? v.no_surface : 0.0);
    value = std::max(value, v.value);
    farthest = std::max(farthest, v.farthest);
  }
  const bool broken = Enough(frames);
  verdict->Add(Measure{"background_finite", part, kBackground, broken,
                       static_cast<int64_t>(frames_.size())});
  if (!broken) {
    return false;
  }
  Finding f{
      "background_finite",
      frames,
      fmt::format("depth in {} is {:.6g} where there is no surface (no normal): up to {:.1f} % "
                  "of the pixels in {}; expected infinity or at least {:.3g}",
                  LayerText(*layout_, Aov::kDepth), value, 100 * part, FrameRanges(frames),
                  layout_->depth.background),
      "write a very large depth (1e10) for the background",
      part,
      kBackground,
      ""};
  if (value > farthest && layout_->depth.kind == DepthKind::kLinear) {
    f.aov = MappingText(*layout_, Aov::kDepth,
                        fmt::format("linear,background={:.6g}", 0.5 * (value + farthest)));
    f.cure = MappingCure(f.aov);
  }
  verdict->Add(f);
  return true;
}

void DepthValuesCheck::Conclude(Verdict* verdict) {
  if (frames_.empty() || verdict->Has("depth_")) {
    return;
  }
  const auto count = static_cast<int64_t>(frames_.size());
  const std::vector<int64_t> constant =
      Frames([](const Values& v) { return v.largest == v.least; });
  verdict->Add(
      Measure{"depth_constant", static_cast<double>(constant.size()), 0, Enough(constant), count});
  const std::string name = LayerText(*layout_, Aov::kDepth);
  if (Enough(constant)) {
    verdict->Add(Finding{
        "depth_constant", constant,
        fmt::format("depth in {} is {:.6g} everywhere in {}; expected distances", name,
                    frames_.front().largest, FrameRanges(constant)),
        "render the depth pass again (a render split by sample offset lacks it), or leave it out: "
        "stillray denoise with --aov depth=none",
        0, 0, "depth=none"});
    return;
  }
  const std::vector<int64_t> within =
      Frames([](const Values& v) { return v.least >= 0 && v.least < 0.999f && v.largest == 1.0f; });
  const bool linear = layout_->depth.kind == DepthKind::kLinear;
  verdict->Add(
      Measure{"depth_largest", frames_.front().largest, 1, linear && Enough(within), count});
  if (linear && Enough(within)) {
    const std::string mapping = MappingText(*layout_, Aov::kDepth, "normalised,far=1");
    verdict->Add(Finding{
        "depth_normalised", within,
        fmt::format("depth in {} runs from {:.4g} to exactly 1 in {}; expected distances in scene "
                    "units",
                    name, frames_.front().least, FrameRanges(within)),
        MappingCure(mapping) + " (with the true near= and far= if 0 is not at the camera)", 1, 1,
        mapping});
    return;
  }
  if (ConcludeBackground(verdict)) {
    return;
  }
  const std::vector<int64_t> negative =
      Frames([](const Values& v) { return v.not_positive > kNotPositive; });
  double part = 0;
  for (const Values& v : frames_) {
    part = std::max(part, v.not_positive);
  }
  verdict->Add(Measure{"depth_not_positive", part, kNotPositive, !negative.empty(), count});
  if (!negative.empty()) {
    verdict->Add(
        Finding{"depth_negative", negative,
                fmt::format("depth in {} is zero or negative in up to {:.1f} % of the pixels "
                            "in {} (least {:.4g}); expected above zero",
                            name, 100 * part, FrameRanges(negative), frames_.front().least),
                "write the distance from the camera along its viewing axis, positive in "
                "front of it",
                part, kNotPositive, ""});
  }
}

}  // namespace

std::unique_ptr<Check> MakeDepthValuesCheck() {
  return std::make_unique<DepthValuesCheck>();
}

}  // namespace stillray::doctor
