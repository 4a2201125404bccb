// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds noise in guides, i.e. detail almost everywhere that does not move with the surfaces, and
// ids that change.
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 40000;
/// Smallest detail that counts: above the rounding of halves and of 8 bits.
constexpr float kDetail[3] = {0.006f, 0.01f, 0.003f};  // albedo, normal, relative 1 / depth
/// Detail above this multiple of kDetail is an edge or strong texture, and would outweigh all
/// noise.
constexpr float kEdge = 6.0f;
/// Fraction of the pixels with detail. Clean sequences: at most 0.42 (a tiled, bricked room) and
/// 0.68 (a floor of fine texture that fills the image); plain surfaces have none.
constexpr double kEverywhere = 0.85;
/// Correlation of the detail of this and the previous frame, along the motion. Texture: 0.5 and
/// more, 0.25 where jittered samples fall on other texels every time; noise: below 0.02.
constexpr double kStays = 0.08;
constexpr double kAgreement = 0.7;

constexpr const char* kNames[3] = {"albedo", "normal", "depth"};
constexpr Aov kAovs[3] = {Aov::kAlbedo, Aov::kNormal, Aov::kDepth};

float FiniteOr0(float v) {
  return std::isfinite(v) ? v : 0.0f;
}

/// The difference between a pixel and the mean of its neighbours.
std::array<float, 3> Detail(const Image3& image, int x, int y) {
  std::array<float, 3> d{};
  for (int c = 0; c < 3; ++c) {
    const Image1& p = image[c];
    const float around = 0.25f * (p(x - 1, y) + p(x + 1, y) + p(x, y - 1) + p(x, y + 1));
    d[static_cast<size_t>(c)] = FiniteOr0(p(x, y) - around);
  }
  return d;
}

/// For depth: the deviation of 1 / z from linear, which it is on every flat surface; the smaller of
/// the two directions, as an edge affects only one direction.
std::array<float, 3> Detail(const Image1& depth, int x, int y) {
  const auto w = [&](int px, int py) { return 1.0f / depth(px, py); };
  const float across = 0.5f * (w(x - 1, y) + w(x + 1, y)) / w(x, y) - 1;
  const float down = 0.5f * (w(x, y - 1) + w(x, y + 1)) / w(x, y) - 1;
  return {FiniteOr0(std::fabs(across) < std::fabs(down) ? across : down), 0, 0};
}

std::array<float, 3> Detail(const Frame& frame, int guide, int x, int y) {
  const Guides& g = frame.guides;
  return guide == 0   ? Detail(g.albedo, x, y)
         : guide == 1 ? Detail(g.normal, x, y)
                      : Detail(g.depth, x, y);
}

class GuideNoiseCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    double part = 0;         ///< of the pixels with detail
    double correlation = 0;  ///< with the previous frame
  };
  Pair Measured(const Exhibit& now, const Exhibit& before, int guide) const;

  const AovLayout* layout_ = nullptr;
  std::vector<Pair> pairs_[3];
};

GuideNoiseCheck::Pair GuideNoiseCheck::Measured(const Exhibit& now, const Exhibit& before,
                                                int guide) const {
  const Frame& f = now.frame;
  const int step = SampleStep(f.width, f.height, kSamples);
  int64_t count = 0;
  int64_t detailed = 0;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (int y = 1 + step / 2; y + 1 < f.height; y += step) {
    for (int x = 1 + step / 2; x + 1 < f.width; x += step) {
      if (!std::isfinite(f.guides.depth(x, y))) {
        continue;
      }
      const std::array<float, 3> a = Detail(f, guide, x, y);
      const float size = std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])});
      ++count;
      detailed += size > kDetail[guide];
      const vec2 m = f.guides.motion.empty() ? vec2(0.0f) : MotionAt(f, x, y);
      int px = 0;
      int py = 0;
      if (!Nearest(PlaceBefore(now, before, x, y, m), f.width, f.height, &px, &py) || px < 1 ||
          py < 1 || px + 1 >= f.width || py + 1 >= f.height) {
        continue;
      }
      const std::array<float, 3> b = Detail(before.frame, guide, px, py);
      const float limit = kEdge * kDetail[guide];
      for (size_t i = 0; i < 3; ++i) {
        if (std::fabs(a[i]) > limit || std::fabs(b[i]) > limit) {
          continue;
        }
        ab += static_cast<double>(a[i]) * b[i];
        aa += static_cast<double>(a[i]) * a[i];
        bb += static_cast<double>(b[i]) * b[i];
      }
    }
  }
  return {now.number, count == 0 ? 0 : static_cast<double>(detailed) / static_cast<double>(count),
          aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 1};
}

void GuideNoiseCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  if (before == nullptr) {
    return;
  }
  for (int guide = 0; guide < 3; ++guide) {
    if (layout_->Find(kAovs[guide]) != nullptr) {
      pairs_[guide].push_back(Measured(now, *before, guide));
    }
  }
}

