// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds normals in camera space. Two conditions must hold: the stored normals equal those derived
// from depth on flat surfaces (which are in camera space, up to the focal length), and the normals
// of surfaces change from frame to frame. A camera along a world axis satisfies only the first
// condition; a rotating object only the second.
#include <cmath>

#include <fmt/format.h>

#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 12000;
constexpr size_t kLeastPatches = 150;
constexpr int kReach = 3;  ///< pixels around a patch
constexpr float kDegrees = 57.29578f;
/// Three quarters of the patches agree within this angle.
constexpr float kAligned = 2.5f;
/// The mean normal of all patches must be shorter than this, otherwise the normals are too similar.
constexpr float kDiverse = 0.95f;
/// Minimum rotation of a surface's normal, above rounding (halves: 0.04 degrees).
constexpr float kTurned = 0.07f;
/// Fraction of the patches with rotated normals. Static scenes in world space: below 0.06; in
/// camera space 0.64 measured: the floor does not turn under a panning camera.
constexpr double kMostTurned = 0.3;
/// A larger rotation indicates another surface.
constexpr float kOtherSurface = 8.0f;
constexpr double kAgreement = 0.6;

struct Patch {
  int x = 0;
  int y = 0;
  vec3 normal;  ///< stored
  /// 1 / z = slope.z + slope.x (x - middle) + slope.y (y - middle), y downwards.
  vec3 slope;
};

vec3 NormalAt(const Frame& frame, int x, int y) {
  const Image3& n = frame.guides.normal;
  return {n[0](x, y), n[1](x, y), n[2](x, y)};
}

float AngleBetween(vec3 a, vec3 b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * kDegrees;
}

std::vector<Patch> PatchesOf(const Frame& frame) {
  const int step = SampleStep(frame.width, frame.height, kSamples);
  const int reach = std::max(kReach, frame.width / 96);
  std::vector<Patch> patches;
  for (int y = step / 2; y < frame.height; y += step) {
    for (int x = step / 2; x < frame.width; x += step) {
      if (!IsFlat(frame, x, y, 1, 0, reach) || !IsFlat(frame, x, y, 0, 1, reach)) {
        continue;
      }
      const auto w = [&](int px, int py) { return 1.0f / frame.guides.depth(px, py); };
      const float span = 2.0f * static_cast<float>(reach);
      const float across = (w(x + reach, y) - w(x - reach, y)) / span;
      const float down = (w(x, y + reach) - w(x, y - reach)) / span;
      const float dx = static_cast<float>(x) + 0.5f - 0.5f * static_cast<float>(frame.width);
      const float dy = static_cast<float>(y) + 0.5f - 0.5f * static_cast<float>(frame.height);
      patches.push_back(
          {x, y, NormalAt(frame, x, y), {across, down, w(x, y) - across * dx - down * dy}});
    }
  }
  return patches;
}

/// The angle within which three quarters of the stored normals match camera space, with the best
/// focal length and axes: y up or down, z towards the viewer or away.
float Misalignment(const std::vector<Patch>& patches, int width) {
  float best = 180;
  constexpr int kFocals = 40;
  for (int i = 0; i <= kFocals; ++i) {
    const float focal =
        static_cast<float>(width) * 0.35f * std::pow(20.0f, static_cast<float>(i) / kFocals);
    for (const float up : {1.0f, -1.0f}) {
      for (const float towards : {1.0f, -1.0f}) {
        std::vector<float> angles;
        for (const Patch& p : patches) {
          const vec3 n(-focal * p.slope.x, up * focal * p.slope.y, towards * p.slope.z);
          const float length = glm::length(n);
          const float angle = AngleBetween(n / length, p.normal);
          angles.push_back(std::isfinite(angle) ? angle : 180.0f);
        }
        const auto at = angles.begin() + static_cast<ptrdiff_t>(angles.size() * 3 / 4);
        std::nth_element(angles.begin(), at, angles.end());
        best = std::min(best, *at);
      }
    }
  }
  return best;
}

class CameraSpaceCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    float misalignment = 0;  ///< degrees
    double turned = 0;       ///< fraction of the patches
  };
  const AovLayout* layout_ = nullptr;
  std::vector<Pair> pairs_;
};

void CameraSpaceCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  if (before == nullptr || layout_->Find(Aov::kNormal) == nullptr ||
      layout_->Find(Aov::kDepth) == nullptr || layout_->normal.camera_space ||
      now.frame.guides.motion.empty()) {
    return;
  }
  const std::vector<Patch> patches = PatchesOf(now.frame);
  if (patches.size() < kLeastPatches) {
    return;
  }
  vec3 mean(0.0f);
  size_t seen = 0;
  size_t turned = 0;
  for (const Patch& p : patches) {
    mean += p.normal / static_cast<float>(patches.size());
    int x = 0;
    int y = 0;
    if (Nearest(PlaceBefore(now, *before, p.x, p.y, MotionAt(now.frame, p.x, p.y)), now.frame.width,
                now.frame.height, &x, &y)) {
      const float angle = AngleBetween(p.normal, NormalAt(before->frame, x, y));
      seen += angle < kOtherSurface;
      turned += angle < kOtherSurface && angle > kTurned;
    }
  }
  if (glm::length(mean) < kDiverse && seen >= kLeastPatches / 2) {
    const double part = static_cast<double>(turned) / static_cast<double>(seen);
    // The fit is the slowest step, and matters only if normals rotate.
    pairs_.push_back(
        {now.number, part > kMostTurned ? Misalignment(patches, now.frame.width) : 180.0f, part});
  }
}

void CameraSpaceCheck::Conclude(Verdict* verdict) {
  if (pairs_.empty() || verdict->Has("motion_") || verdict->Has("depth_") ||
      verdict->Has("normal_")) {
    return;
  }
  std::vector<int64_t> frames;
  double turned = 0;
  double angle = 0;
  for (const Pair& pair : pairs_) {
    turned += pair.turned / static_cast<double>(pairs_.size());
    if (pair.turned > kMostTurned && pair.misalignment < kAligned) {
      frames.push_back(pair.number);
      angle += pair.misalignment;
    }
  }
  const bool broken =
      static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(pairs_.size());
  verdict->Add(
      Measure{"normals_turned", turned, kMostTurned, broken, static_cast<int64_t>(pairs_.size())});
  if (!broken) {
    return;
  }
  NormalConvention camera = layout_->normal;
  camera.camera_space = true;
  const std::string mapping = MappingText(*layout_, Aov::kNormal, ConventionText(camera));
  std::string cure = MappingCure(mapping) + " (exact in files with worldToCamera)";
  if (layout_->renderer == "blender") {
    cure = "take the pass Normal (world space), not Denoising Normal; or " + cure;
  }
  verdict->Add(Finding{
      "normal_camera_space", frames,
      fmt::format("normals in {} are in camera space: in {} they agree with those of depth in the "
                  "camera's axes within {:.1f} degrees and turn on {:.0f} % of the flat surfaces "
                  "from frame to frame (expected below {:.0f} %)",
                  LayerText(*layout_, Aov::kNormal), FrameRanges(frames),
                  angle / static_cast<double>(frames.size()), 100 * turned, 100 * kMostTurned),
      cure, turned, kMostTurned, mapping});
}

}  // namespace

std::unique_ptr<Check> MakeCameraSpaceCheck() {
  return std::make_unique<CameraSpaceCheck>();
}

}  // namespace stillray::doctor
