// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds motion whose convention differs from the assumed one: the previous frame, warped by the
// motion, is compared with this frame under every alternative convention (reading). The comparison
// uses guides, which do not change as a surface moves.
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "core/parallel.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 20000;
/// Minimum difference of two readings, in pixels, at compared pixels: well above the tolerance of
/// one pixel of a comparison with four neighbours.
constexpr float kApart = 1.5f;
/// Minimum fraction of the sampled pixels with that difference.
constexpr double kLeastPart = 0.01;
/// Maximum ratio of the distance of the correct reading to that of the wrong one. Clean sequences
/// measured 1.6 and more (the alternative is worse); planted faults below 0.3.
constexpr double kFarBetter = 0.55;
/// Minimum distance of a wrong reading; the noise of guides is lower.
constexpr double kLeastDistance = 0.01;
/// Fraction of the pairs of frames that must agree.
constexpr double kAgreement = 0.7;
/// Readings within this factor of the best are equivalent; the simplest of them is reported.
constexpr double kTie = 1.02;

enum class Unit : uint8_t { kSame, kFraction, kNdc, kPixels, kPixelsFromNdc };

/// An alternative interpretation of the motion, relative to the assumed one.
struct Reading {
  Unit unit = Unit::kSame;
  float scale = 1;
  bool swap = false;
  int sign_x = 1;
  int sign_y = 1;

  bool given() const {
    return unit == Unit::kSame && scale == 1 && !swap && sign_x == 1 && sign_y == 1;
  }
  /// Number of changes: of equivalent readings, the one with the fewest is chosen.
  int Steps() const {
    return (unit != Unit::kSame) * 2 + (scale != 1) * 2 + swap * 2 + (sign_x < 0 || sign_y < 0) +
           (scale == 0) * 8;
  }
};

vec2 UnitFactor(Unit unit, int width, int height) {
  const vec2 size(static_cast<float>(width), static_cast<float>(height));
  switch (unit) {
    case Unit::kSame:
      return vec2(1.0f);
    case Unit::kFraction:
      return size;
    case Unit::kNdc:
      return 0.5f * size;
    case Unit::kPixels:
      return 1.0f / size;
    case Unit::kPixelsFromNdc:
      return 2.0f / size;
  }
  return vec2(1.0f);
}

vec2 Apply(const Reading& reading, vec2 motion, int width, int height) {
  const vec2 factor = UnitFactor(reading.unit, width, height) * reading.scale;
  const vec2 m = reading.swap ? vec2(motion.y, motion.x) : motion;
  return {m.x * factor.x * static_cast<float>(reading.sign_x),
          m.y * factor.y * static_cast<float>(reading.sign_y)};
}

/// All readings: the given reading first, simple readings before others. Scales are not combined
/// with changes of axes: combinations would fit anything.
std::vector<Reading> MakeReadings(const MotionConvention& given) {
  std::vector<Reading> readings;
  std::vector<Unit> units = {Unit::kSame};
  if (given.unit == MotionUnit::kPixels) {
    units.insert(units.end(), {Unit::kNdc, Unit::kFraction});
  } else {
    units.push_back(given.unit == MotionUnit::kFraction ? Unit::kPixels : Unit::kPixelsFromNdc);
  }
  for (const Unit unit : units) {
    for (const bool swap : {false, true}) {
      for (const auto& [x, y] : {std::pair(1, 1), {-1, -1}, {1, -1}, {-1, 1}}) {
        readings.push_back({unit, 1, swap, x, y});
      }
    }
  }
  for (const float scale : {0.5f, 2.0f}) {
    for (const auto& [x, y] : {std::pair(1, 1), {-1, -1}, {1, -1}, {-1, 1}}) {
      readings.push_back({Unit::kSame, scale, false, x, y});
    }
  }
  for (const float scale : {1.0f / 3, 0.25f, 3.0f, 4.0f}) {
    readings.push_back({Unit::kSame, scale, false, 1, 1});
  }
  readings.push_back({Unit::kSame, 0, false, 1, 1});  // zero motion
  std::stable_sort(readings.begin(), readings.end(),
                   [](const Reading& a, const Reading& b) { return a.Steps() < b.Steps(); });
  return readings;
}

