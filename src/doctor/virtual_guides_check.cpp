// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds invalid virtual guides: images nearer than the mirror, images that are not found again at
// the position given by their motion, and hit distances that are zero everywhere.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/pixels.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 20000;
/// The path to the reflected surface is longer than the path to the mirror; at the foot of the
/// mirror it may be shorter by rounding.
constexpr float kNearer = 0.98f;
/// Fraction of the pixels with a virtual image. Clean: 0 measured.
constexpr double kMayBeNearer = 0.05;
/// Images are found again at a pixel of similar depth and albedo.
constexpr float kSameDepth = 0.05f;
constexpr float kSameAlbedo = 0.08f;
/// Another motion fits better if it finds this many more images, as a fraction of the pixels where
/// both motions differ by kDiffers pixels. Clean: at most -0.06 measured; opposite motion 0.35.
constexpr double kFindsMore = 0.1;
constexpr float kDiffers = 1.5f;
/// Only pixels count whose image differs from the images this many pixels to the right and below:
/// others match anywhere.
constexpr int kApart = 3;
/// Minimum number of pixels.
constexpr int64_t kLeastPixels = 50;
/// Fraction of the pairs of frames that must agree.
constexpr double kAgreement = 0.7;

/// The virtual guides of specular or of transmitted light.
struct Kind {
  const VirtualGuides Frame::*guides;
  std::vector<Aov> depths;   ///< the candidate layers; the first that exists in the file is used
  std::vector<Aov> motions;  ///< candidate layers, as `depths`
  std::vector<std::pair<int64_t, double>> nearer = {};  ///< of each frame
  std::vector<std::pair<int64_t, double>> more = {};    ///< of each pair of frames
};

/// The first of these layers that exists in the file; else the first of all.
Aov Given(const AovLayout& layout, const std::vector<Aov>& aovs) {
  for (const Aov aov : aovs) {
    if (layout.Find(aov) != nullptr) {
      return aov;
    }
  }
  return aovs.front();
}

bool HasImage(const VirtualGuides& image, int x, int y) {
  return image.depth(x, y) > 0;
}

/// Whether the virtual images at (x, y) and at (u, v) of the previous frame agree.
bool SameImage(const VirtualGuides& now, int x, int y, const VirtualGuides& before, int u, int v) {
  const float a = now.depth(x, y);
  const float b = before.depth(u, v);
  if (std::isinf(a) || std::isinf(b)) {
    return std::isinf(a) && std::isinf(b);
  }
  bool same = std::abs(a - b) <= kSameDepth * std::max(a, b);
  for (int c = 0; c < 3 && !now.albedo.empty() && !before.albedo.empty(); ++c) {
    const float most = std::max(1.0f, now.albedo[c](x, y));
    same = same && std::abs(now.albedo[c](x, y) - before.albedo[c](u, v)) <= kSameAlbedo * most;
  }
  return same;
}

bool HasStructure(const VirtualGuides& image, int x, int y) {
  return x + kApart < image.depth.width() && y + kApart < image.depth.height() &&
         HasImage(image, x + kApart, y) && HasImage(image, x, y + kApart) &&
         !SameImage(image, x, y, image, x + kApart, y) &&
         !SameImage(image, x, y, image, x, y + kApart);
}

bool IsInside(const VirtualGuides& image, vec2 place) {
  int x = 0;
  int y = 0;
  return Nearest(place, image.depth.width(), image.depth.height(), &x, &y);
}

/// Whether one of the four pixels around a position has the same virtual image.
bool IsFoundAt(const VirtualGuides& now, int x, int y, const VirtualGuides& before, vec2 place) {
  const int u0 = static_cast<int>(std::floor(place.x));
  const int v0 = static_cast<int>(std::floor(place.y));
  for (int i = 0; i < 4; ++i) {
    const int u = u0 + (i & 1);
    const int v = v0 + (i >> 1);
    if (u >= 0 && v >= 0 && u < before.depth.width() && v < before.depth.height() &&
        SameImage(now, x, y, before, u, v)) {
      return true;
    }
  }
  return false;
}

