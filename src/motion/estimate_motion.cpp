// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/estimate_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/guides.h"
#include "io/camera_fit.h"
#include "motion/align_camera.h"
#include "motion/guide_pyramid.h"
#include "motion/match_guides.h"
#include "motion/motion_field.h"
#include "motion/move_objects.h"
#include "stillray/denoise.hpp"

namespace stillray::motion {
namespace {

/// Distances of guides above this belong to different points.
constexpr float kDiffers = 0.1f;
/// If a smaller fraction of the surfaces differs under the motion of the camera, no object moves.
constexpr double kLeastDiffering = 2e-4;
/// Maximum ratio, and minimum difference, of the distances under matching and under the camera's
/// motion, in the neighbourhood of a pixel.
constexpr float kFarBetter = 0.6f;
constexpr float kBetterBy = 0.01f;
constexpr int kRadius = 3;  ///< of the surroundings
/// kUnexplained as a multiple of the median, which measures the noise of guides with motion blur.
constexpr float kUnexplainedPart = 3.0f;

/// Without a camera: if a larger fraction of the image is unknown, the rest matches by chance.
constexpr double kMostUnknown = 0.6;

/// Row by row, so that results do not depend on threads.
double MeanOf(const Image1& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += static_cast<double>(image(x, y));
    }
  }
  return sum / (static_cast<double>(image.width()) * image.height());
}

void Shift(vec2 by, Image2* motion) {
  if (by != vec2(0.0f)) {
    ForEachPixel(motion->width(), motion->height(),
                 [&](int x, int y) { Set(At(*motion, x, y) + by, x, y, motion); });
  }
}

/// The state of an estimation for two frames. All motion here is from pixel to pixel, including
/// jitter.
class Estimate {
 public:
  explicit Estimate(const EstimateInput& input);

  EstimatedMotion Run();

 private:
  uint32_t IdOf(int x, int y) const { return g_.id.empty() ? 0u : g_.id(x, y); }
  bool IsInside(int x, int y, vec2 motion) const;
  Image1 DistancesOf(const Image2& motion) const;
  Image1 Surroundings(const Image1& distances) const;
  bool Explains(const Image2& motion, const Image1& distances) const;
  bool ShowsMotion() const;
  void Match();
  void FindCamera();
  double CostOf(const Image2& motion) const;
  bool Adopt(const CameraMotion& camera, double* least);
  void Use(const CameraMotion& camera);
  void RefineCamera();
  void Choose();
  void Guess(int x, int y, bool nearer);
  void ForgetAll();
  EstimatedMotion Finish();

  const EstimateInput& input_;
  const Guides& g_;
  int width_;
  int height_;
  GuidePyramid now_;
  GuidePyramid before_;
  Image2 base_;    ///< of the camera; zero if it is unknown
  bool has_base_;  ///< whether `base_` is the motion of static surfaces
  bool found_camera_ = false;
  CameraMotion camera_;  ///< if it was found
  Image1 base_distances_;
  Matched matched_;
  Image1 agreement_;
  Image1 matched_distances_;
  MotionField field_;
};

Estimate::Estimate(const EstimateInput& input)
    : input_(input),
      g_(*input.now),
      width_(g_.depth.width()),
      height_(g_.depth.height()),
      base_(input.camera.empty() ? Image2(width_, height_) : input.camera),
      has_base_(!input.camera.empty()) {
  now_.sharp = MakeLevel(g_);
  before_.sharp = MakeLevel(*input.before);
  Shift(input.jitter - input.jitter_before, &base_);
  base_distances_ = DistancesOf(base_);
}

bool Estimate::IsInside(int x, int y, vec2 motion) const {
  const float u = static_cast<float>(x) + motion.x;
  const float v = static_cast<float>(y) + motion.y;
  return u >= 0 && v >= 0 && u <= static_cast<float>(width_ - 1) &&
         v <= static_cast<float>(height_ - 1);
}

/// The distance of each pixel's guides from those at the position given by its motion. 0 without a
/// surface.
Image1 Estimate::DistancesOf(const Image2& motion) const {
  Image1 distances(width_, height_);
  ForEachPixel(width_, height_, [&](int x, int y) {
    if (IsSurface(g_.depth(x, y))) {
      distances(x, y) =
          DistanceTo(now_.sharp, x, y, before_.sharp, static_cast<float>(x) + motion[0](x, y),
                     static_cast<float>(y) + motion[1](x, y));
    }
  });
  return distances;
}

/// Means over the neighbouring pixels of the same object.
Image1 Estimate::Surroundings(const Image1& distances) const {
  Image1 means(width_, height_);
  ForEachPixel(width_, height_, [&](int x, int y) {
    if (!IsSurface(g_.depth(x, y))) {
      return;
    }
    float sum = 0;
    float count = 0;
    for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, height_ - 1); ++v) {
      for (int u = std::max(x - kRadius, 0); u <= std::min(x + kRadius, width_ - 1); ++u) {
        const bool same = IsSurface(g_.depth(u, v)) && IdOf(u, v) == IdOf(x, y);
        sum += same ? distances(u, v) : 0.0f;
        count += same ? 1.0f : 0.0f;
      }
    }
    means(x, y) = sum / count;
  });
  return means;
}