/// Sums of one pair of frames for one reading.
struct Sums {
  double distance = 0;       ///< over all sampled pixels
  double given_apart = 0;    ///< of the given reading, where the two differ
  double reading_apart = 0;  ///< of this reading, there
  int64_t apart = 0;

  void Add(const Sums& s) {
    distance += s.distance;
    given_apart += s.given_apart;
    reading_apart += s.reading_apart;
    apart += s.apart;
  }
};

/// One row of the samples: distances under all readings.
void MeasureRow(const Exhibit& now, const Exhibit& before, const Features& features,
                const Features& features_before, const std::vector<Reading>& readings, int y,
                int step, std::vector<Sums>* sums) {
  const Frame& frame = now.frame;
  for (int x = step / 2; x < frame.width; x += step) {
    const vec2 motion = MotionAt(frame, x, y);
    if (!std::isfinite(frame.guides.depth(x, y)) || !std::isfinite(motion.x + motion.y)) {
      continue;
    }
    float given = 0;
    for (size_t i = 0; i < readings.size(); ++i) {
      const vec2 m = Apply(readings[i], motion, frame.width, frame.height);
      const float d = features.DistanceAt(x, y, features_before, PlaceBefore(now, before, x, y, m));
      given = i == 0 ? d : given;
      Sums& s = (*sums)[i];
      s.distance += d;
      if (std::max(std::fabs(m.x - motion.x), std::fabs(m.y - motion.y)) >= kApart) {
        s.given_apart += given;
        s.reading_apart += d;
        ++s.apart;
      }
    }
  }
}

class MotionCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    int64_t samples = 0;
    std::vector<Sums> sums;  ///< one per reading
    double next = 0;         ///< mean distance under the previous frame's motion, which points here
    double opposite = 0;     ///< mean distance under this frame's motion reversed
  };

  bool Judges(const Pair& pair, size_t reading) const;
  bool Prefers(const Pair& pair, size_t reading) const;
  size_t Best() const;
  void MeasureNext(const Exhibit& now, const Exhibit& before, const Features& features,
                   const Features& features_before, int step, Pair* pair) const;
  Finding MakeFinding(size_t best, const std::vector<int64_t>& frames, double ratio) const;
  std::string Cure(const Reading& reading, std::string* aov) const;

  const AovLayout* layout_ = nullptr;
  std::vector<Reading> readings_;
  std::vector<Pair> pairs_;
};

/// Rows are summed in order: results do not depend on the number of threads.
void MotionCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  if (before == nullptr || now.frame.guides.motion.empty()) {
    return;
  }
  if (readings_.empty()) {
    readings_ = MakeReadings(layout_->motion);
  }
  const Features features(now);
  const Features features_before(*before);
  const int step = SampleStep(now.frame.width, now.frame.height, kSamples);
  const int rows = (now.frame.height - step / 2 + step - 1) / step;
  std::vector<std::vector<Sums>> sums(static_cast<size_t>(rows),
                                      std::vector<Sums>(readings_.size()));
  ParallelRows(rows, 4, [&](int r0, int r1) {
    for (int r = r0; r < r1; ++r) {
      MeasureRow(now, *before, features, features_before, readings_, step / 2 + r * step, step,
                 &sums[static_cast<size_t>(r)]);
    }
  });
  Pair pair;
  pair.number = now.number;
  pair.samples = int64_t{rows} * ((now.frame.width - step / 2 + step - 1) / step);
  pair.sums.resize(readings_.size());
  for (const std::vector<Sums>& row : sums) {
    for (size_t i = 0; i < readings_.size(); ++i) {
      pair.sums[i].Add(row[i]);
    }
  }
  MeasureNext(now, *before, features, features_before, step, &pair);
  pairs_.push_back(std::move(pair));
}

