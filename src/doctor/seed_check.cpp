// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds noise that is identical in every frame: at the same pixel, independent of the surface.
#include <array>
#include <cmath>
#include <deque>

#include <fmt/format.h>

#include "core/parallel.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

/// Where motion exceeds this, image detail has moved, and any remaining pattern at a pixel is
/// noise.
constexpr float kMoves = 1.5f;
/// Number of frames kept for this test.
constexpr size_t kFramesBack = 6;
constexpr float kStill = 0.05f;
constexpr int64_t kLeastPixels = 1500;
/// Correlation of the noise of this and the previous frame. Animated seed: below 0.04; a fixed one:
/// 0.3 and more where the camera moves, 1 where it does not.
constexpr double kCorrelated = 0.15;
/// Correlation at an offset of two pixels: image detail correlates there too, noise does not.
constexpr double kElsewhere = 0.5;
/// Fraction of the noisy pixels of a static region that are bit-identical to the previous frame.
constexpr double kIdentical = 0.5;
constexpr float kNoisy = 0.02f;
constexpr double kAgreement = 0.7;

/// Radiance, compressed so that bright samples do not dominate, minus the mean of the surrounding
/// pixels.
Image1 Noise(const Exhibit& exhibit) {
  const Image1& light = exhibit.light;
  const int width = light.width();
  const int height = light.height();
  const auto mean = static_cast<float>(std::max(MeanLight(exhibit), 1e-20));
  Image1 curve(width, height);
  Image1 noise(width, height);
  ParallelRows(height, 16, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        curve(x, y) = light(x, y) / (light(x, y) + mean);
      }
    }
  });
  ParallelRows(height, 16, [&](int y0, int y1) {
    for (int y = std::max(y0, 1); y < std::min(y1, height - 1); ++y) {
      for (int x = 1; x + 1 < width; ++x) {
        float around = 0;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            around += dx != 0 || dy != 0 ? curve(x + dx, y + dy) : 0.0f;
          }
        }
        noise(x, y) = curve(x, y) - around / 8;
      }
    }
  });
  return noise;
}

struct Correlation {
  double ab = 0;
  double aa = 0;
  double bb = 0;

  void Add(float a, float b) {
    ab += static_cast<double>(a) * b;
    aa += static_cast<double>(a) * a;
    bb += static_cast<double>(b) * b;
  }
  double Value() const { return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0; }
};

constexpr std::array<std::array<int, 2>, 8> kOffsets = {
    {{2, 0}, {-2, 0}, {0, 2}, {0, -2}, {2, 2}, {-2, 2}, {2, -2}, {-2, -2}}};

class SeedCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    double here = 0;
    double elsewhere = 0;
    bool judged_moving = false;
    double identical = 0;
    bool judged_still = false;

    bool Same() const {
      return (judged_moving && here > kCorrelated && elsewhere < kElsewhere * here) ||
             (judged_still && identical > kIdentical);
    }
  };
  void LookMoving(const Frame& frame, const Image1& noise, Pair* pair) const;
  static void LookStill(const Exhibit& now, const Exhibit& before, const Image1& noise, Pair* pair);

  const AovLayout* layout_ = nullptr;
  std::deque<Image1> noises_;  ///< of the previous frames, the newest first
  std::vector<Pair> pairs_;
};

/// Compares with the newest frame that is far enough back: slow motion takes several frames to
/// exceed the limit.
void SeedCheck::LookMoving(const Frame& frame, const Image1& noise, Pair* pair) const {
  Correlation here;
  std::array<Correlation, kOffsets.size()> off;
  int64_t moving = 0;
  for (int y = 3; y + 3 < frame.height; ++y) {
    for (int x = 3; x + 3 < frame.width; ++x) {
      const vec2 m = MotionAt(frame, x, y);
      const float length = std::max(std::fabs(m.x), std::fabs(m.y));
      if (!(length * static_cast<float>(noises_.size()) >= kMoves)) {
        continue;
      }
      const auto back = static_cast<size_t>(std::ceil(kMoves / length)) - 1;
      const Image1& old = noises_[std::min(back, noises_.size() - 1)];
      ++moving;
      here.Add(noise(x, y), old(x, y));
      for (size_t i = 0; i < kOffsets.size(); ++i) {
        off[i].Add(noise(x, y), old(x + kOffsets[i][0], y + kOffsets[i][1]));
      }
    }
  }
  pair->here = here.Value();
  for (const Correlation& c : off) {
    pair->elsewhere = std::max(pair->elsewhere, c.Value());
  }
  pair->judged_moving = moving >= kLeastPixels;
}