/// Whether almost no surface that stays in the image differs.
bool Estimate::Explains(const Image2& motion, const Image1& distances) const {
  std::vector<std::pair<int64_t, int64_t>> rows(static_cast<size_t>(height_));
  ForEachPixel(width_, height_, [&](int x, int y) {
    auto& [surfaces, differing] = rows[static_cast<size_t>(y)];
    if (IsSurface(g_.depth(x, y)) && IsInside(x, y, At(motion, x, y))) {
      ++surfaces;
      differing += distances(x, y) > kDiffers;
    }
  });
  int64_t surfaces = 0;
  int64_t differing = 0;
  for (const auto& [s, d] : rows) {
    surfaces += s;
    differing += d;
  }
  return static_cast<double>(differing) <= kLeastDiffering * static_cast<double>(surfaces);
}

/// Motion of pixels with enough structure; NaN elsewhere.
Image2 Certain(const Matched& matched, const Image1& agreement) {
  constexpr float kAgreed = 0.9f;
  Image2 certain(agreement.width(), agreement.height());
  ForEachPixel(agreement.width(), agreement.height(), [&](int x, int y) {
    const bool sure = agreement(x, y) >= kAgreed && matched.structure(x, y) >= kLeastStructure;
    const float unknown = std::numeric_limits<float>::quiet_NaN();
    Set(sure ? At(matched.motion, x, y) : vec2(unknown), x, y, &certain);
  });
  return certain;
}

/// The camera's motion, fitted to most of the image: the fit with the smallest difference of guides
/// among several image sizes. Small sizes are robust, large sizes accurate.
void Estimate::FindCamera() {
  double least = CostOf(base_);
  const size_t coarsest = std::min<size_t>(2, now_.levels.size() - 1);
  const size_t finest = std::min<size_t>(1, coarsest);
  for (size_t level = coarsest + 1; level-- > finest;) {
    const Matched forth = MatchPyramids(now_, before_, Image2(), level);
    const Image1 agreement =
        AgreementOf(forth.motion, MatchPyramids(before_, now_, Image2(), level).motion);
    const std::optional<CameraMotion> camera =
        io::FitCameraMotion(Thinned(g_.depth, 1 << level), Certain(forth, agreement));
    if (camera && Adopt(*camera, &least)) {
      has_base_ = found_camera_ = true;
    }
  }
}

/// Mean squared difference of the pixels, each limited to that of an outlier. More accurate than
/// distances: interpolated between pixels.
double Estimate::CostOf(const Image2& motion) const {
  constexpr float kOutlier = 0.02f;
  Image1 costs(width_, height_);
  ForEachPixel(width_, height_, [&](int x, int y) {
    const vec2 m = At(motion, x, y);
    if (IsSurface(g_.depth(x, y)) && IsInside(x, y, m)) {
      costs(x, y) = std::min(PixelCost(now_.levels[0], before_.levels[0], x, y, m), kOutlier);
    }
  });
  return MeanOf(costs);
}

/// Uses a motion of the camera if guides differ less under it.
bool Estimate::Adopt(const CameraMotion& camera, double* least) {
  const double cost = CostOf(MotionOf(camera, g_.depth));
  if (!(cost < *least)) {
    return false;
  }
  *least = cost;
  Use(camera);
  return true;
}

void Estimate::Use(const CameraMotion& camera) {
  camera_ = camera;
  base_ = MotionOf(camera, g_.depth);
  base_distances_ = DistancesOf(base_);
}

/// Refines the motion of the camera at full size.
void Estimate::RefineCamera() {
  double least = CostOf(base_);
  for (const int thinning : {1, 2}) {
    const Image2 certain = Certain(matched_, agreement_);
    const std::optional<CameraMotion> camera =
        io::FitCameraMotion(Thinned(g_.depth, thinning), Thinned(certain, thinning));
    if (camera) {
      Adopt(*camera, &least);
    }
  }
  // The cost is biased: interpolation between pixels reduces noise, so that half-pixel motion has
  // the lowest cost.
  if (input_.antialiased) {
    Use(AlignCamera(now_.levels[0], before_.levels[0], g_.depth, camera_));
  }
}

/// Whether guides have enough structure to detect motion of the image: if not, equal guides do not
/// prove that it is static.
bool Estimate::ShowsMotion() const {
  constexpr float kShift = 2.0f;  // pixels
  for (const vec2& shift : {vec2(kShift, 0), vec2(0, kShift)}) {
    Image2 moved(width_, height_);
    moved[0].Fill(shift.x);
    moved[1].Fill(shift.y);
    if (Explains(moved, DistancesOf(moved))) {
      return false;
    }
  }
  return true;
}