/// Distinguishes reversed motion of this frame from motion of the previous frame to this one.
void MotionCheck::MeasureNext(const Exhibit& now, const Exhibit& before, const Features& features,
                              const Features& features_before, int step, Pair* pair) const {
  const Frame& frame = now.frame;
  for (int y = step / 2; y < frame.height; y += 2 * step) {
    for (int x = step / 2; x < frame.width; x += 2 * step) {
      const vec2 back = MotionAt(frame, x, y);
      const vec2 there = MotionAt(before.frame, x, y);
      if (std::isfinite(back.x + back.y + there.x + there.y)) {
        pair->opposite +=
            features.DistanceAt(x, y, features_before, PlaceBefore(now, before, x, y, -back));
        pair->next +=
            features_before.DistanceAt(x, y, features, PlaceBefore(before, now, x, y, there));
      }
    }
  }
}

bool MotionCheck::Judges(const Pair& pair, size_t reading) const {
  const Sums& s = pair.sums[reading];
  return static_cast<double>(s.apart) >= kLeastPart * static_cast<double>(pair.samples) &&
         s.given_apart >= kLeastDistance * static_cast<double>(s.apart);
}

bool MotionCheck::Prefers(const Pair& pair, size_t reading) const {
  const Sums& s = pair.sums[reading];
  return s.reading_apart < kFarBetter * s.given_apart;
}

/// The reading with the smallest distance over all pairs.
size_t MotionCheck::Best() const {
  std::vector<double> total(readings_.size());
  for (const Pair& pair : pairs_) {
    for (size_t i = 0; i < total.size(); ++i) {
      total[i] += pair.sums[i].distance;
    }
  }
  const double least = *std::min_element(total.begin(), total.end());
  for (size_t i = 0; i < total.size(); ++i) {
    if (total[i] <= kTie * least) {
      return i;
    }
  }
  return 0;
}

/// The layer's convention, corrected by the reading.
MotionConvention Corrected(MotionConvention c, const Reading& reading) {
  const bool to_previous = c.direction == MotionDirection::kToPrevious;
  if (reading.sign_x < 0) {
    c.direction = to_previous ? MotionDirection::kFromPrevious : MotionDirection::kToPrevious;
  }
  if (reading.sign_x != reading.sign_y) {
    c.y_up = !c.y_up;
  }
  if (reading.unit != Unit::kSame) {
    c.unit = reading.unit == Unit::kFraction ? MotionUnit::kFraction
             : reading.unit == Unit::kNdc    ? MotionUnit::kNdc
                                             : MotionUnit::kPixels;
  }
  c.scale *= reading.scale;
  return c;
}

/// The equivalent reading before x and y are swapped: each axis then has the convention of the
/// other, and y_up applied to x.
Reading BeforeSwap(Reading reading, const MotionConvention& given) {
  if (reading.swap && given.y_up) {
    reading.sign_x = -reading.sign_x;
    reading.sign_y = -reading.sign_y;
  }
  return reading;
}

std::string MotionCheck::Cure(const Reading& reading, std::string* aov) const {
  const MotionConvention c = Corrected(layout_->motion, BeforeSwap(reading, layout_->motion));
  std::string words = ConventionText(c);
  if (reading.swap) {
    const AovSource& source = *layout_->Find(Aov::kMotion);
    const auto letter = [&](size_t i) {
      return source.channels[i].substr(source.channels[i].rfind('.') + 1);
    };
    words += fmt::format(", channels={}{}", letter(1), letter(0));
  }
  *aov = MappingText(*layout_, Aov::kMotion, words);
  return MappingCure(*aov);
}