void GuideNoiseCheck::Conclude(Verdict* verdict) {
  for (int guide = 0; guide < 3; ++guide) {
    const std::vector<Pair>& pairs = pairs_[guide];
    // Wrong values are nonlinear and discontinuous for reasons covered by other findings.
    if (pairs.empty() || verdict->Has("motion_") || verdict->Exceeds("random_blocks") ||
        verdict->Has(fmt::format("{}_", kNames[guide]))) {
      continue;
    }
    std::vector<int64_t> frames;
    double part = 0;
    double correlation = 0;
    for (const Pair& pair : pairs) {
      part += pair.part / static_cast<double>(pairs.size());
      correlation += pair.correlation / static_cast<double>(pairs.size());
      if (pair.part > kEverywhere && pair.correlation < kStays) {
        frames.push_back(pair.number);
      }
    }
    const bool broken =
        static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(pairs.size());
    const auto judged = static_cast<int64_t>(pairs.size());
    verdict->Add(
        Measure{fmt::format("{}_detail", kNames[guide]), part, kEverywhere, broken, judged});
    verdict->Add(Measure{fmt::format("{}_detail_stays", kNames[guide]), correlation, kStays, broken,
                         judged});
    if (!broken) {
      continue;
    }
    verdict->Add(Finding{
        fmt::format("{}_noisy", kNames[guide]), frames,
        fmt::format(
            "{} in {} holds noise: {:.0f} % of the pixels differ from their neighbours in {} "
            "(expected below {:.0f} %), and correlate by {:.2f} with the frame before "
            "(texture: above {:.1f})",
            kNames[guide], LayerText(*layout_, kAovs[guide]), 100 * part, FrameRanges(frames),
            100 * kEverywhere, correlation, kStays),
        layout_->renderer == "blender"
            ? "switch off depth of field and motion blur, narrow the pixel filter to 0.01, or "
              "render "
              "more samples"
            : "write the guides of the first surface without lens or motion blur and without light "
              "in them, or with more samples than the light",
        part, kEverywhere, ""});
  }
}

/// Fraction of the pixels whose id does not occur among the pixels around their previous position.
/// Clean: below 0.1 (disocclusions).
constexpr double kMayChange = 0.5;

class IdCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    double changed = 0;
  };
  const AovLayout* layout_ = nullptr;
  std::vector<Pair> pairs_;
};

bool IsAround(const Plane<uint32_t>& id, int x, int y, uint32_t wanted) {
  for (int py = std::max(y - 1, 0); py <= std::min(y + 1, id.height() - 1); ++py) {
    for (int px = std::max(x - 1, 0); px <= std::min(x + 1, id.width() - 1); ++px) {
      if (id(px, py) == wanted) {
        return true;
      }
    }
  }
  return false;
}

void IdCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  const Plane<uint32_t>& id = now.frame.guides.id;
  if (before == nullptr || id.empty() || before->frame.guides.id.empty()) {
    return;
  }
  int64_t count = 0;
  int64_t changed = 0;
  for (int y = 0; y < now.frame.height; ++y) {
    for (int x = 0; x < now.frame.width; ++x) {
      const vec2 m = now.frame.guides.motion.empty() ? vec2(0.0f) : MotionAt(now.frame, x, y);
      int px = 0;
      int py = 0;
      if (id(x, y) != 0 && Nearest(PlaceBefore(now, *before, x, y, m), now.frame.width,
                                   now.frame.height, &px, &py)) {
        ++count;
        changed += !IsAround(before->frame.guides.id, px, py, id(x, y));
      }
    }
  }
  if (count > 0) {
    pairs_.push_back({now.number, static_cast<double>(changed) / static_cast<double>(count)});
  }
}

void IdCheck::Conclude(Verdict* verdict) {
  if (pairs_.empty() || verdict->Has("motion_")) {
    return;
  }
  std::vector<int64_t> frames;
  double mean = 0;
  for (const Pair& pair : pairs_) {
    mean += pair.changed / static_cast<double>(pairs_.size());
    if (pair.changed > kMayChange) {
      frames.push_back(pair.number);
    }
  }
  // A cut changes all ids once.
  const bool broken =
      static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(pairs_.size());
  verdict->Add(
      Measure{"id_changes", mean, kMayChange, broken, static_cast<int64_t>(pairs_.size())});
  if (!broken) {
    return;
  }
  const Aov aov = layout_->Find(Aov::kId) != nullptr ? Aov::kId : Aov::kCryptomatte;
  const std::string mapping = fmt::format("{}=none", AovName(aov));
  verdict->Add(Finding{
      "id_unstable", frames,
      fmt::format("numbers of surfaces in {} do not stay: {:.0f} % of the pixels have one that was "
                  "not there a frame before, in {} (expected below {:.0f} %)",
                  LayerText(*layout_, aov), 100 * mean, FrameRanges(frames), 100 * kMayChange),
      "give every object one number for the whole sequence, or leave them out: stillray denoise "
      "with "
      "--aov " +
          mapping,
      mean, kMayChange, mapping});
}

}  // namespace

std::unique_ptr<Check> MakeGuideNoiseCheck() {
  return std::make_unique<GuideNoiseCheck>();
}

std::unique_ptr<Check> MakeIdCheck() {
  return std::make_unique<IdCheck>();
}

}  // namespace stillray::doctor