void Estimate::Match() {
  Image2 back_start;
  if (has_base_) {
    back_start = ReverseMotion(base_, g_.depth);
    ForEachPixel(width_, height_, [&](int x, int y) {
      if (!IsInside(x, y, At(back_start, x, y))) {
        Set(vec2(0.0f), x, y, &back_start);
      }
    });
  }
  matched_ = MatchPyramids(now_, before_, has_base_ ? base_ : Image2());
  agreement_ = AgreementOf(matched_.motion, MatchPyramids(before_, now_, back_start).motion);
  matched_distances_ = DistancesOf(matched_.motion);
}

float MedianOf(const Image1& image) {
  std::vector<float> values;
  constexpr int kStep = 3;
  for (int y = 0; y < image.height(); y += kStep) {
    for (int x = 0; x < image.width(); x += kStep) {
      values.push_back(image(x, y));
    }
  }
  const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The motion of a pixel whose guides match under no motion. In hair and at silhouettes guides are
/// random, and a history along the most likely motion is better than none.
/// \param nearer  guides differ less under the matched motion than under the camera's
void Estimate::Guess(int x, int y, bool nearer) {
  const vec2 guess = nearer ? At(matched_.motion, x, y) : At(base_, x, y);
  field_.source(x, y) = kUnknown;
  Set(has_base_ ? guess : UnknownMotion(width_, height_), x, y, &field_.motion);
}

/// The motion of each pixel, independent of others.
void Estimate::Choose() {
  const Image1 base = Surroundings(base_distances_);
  const Image1 matched = Surroundings(matched_distances_);
  const float limit =
      std::max(kUnexplained, kUnexplainedPart * MedianOf(has_base_ ? base : matched));
  field_.motion = Image2(width_, height_);
  field_.confidence = Image1(width_, height_);
  field_.source = Plane<uint8_t>(width_, height_);
  ForEachPixel(width_, height_, [&](int x, int y) {
    const float b = base(x, y);
    const float m = matched(x, y);
    const bool agreed = agreement_(x, y) >= kLeastAgreement;
    const bool better = agreed && (!has_base_ || m < kFarBetter * b - kBetterBy);
    const float cost = better ? m : b;
    const bool known = better || has_base_;
    const bool leaves = !better && has_base_ && !IsInside(x, y, At(base_, x, y));
    if (!known || (cost > limit && !leaves)) {
      Guess(x, y, agreed && m < b);
      return;
    }
    field_.source(x, y) = better ? kMatched : kBase;
    Set(At(better ? matched_.motion : base_, x, y), x, y, &field_.motion);
    field_.confidence(x, y) = std::max(1 - cost / limit, 0.0f) * (better ? agreement_(x, y) : 1.0f);
  });
}

void Estimate::ForgetAll() {
  field_.source.Fill(kUnknown);
  field_.confidence.Fill(0);
  field_.motion[0].Fill(UnknownMotion(width_, height_).x);
  field_.motion[1].Fill(UnknownMotion(width_, height_).y);
}

EstimatedMotion Estimate::Finish() {
  EstimatedMotion result;
  int64_t counts[4] = {};
  int64_t surfaces = 0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (IsSurface(g_.depth(x, y))) {
        ++surfaces;
        ++counts[field_.source(x, y)];
      }
    }
  }
  const auto part = [&](Source source) {
    return surfaces == 0 ? 0.0
                         : static_cast<double>(counts[source]) / static_cast<double>(surfaces);
  };
  result.matched = part(kMatched);
  result.of_objects = part(kObject);
  result.unknown = part(kUnknown);
  result.found_camera = found_camera_;
  Shift(input_.jitter_before - input_.jitter, &field_.motion);
  result.motion = std::move(field_.motion);
  result.confidence = std::move(field_.confidence);
  return result;
}

EstimatedMotion Estimate::Run() {
  if (Explains(base_, base_distances_)) {
    const bool known = has_base_ || ShowsMotion();
    field_.motion = std::move(base_);
    field_.confidence = Image1(width_, height_);
    field_.source = Plane<uint8_t>(width_, height_);
    field_.confidence.Fill(1);
    field_.source.Fill(kBase);
    if (!known) {
      ForgetAll();
    }
    return Finish();
  }
  now_ = MakePyramid(std::move(now_.sharp));
  before_ = MakePyramid(std::move(before_.sharp));
  if (!has_base_) {
    FindCamera();
  }
  Match();
  if (found_camera_) {
    RefineCamera();
  }
  Choose();
  if (has_base_) {
    MoveObjects(
        {g_, now_, before_, base_, base_distances_, matched_, agreement_, matched_distances_},
        &field_);
    return Finish();
  }
  EstimatedMotion result = Finish();
  if (result.unknown > kMostUnknown) {
    field_.motion = std::move(result.motion);
    field_.confidence = std::move(result.confidence);
    ForgetAll();
    result = Finish();
  }
  return result;
}

}  // namespace

EstimatedMotion EstimateMotion(const EstimateInput& input) {
  return Estimate(input).Run();
}

}  // namespace stillray::motion