Finding MotionCheck::MakeFinding(size_t best, const std::vector<int64_t>& frames,
                                 double ratio) const {
  const Reading r = BeforeSwap(readings_[best], layout_->motion);
  const bool flipped = r.sign_x != r.sign_y;
  Finding finding;
  std::vector<std::string> parts;
  if (r.unit != Unit::kSame) {
    const bool fraction = r.unit == Unit::kFraction;
    const bool ndc = r.unit == Unit::kNdc;
    finding.name = fraction ? "motion_fraction" : ndc ? "motion_ndc" : "motion_pixels";
    parts.push_back(fraction ? "is in fractions of the picture, not in pixels"
                    : ndc    ? "is in coordinates from -1 to 1 across the picture, not in pixels"
                             : "is in pixels already");
  }
  if (r.scale == 0) {
    finding.name = "motion_wrong";
    parts.push_back("leads further astray than no motion would");
  } else if (r.scale != 1) {
    finding.name = "motion_scaled";
    parts.push_back(fmt::format("is {:.3g} times as long as what moves", 1 / r.scale));
  }
  if (r.swap) {
    finding.name = finding.name.empty() ? "motion_swapped" : finding.name;
    parts.push_back("has x and y in each other's place");
  }
  if (flipped) {
    finding.name = !finding.name.empty() ? finding.name
                   : r.sign_y < 0        ? "motion_y_flipped"
                                         : "motion_x_flipped";
    parts.push_back(fmt::format("has {} with the wrong sign", r.sign_y < 0 ? "y" : "x"));
  } else if (r.sign_x < 0) {
    double next = 0;
    double opposite = 0;
    for (const Pair& pair : pairs_) {
      next += pair.next;
      opposite += pair.opposite;
    }
    finding.name = finding.name.empty() ? "motion_direction" : finding.name;
    parts.push_back(next < 0.9 * opposite ? "points to the next frame, not to the previous one"
                                          : "points the wrong way: from the previous frame, or to "
                                            "the next one");
  }
  std::string text;
  for (const std::string& part : parts) {
    text += (text.empty() ? "" : ", and ") + part;
  }
  finding.frames = frames;
  finding.what = fmt::format(
      "motion in {} {}: in {}, the previous frame warped by it differs {:.1f} times as much as {} "
      "(albedo and normals; expected below {:.1f})",
      LayerText(*layout_, Aov::kMotion), text, FrameRanges(frames), 1 / ratio,
      r.scale == 0 ? "not warped at all" : "read so", 1 / kFarBetter);
  finding.measured = 1 / ratio;
  finding.expected = 1 / kFarBetter;
  if (r.scale == 0) {
    finding.cure =
        "look at unit and scale of the motion output (pixels per frame, not per second), and give "
        "it "
        "with --aov motion=LAYER,scale=; or replace it: stillray denoise with --motion estimate";
  } else {
    finding.cure = Cure(readings_[best], &finding.aov);
  }
  return finding;
}

void MotionCheck::Conclude(Verdict* verdict) {
  if (pairs_.empty()) {
    return;
  }
  size_t best = Best();
  const bool any_better = best != 0;
  double given = 0;
  double other = 0;
  std::vector<int64_t> frames;
  int64_t judged = 0;
  const auto weigh = [&](size_t reading) {
    given = other = 0;
    judged = 0;
    frames.clear();
    for (const Pair& pair : pairs_) {
      if (Judges(pair, reading)) {
        given += pair.sums[reading].given_apart;
        other += pair.sums[reading].reading_apart;
        ++judged;
        if (Prefers(pair, reading)) {
          frames.push_back(pair.number);
        }
      }
    }
  };
  if (!any_better) {
    // The ratio of the best alternative is reported even if there is no fault.
    double closest = 0;
    size_t at = 0;
    for (size_t i = 1; i < readings_.size(); ++i) {
      weigh(i);
      if (judged > 0 && (at == 0 || given / std::max(other, 1e-9) > closest)) {
        closest = given / std::max(other, 1e-9);
        at = i;
      }
    }
    if (at == 0) {
      return;
    }
    weigh(at);
    verdict->Add(
        Measure{"motion_warp_ratio", given / std::max(other, 1e-9), 1 / kFarBetter, false, judged});
    return;
  }
  weigh(best);
  if (judged == 0) {
    return;
  }
  const double ratio = std::max(other, 1e-3 * given) / given;
  const bool broken = ratio < kFarBetter && static_cast<double>(frames.size()) >=
                                                kAgreement * static_cast<double>(judged);
  verdict->Add(Measure{"motion_warp_ratio", 1 / ratio, 1 / kFarBetter, broken, judged});
  if (broken) {
    verdict->Add(MakeFinding(best, frames, ratio));
  }
}

}  // namespace

std::unique_ptr<Check> MakeMotionCheck() {
  return std::make_unique<MotionCheck>();
}

}  // namespace stillray::doctor