void SeedCheck::LookStill(const Exhibit& now, const Exhibit& before, const Image1& noise,
                          Pair* pair) {
  int64_t still = 0;
  int64_t noisy = 0;
  int64_t identical = 0;
  for (int y = 1; y + 1 < now.frame.height; ++y) {
    for (int x = 1; x + 1 < now.frame.width; ++x) {
      const vec2 m = now.frame.guides.motion.empty() ? vec2(0.0f) : MotionAt(now.frame, x, y);
      if (std::max(std::fabs(m.x), std::fabs(m.y)) <= kStill && now.light(x, y) > 0) {
        ++still;
        if (std::fabs(noise(x, y)) > kNoisy) {
          ++noisy;
          identical += now.light(x, y) == before.light(x, y);
        }
      }
    }
  }
  // Without noise, constant radiance is correct.
  pair->judged_still = noisy >= kLeastPixels && noisy * 5 >= still;
  pair->identical = noisy == 0 ? 0 : static_cast<double>(identical) / static_cast<double>(noisy);
}

void SeedCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  Image1 noise = Noise(now);
  if (before == nullptr) {
    noises_.clear();
  } else if (!noises_.empty()) {
    Pair pair;
    pair.number = now.number;
    if (!now.frame.guides.motion.empty()) {
      LookMoving(now.frame, noise, &pair);
    }
    LookStill(now, *before, noise, &pair);
    if (pair.judged_moving || pair.judged_still) {
      pairs_.push_back(pair);
    }
  }
  noises_.push_front(std::move(noise));
  if (noises_.size() > kFramesBack) {
    noises_.pop_back();
  }
}

void SeedCheck::Conclude(Verdict* verdict) {
  if (pairs_.empty()) {
    return;
  }
  std::vector<int64_t> frames;
  double here = 0;
  double identical = 0;
  for (const Pair& pair : pairs_) {
    here += pair.judged_moving ? pair.here : 0;
    identical += pair.judged_still ? pair.identical : 0;
    if (pair.Same()) {
      frames.push_back(pair.number);
    }
  }
  const auto count = static_cast<double>(pairs_.size());
  const bool broken = static_cast<double>(frames.size()) >= kAgreement * count;
  verdict->Add(Measure{"noise_correlation", here / count, kCorrelated, broken,
                       static_cast<int64_t>(pairs_.size())});
  verdict->Add(Measure{"noise_identical", identical / count, kIdentical, broken,
                       static_cast<int64_t>(pairs_.size())});
  if (!broken) {
    return;
  }
  const bool still = identical / count > kIdentical;
  verdict->Add(Finding{
      "fixed_seed", frames,
      still
          ? fmt::format("the noise is the same in every frame: at {}, {:.0f} % of the noisy pixels "
                        "of still regions have the bits of the frame before (expected below {:.0f} "
                        "%); accumulating it gains nothing",
                        FrameRanges(frames), 100 * identical / count, 100 * kIdentical)
          : fmt::format("the noise is the same in every frame: at {}, it correlates by {:.2f} with "
                        "that of the frame before at the same pixels although the picture moves "
                        "(expected below {:.2f}); accumulating it gains nothing",
                        FrameRanges(frames), here / count, kCorrelated),
      layout_->renderer == "blender" ? "press the clock beside Render Properties > Sampling > "
                                       "Advanced > Seed, and render again"
                                     : "give every frame another seed, and render again",
      still ? identical / count : here / count, still ? kIdentical : kCorrelated, ""});
}

}  // namespace

std::unique_ptr<Check> MakeSeedCheck() {
  return std::make_unique<SeedCheck>();
}

}  // namespace stillray::doctor
