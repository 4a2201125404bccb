// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Checks whether stored normals are unit vectors, or encoded in 0..1.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/median.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 60000;
/// Tolerance of the length: encodings of 8 bits err by 0.01.
constexpr float kUnit = 0.04f;
constexpr float kZero = 1e-3f;
/// Fractions of the surface pixels. Clean: unit length above 0.99 at one sample, 0.9 at more (edges
/// are averages); the other encoding below 0.1.
constexpr double kMost = 0.8;
constexpr double kFew = 0.4;
/// Tolerance of the median length; averages within pixels shorten a few normals, not half of them.
constexpr double kMedianOff = 0.06;
/// Minimum fraction of lengths near a median below 1: normals of hair are means over a pixel's
/// samples, of all lengths up to 1, while a wrong scale makes all lengths equal.
constexpr double kAlike = 0.5;
/// Fraction of the surfaces without a normal.
constexpr double kMayBeZero = 0.3;

float Length(float x, float y, float z) {
  return std::sqrt(x * x + y * y + z * z);
}

struct Lengths {
  int64_t number = 0;
  double unit = 0;     ///< fraction of the normals of unit length as stored
  double encoded = 0;  ///< fraction that is of unit length once decoded
  double median = 0;   ///< length as stored
  double alike = 0;    ///< fraction of the lengths that are near the median
  double zero = 0;     ///< fraction of the surfaces
};

class NormalCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  bool Report(Verdict* verdict, const char* name, bool (*bad)(const Lengths&),
              double (*figure)(const Lengths&), double limit, const char* what,
              const std::string& cure, const std::string& aov) const;

  const AovLayout* layout_ = nullptr;
  std::vector<Lengths> frames_;
};

void NormalCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  if (layout_->Find(Aov::kNormal) == nullptr) {
    return;
  }
  const Image3 n = StoredColour(now, Aov::kNormal);
  // The import sets the depth of volumes, but their pixels have no normal.
  const Image1 depth = layout_->Find(Aov::kDepth) != nullptr
                           ? ConvertDepth(StoredPlane(now, Aov::kDepth, 0), layout_->depth)
                           : now.frame.guides.depth;
  const int step = SampleStep(now.frame.width, now.frame.height, kSamples);
  std::vector<float> lengths;
  int64_t surfaces = 0;
  int64_t unit = 0;
  int64_t encoded = 0;
  for (int y = step / 2; y < now.frame.height; y += step) {
    for (int x = step / 2; x < now.frame.width; x += step) {
      const float length = Length(n[0](x, y), n[1](x, y), n[2](x, y));
      if (!std::isfinite(depth(x, y)) || !std::isfinite(length)) {
        continue;
      }
      ++surfaces;
      if (length < kZero) {
        continue;
      }
      lengths.push_back(length);
      unit += std::fabs(length - 1) < kUnit;
      const float decoded = Length(2 * n[0](x, y) - 1, 2 * n[1](x, y) - 1, 2 * n[2](x, y) - 1);
      encoded += std::fabs(decoded - 1) < kUnit;
    }
  }
  if (surfaces == 0) {
    return;
  }
  const auto count = std::max(1.0, static_cast<double>(lengths.size()));
  Lengths l;
  l.number = now.number;
  l.unit = static_cast<double>(unit) / count;
  l.encoded = static_cast<double>(encoded) / count;
  l.zero = 1 - static_cast<double>(lengths.size()) / static_cast<double>(surfaces);
  const float median = Median(lengths);
  l.median = median;
  l.alike = static_cast<double>(std::count_if(
                lengths.begin(), lengths.end(),
                [&](float length) { return std::fabs(length - median) < kUnit * median; })) /
            count;
  frames_.push_back(l);
}

bool NormalCheck::Report(Verdict* verdict, const char* name, bool (*bad)(const Lengths&),
                         double (*figure)(const Lengths&), double limit, const char* what,
                         const std::string& cure, const std::string& aov) const {
  std::vector<int64_t> frames;
  double mean = 0;
  double mean_bad = 0;
  for (const Lengths& l : frames_) {
    mean += figure(l);
    if (bad(l)) {
      frames.push_back(l.number);
      mean_bad += figure(l);
    }
  }
  const bool broken = !frames.empty();
  verdict->Add(Measure{name, mean / static_cast<double>(frames_.size()), limit, broken,
                       static_cast<int64_t>(frames_.size())});
  if (broken) {
    const double value = mean_bad / static_cast<double>(frames.size());
    verdict->Add(Finding{
        name, frames,
        fmt::format("normals in {} {}: {} (measured {:.2f}, expected {:.2f})",
                    LayerText(*layout_, Aov::kNormal), what, FrameRanges(frames), value, limit),
        cure, value, limit, aov});
  }
  return broken;
}

void NormalCheck::Conclude(Verdict* verdict) {
  if (frames_.empty()) {
    return;
  }
  NormalConvention other = layout_->normal;
  other.encoded = !other.encoded;
  const std::string mapping = MappingText(*layout_, Aov::kNormal, ConventionText(other));
  bool named = false;
  if (!layout_->normal.encoded) {
    named = Report(
        verdict, "normal_encoded",
        [](const Lengths& l) { return l.encoded > kMost && l.unit < kFew; },
        [](const Lengths& l) { return l.encoded; }, kFew,
        "are stored in 0 to 1: n / 2 + 1/2 has unit length for this part of the surfaces",
        MappingCure(mapping), mapping);
  } else {
    named = Report(
        verdict, "normal_not_encoded",
        [](const Lengths& l) { return l.unit > kMost && l.encoded < kFew; },
        [](const Lengths& l) { return l.unit; }, kFew,
        "are read as encoded, but have unit length as they are for this part of the surfaces",
        MappingCure(mapping), mapping);
  }
  if (named) {
    return;
  }
  const std::string cure =
      "write world-space normals of unit length (no normalisation to a range, no display format)";
  if (!Report(
          verdict, "normal_zero", [](const Lengths& l) { return l.zero > kMayBeZero; },
          [](const Lengths& l) { return l.zero; }, kMayBeZero,
          "are zero for this part of the surfaces", cure, "") &&
      !layout_->normal.encoded) {
    Report(
        verdict, "normal_length",
        [](const Lengths& l) {
          const bool off = l.zero < 1 && std::fabs(l.median - 1) > kMedianOff;
          return off && (l.median > 1 || l.alike > kAlike);
        },
        [](const Lengths& l) { return l.median; }, 1, "are not of unit length, by the median", cure,
        "");
  }
}

}  // namespace

std::unique_ptr<Check> MakeNormalCheck() {
  return std::make_unique<NormalCheck>();
}

}  // namespace stillray::doctor
