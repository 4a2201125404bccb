// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds a baked-in exposure: radiance that changes everywhere by the same factor from one frame to
// the next.
#include <cmath>

#include <fmt/format.h>

#include "core/median.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int kBlock = 16;
constexpr int kLeastBlocks = 24;
/// Brighter samples are clamped to this many times the mean.
constexpr float kBright = 4.0f;
constexpr float kSameSurface = 0.1f;
/// Smallest factor (as a logarithm) that is reported. Clean sequences: below 0.02 under static
/// lamps, 0.08 under several that move by a quarter of a second from frame to frame.
constexpr double kLeastChange = 0.14;
/// Median relative deviation of the blocks' factors from the common factor: a lamp that moves or is
/// dimmed changes only some blocks. Planted: 0.1.
constexpr double kEven = 0.35;

/// Mean of unfiltered radiance: if it is constant, the exposure is constant too.
double UnfilteredLight(const Frame& frame) {
  double sum = 0;
  for (const Image3* image : {&frame.emission, &frame.background}) {
    for (int c = 0; c < 3 && !image->empty(); ++c) {
      for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
          const float v = (*image)[c](x, y);
          sum += std::isfinite(v) ? v : 0.0f;
        }
      }
    }
  }
  return sum / (3.0 * frame.width * frame.height);
}

class ExposureCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    double change = 0;  ///< logarithm of the factor
    double spread = 0;
    bool unfiltered_stays = false;
  };
  std::vector<Pair> pairs_;
};

/// Logarithms of the ratio of radiance now to radiance before, per block, on surfaces visible in
/// both frames.
/// \param limit_now, limit_before  clamp of bright samples: the same multiple of the mean in both
///     frames, so that a common factor cancels
std::vector<double> BlockChanges(const Exhibit& now, const Exhibit& before, float limit_now,
                                 float limit_before) {
  const Features a(now);
  const Features b(before);
  const bool moves = !now.frame.guides.motion.empty();
  std::vector<double> changes;
  for (int by = 0; by + kBlock <= now.frame.height; by += kBlock) {
    for (int bx = 0; bx + kBlock <= now.frame.width; bx += kBlock) {
      double sum = 0;
      double sum_before = 0;
      int count = 0;
      for (int y = by; y < by + kBlock; ++y) {
        for (int x = bx; x < bx + kBlock; ++x) {
          const vec2 m = moves ? MotionAt(now.frame, x, y) : vec2(0.0f);
          int px = 0;
          int py = 0;
          if (Nearest(PlaceBefore(now, before, x, y, m), now.frame.width, now.frame.height, &px,
                      &py) &&
              a.Distance(x, y, b, px, py) < kSameSurface) {
            sum += std::min(now.light(x, y), limit_now);
            sum_before += std::min(before.light(px, py), limit_before);
            ++count;
          }
        }
      }
      if (std::isfinite(sum) && std::isfinite(sum_before) && count >= kBlock * kBlock / 2 &&
          sum > 0.02 * limit_now * count && sum_before > 0.02 * limit_before * count) {
        changes.push_back(std::log(sum / sum_before));
      }
    }
  }
  return changes;
}

void ExposureCheck::Look(const Exhibit& now, const Exhibit* before) {
  if (before == nullptr) {
    return;
  }
  const double mean_now = MeanLight(now);
  const double mean_before = MeanLight(*before);
  if (!(mean_now > 0 && mean_before > 0)) {
    return;
  }
  const std::vector<double> changes =
      BlockChanges(now, *before, kBright * static_cast<float>(mean_now),
                   kBright * static_cast<float>(mean_before));
  if (changes.size() < kLeastBlocks) {
    return;
  }
  Pair pair;
  pair.number = now.number;
  pair.change = Median(changes);
  std::vector<double> differences;
  for (const double c : changes) {
    differences.push_back(std::fabs(c - pair.change));
  }
  pair.spread = Median(differences);
  const double unfiltered = UnfilteredLight(now.frame);
  const double unfiltered_before = UnfilteredLight(before->frame);
  if (unfiltered > 0 && unfiltered_before > 0) {
    const double factor = std::log(unfiltered / unfiltered_before);
    pair.unfiltered_stays = std::fabs(factor) < 0.5 * std::fabs(pair.change);
  }
  pairs_.push_back(pair);
}

void ExposureCheck::Conclude(Verdict* verdict) {
  if (pairs_.empty() || verdict->Has("motion_") || verdict->Has("light_")) {
    return;
  }
  std::vector<int64_t> frames;
  double largest = 0;
  double noise = 0;
  for (const Pair& pair : pairs_) {
    if (std::fabs(pair.change) > std::fabs(largest)) {
      largest = pair.change;
      noise = pair.spread;
    }
    if (std::fabs(pair.change) >= kLeastChange && pair.spread <= kEven * std::fabs(pair.change) &&
        !pair.unfiltered_stays) {
      frames.push_back(pair.number);
    }
  }
  verdict->Add(Measure{"exposure_change", std::exp(std::fabs(largest)), std::exp(kLeastChange),
                       !frames.empty(), static_cast<int64_t>(pairs_.size())});
  if (frames.empty()) {
    return;
  }
  verdict->Add(Finding{
      "exposure_changes", frames,
      fmt::format("all light changes by one factor at {}, up to {:.2f} times that of the frame "
                  "before (blocks differ by {:.0f} % from each other; expected below {:.2f} times)",
                  FrameRanges(frames), std::exp(largest), 100 * noise, std::exp(kLeastChange)),
      "write light without exposure (switch off automatic exposure; Blender: Film > Exposure must "
      "not be animated) and set it after denoising",
      std::exp(largest), std::exp(kLeastChange), ""});
}

}  // namespace

std::unique_ptr<Check> MakeExposureCheck() {
  return std::make_unique<ExposureCheck>();
}

}  // namespace stillray::doctor