/// Calls visit(x, y) for sampled pixels.
template <typename Visit>
void ForEachSample(const Frame& frame, const Visit& visit) {
  const int step = SampleStep(frame.width, frame.height, kSamples);
  for (int y = step / 2; y < frame.height; y += step) {
    for (int x = step / 2; x < frame.width; x += step) {
      visit(x, y);
    }
  }
}

/// The frames above a limit. \param largest  [in,out] value of all
std::vector<int64_t> Above(const std::vector<std::pair<int64_t, double>>& values, double limit,
                           double* largest) {
  std::vector<int64_t> frames;
  for (const auto& [number, value] : values) {
    *largest = std::max(*largest, value);
    if (value > limit) {
      frames.push_back(number);
    }
  }
  return frames;
}

class VirtualGuidesCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override {
    layout_ = now.layout;
    if (layout_->Find(Aov::kHitDistance) != nullptr) {
      ++hit_frames_;
      if (!HasHit(now)) {
        without_hits_.push_back(now.number);
      }
    }
    for (Kind& kind : kinds_) {
      const VirtualGuides& image = now.frame.*kind.guides;
      if (now.layout->Find(Given(*now.layout, kind.depths)) == nullptr || image.empty()) {
        continue;
      }
      LookAtDepth(now, image, &kind);
      if (before != nullptr && !(before->frame.*kind.guides).empty() && !image.motion.empty()) {
        LookAtMotion(now, *before, image, before->frame.*kind.guides, &kind);
      }
    }
  }

  void Conclude(Verdict* verdict) override {
    ConcludeHits(verdict);
    for (const Kind& kind : kinds_) {
      ConcludeDepth(kind, verdict);
      ConcludeMotion(kind, verdict);
    }
  }

 private:
  static bool HasHit(const Exhibit& now) {
    const Image1 hits =
        ConvertHitDistance(StoredPlane(now, Aov::kHitDistance, 0), now.layout->hit_distance);
    return AnyPixel(hits, [](float hit) { return hit > 0; });
  }

  /// Single frames may have no reflections.
  void ConcludeHits(Verdict* verdict) const {
    if (without_hits_.empty() || without_hits_.size() < hit_frames_) {
      return;
    }
    verdict->Add(Finding{
        "hit_distance_zero", without_hits_,
        fmt::format("{} is nowhere above 0 in {} (expected the length of the reflected ray where a "
                    "surface reflects)",
                    LayerText(*layout_, Aov::kHitDistance), FrameRanges(without_hits_)),
        "write the length of the ray from the first surface to what it meets, in the unit of "
        "depth, "
        "1e9 or more where it leaves the scene; or do without: " +
            MappingCure("hit_distance=none"),
        0, 0, "hit_distance=none"});
  }

  static void LookAtDepth(const Exhibit& now, const VirtualGuides& image, Kind* kind) {
    int64_t images = 0;
    int64_t nearer = 0;
    ForEachSample(now.frame, [&](int x, int y) {
      images += HasImage(image, x, y) ? 1 : 0;
      nearer += HasImage(image, x, y) && image.depth(x, y) < kNearer * now.frame.guides.depth(x, y);
    });
    if (images >= kLeastPixels) {
      kind->nearer.emplace_back(now.number,
                                static_cast<double>(nearer) / static_cast<double>(images));
    }
  }

  /// The advantage of the best alternative motion: the surface's, zero, or the opposite.
  static void LookAtMotion(const Exhibit& now, const Exhibit& before, const VirtualGuides& image,
                           const VirtualGuides& old, Kind* kind) {
    struct Counts {
      int64_t pixels = 0;
      int64_t more = 0;
    } counts[3];
    ForEachSample(now.frame, [&](int x, int y) {
      if (!HasImage(image, x, y) || !HasStructure(image, x, y)) {
        return;
      }
      const vec2 given = {image.motion[0](x, y), image.motion[1](x, y)};
      const vec2 others[3] = {MotionAt(now.frame, x, y), vec2(0.0f), -given};
      for (int i = 0; i < 3; ++i) {
        const vec2 places[2] = {PlaceBefore(now, before, x, y, given),
                                PlaceBefore(now, before, x, y, others[i])};
        if (IsInside(old, places[0]) && IsInside(old, places[1]) &&
            glm::length(places[0] - places[1]) >= kDiffers) {
          ++counts[i].pixels;
          counts[i].more += IsFoundAt(image, x, y, old, places[1]) ? 1 : 0;
          counts[i].more -= IsFoundAt(image, x, y, old, places[0]) ? 1 : 0;
        }
      }
    });
    double most = -1;
    for (const Counts& c : counts) {
      if (c.pixels >= kLeastPixels) {
        most = std::max(most, static_cast<double>(c.more) / static_cast<double>(c.pixels));
      }
    }
    if (most > -1) {
      kind->more.emplace_back(now.number, most);
    }
  }

  void ConcludeDepth(const Kind& kind, Verdict* verdict) const {
    double worst = 0;
    const std::vector<int64_t> frames = Above(kind.nearer, kMayBeNearer, &worst);
    if (kind.nearer.empty()) {
      return;
    }
    const Aov depth = Given(*layout_, kind.depths);
    verdict->Add(Measure{fmt::format("{}_nearer", AovName(depth)), worst, kMayBeNearer,
                         !frames.empty(), static_cast<int64_t>(kind.nearer.size())});
    if (!frames.empty()) {
      verdict->Add(Finding{
          "image_depth_nearer", frames,
          fmt::format("{} is less than the depth of the surface in up to {:.0f} % of its pixels in "
                      "{} (expected at most {:.0f} %)",
                      LayerText(*layout_, depth), 100 * worst, FrameRanges(frames),
                      100 * kMayBeNearer),
          "write the view-space z of the point on the pixel's ray that is as far away as the whole "
          "path to what is seen is long, 0 where nothing is",
          worst, kMayBeNearer, ""});
    }
  }

  void ConcludeMotion(const Kind& kind, Verdict* verdict) const {
    double most = -1;
    const std::vector<int64_t> frames = Above(kind.more, kFindsMore, &most);
    if (kind.more.empty()) {
      return;
    }
    const Aov motion = MotionLayer(kind);
    const bool broken =
        static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(kind.more.size());
    verdict->Add(Measure{fmt::format("{}_wrong", AovName(motion)), most, kFindsMore, broken,
                         static_cast<int64_t>(kind.more.size())});
    if (broken) {
      verdict->Add(Finding{
          "image_motion_wrong", frames,
          fmt::format("what surfaces show is found again by another motion than that in {} in "
                      "{:.0f} % more of the pixels in {} (expected at most {:.0f} %)",
                      LayerText(*layout_, motion), 100 * most, FrameRanges(frames),
                      100 * kFindsMore),
          "write the motion of the image, not that of the surface, in the convention of motion; or "
          "leave the layers out",
          most, kFindsMore, ""});
    }
  }

  /// The source of the motion: its own layer, or the hit distances from which it is computed.
  Aov MotionLayer(const Kind& kind) const {
    const Aov motion = Given(*layout_, kind.motions);
    const Aov depth = Given(*layout_, kind.depths);
    return depth == Aov::kHitDistance && layout_->Find(motion) == nullptr ? depth : motion;
  }

  const AovLayout* layout_ = nullptr;
  size_t hit_frames_ = 0;              ///< with the layer
  std::vector<int64_t> without_hits_;  ///< those of them without a value above 0
  Kind kinds_[2] = {{&Frame::reflection,
                     {Aov::kReflectionDepth, Aov::kHitDistance},
                     {Aov::kReflectionMotion, Aov::kSpecularMotion}},
                    {&Frame::refraction, {Aov::kRefractionDepth}, {Aov::kRefractionMotion}}};
};

}  // namespace

std::unique_ptr<Check> MakeVirtualGuidesCheck() {
  return std::make_unique<VirtualGuidesCheck>();
}

}  // namespace stillray::doctor
