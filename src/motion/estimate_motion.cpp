// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/estimate_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "io/camera_fit.h"
#include "motion/guide_pyramid.h"
#include "motion/match_guides.h"
#include "stillray/denoise.hpp"

namespace stillray::motion {
namespace {

constexpr int kRowsPerTask = 16;
/// Distances of guides above this are not those of one place on a surface.
constexpr float kDiffers = 0.1f;
/// If fewer surfaces than this differ under the motion of the camera, nothing moves by itself.
constexpr double kLeastDiffering = 2e-4;
/// Matching must explain the surroundings of a pixel by this much better than the camera's motion.
constexpr float kFarBetter = 0.6f;
constexpr float kBetterBy = 0.01f;
constexpr float kLeastAgreement = 0.5f;
constexpr int kRadius = 3;  ///< of the surroundings
/// Distance of the surroundings above which nothing explains them ...
constexpr float kUnexplained = 0.25f;
/// ... and as a multiple of the median, which is the noise of guides with motion blur.
constexpr float kUnexplainedPart = 3.0f;

/// Without a camera: if more of the picture than this is unknown, the rest matches by chance.
constexpr double kMostUnknown = 0.6;

// Objects that move by themselves.
constexpr int kLeastPixels = 64;
/// Part of the pixels of an object that must move by themselves for it to move as a whole, ...
constexpr double kLeastMoving = 0.05;
/// ... and below which its other pixels stand still: jagged textures that repeat match elsewhere
/// too.
constexpr double kStill = 0.25;
/// Without ids: the same for the pixels within kStillRadius.
constexpr int kStillRadius = 8;
constexpr int kStillPart = 4;
/// The motion of an object as a whole explains it by this much better than the camera's.
constexpr double kObjectBetter = 0.7;
/// ... and hardly worse than that of its single pixels.
constexpr double kObjectWorse = 1.25;
constexpr double kObjectSlack = 0.005;

bool IsSurface(float depth) {
  return depth > 0 && std::isfinite(depth);
}

vec2 At(const Image2& motion, int x, int y) {
  return {motion[0](x, y), motion[1](x, y)};
}

void Set(vec2 value, int x, int y, Image2* motion) {
  (*motion)[0](x, y) = value.x;
  (*motion)[1](x, y) = value.y;
}

/// Row by row, so that the bits do not depend on threads.
double MeanOf(const Image1& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      sum += static_cast<double>(image(x, y));
    }
  }
  return sum / (static_cast<double>(image.width()) * image.height());
}

template <typename Body>
void ForEachPixel(int width, int height, const Body& body) {
  ParallelRows(height, kRowsPerTask, [&](int y0, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = 0; x < width; ++x) {
        body(x, y);
      }
    }
  });
}

void Shift(vec2 by, Image2* motion) {
  if (by != vec2(0.0f)) {
    ForEachPixel(motion->width(), motion->height(),
                 [&](int x, int y) { Set(At(*motion, x, y) + by, x, y, motion); });
  }
}

enum Source : uint8_t { kBase, kMatched, kObject, kUnknown };

/// The pixels of an object.
struct Box {
  int left = std::numeric_limits<int>::max();
  int top = std::numeric_limits<int>::max();
  int right = -1;
  int bottom = -1;
  int pixels = 0;
  int moving = 0;
};

/// The pixels of an object in the picture around it.
struct Cutout {
  Image1 depth;   ///< 0 where something else is seen
  Image2 motion;  ///< not a number where it is uncertain
};

/// Two frames while their motion is estimated. All motion here leads from pixel to pixel, with
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
  bool Adopt(Image2 base, double* least);
  void RefineCamera();
  void Choose();
  void StandStill(int x, int y);
  void RemoveSpecks();
  void MoveObjects();
  struct Misfit {
    double squares = 0;
    double distances = 0;
  };
  Cutout Cut(uint32_t id, const Box& box) const;
  Misfit MisfitOf(const Cutout& cutout, const Box& box, const Image2& motion) const;
  void MoveObject(uint32_t id, const Box& box);
  void ForgetAll();
  EstimatedMotion Finish();

  const EstimateInput& input_;
  const Guides& g_;
  int width_;
  int height_;
  GuidePyramid now_;
  GuidePyramid before_;
  Image2 base_;    ///< of the camera; zero if it is unknown
  bool has_base_;  ///< whether still surfaces move so
  bool found_camera_ = false;
  Image1 base_distances_;
  Matched matched_;
  Image1 agreement_;
  Image1 matched_distances_;
  Image2 motion_;
  Image1 confidence_;
  Plane<uint8_t> source_;
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

/// How much each pixel differs from where its motion leads. 0 without a surface.
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

/// Means over the pixels around that show the same object.
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

/// Whether hardly any surface that stays in the picture differs.
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

/// The motion that the camera gives each pixel of a frame with this depth.
Image2 MotionOf(const io::CameraMotion& camera, const Image1& depth) {
  const int width = depth.width();
  const int height = depth.height();
  Image2 result(width, height);
  ForEachPixel(width, height, [&](int x, int y) {
    const vec2 p =
        io::PicturePoint(width, height, static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
    const vec2 motion = camera.MotionOf(p, static_cast<double>(depth(x, y)), width);
    const bool valid = std::isfinite(motion.x + motion.y);
    Set(valid ? motion : UnknownMotion(width, height), x, y, &result);
  });
  return result;
}

/// Every n-th pixel of depth, and of motion in pixels of the smaller picture.
Image1 Thinned(const Image1& depth, int n) {
  Image1 thin((depth.width() + n - 1) / n, (depth.height() + n - 1) / n);
  ForEachPixel(thin.width(), thin.height(),
               [&](int x, int y) { thin(x, y) = depth(n * x, n * y); });
  return thin;
}

Image2 Thinned(const Image2& motion, int n) {
  Image2 thin;
  for (int c = 0; c < 2; ++c) {
    thin[c] = Thinned(motion[c], n);
  }
  ForEachPixel(thin.width(), thin.height(),
               [&](int x, int y) { Set(At(thin, x, y) / static_cast<float>(n), x, y, &thin); });
  return thin;
}

/// Where guides tell little, motion is that of the surroundings.
constexpr float kLeastStructure = 0.01f;

/// Motion of pixels that are clearly seen, not a number elsewhere.
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

/// The motion of the camera as most of the picture reveals it: of several sizes of the picture that
/// under which the guides differ least. Small ones are robust, large ones exact.
void Estimate::FindCamera() {
  double least = CostOf(base_);
  const size_t coarsest = std::min<size_t>(2, now_.levels.size() - 1);
  const size_t finest = std::min<size_t>(1, coarsest);
  for (size_t level = coarsest + 1; level-- > finest;) {
    const Matched forth = MatchPyramids(now_, before_, Image2(), level);
    const Image1 agreement =
        AgreementOf(forth.motion, MatchPyramids(before_, now_, Image2(), level).motion);
    const std::optional<io::CameraMotion> camera =
        io::FitCameraMotion(Thinned(g_.depth, 1 << level), Certain(forth, agreement));
    if (camera && Adopt(MotionOf(*camera, g_.depth), &least)) {
      has_base_ = found_camera_ = true;
    }
  }
}

/// Mean squared difference of the pixels, of each at most that of an outlier. Finer than distances:
/// between pixels.
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
bool Estimate::Adopt(Image2 base, double* least) {
  const double cost = CostOf(base);
  if (!(cost < *least)) {
    return false;
  }
  *least = cost;
  base_ = std::move(base);
  base_distances_ = DistancesOf(base_);
  return true;
}

/// The motion of the camera once more, in full size.
void Estimate::RefineCamera() {
  double least = CostOf(base_);
  for (const int thinning : {1, 2}) {
    const Image2 certain = Certain(matched_, agreement_);
    const std::optional<io::CameraMotion> camera =
        io::FitCameraMotion(Thinned(g_.depth, thinning), Thinned(certain, thinning));
    if (camera) {
      Adopt(MotionOf(*camera, g_.depth), &least);
    }
  }
}

/// Whether guides would show it if the picture had moved: if not, they are no proof that it stands
/// still.
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

/// The motion of each pixel by itself.
void Estimate::Choose() {
  const Image1 base = Surroundings(base_distances_);
  const Image1 matched = Surroundings(matched_distances_);
  const float limit =
      std::max(kUnexplained, kUnexplainedPart * MedianOf(has_base_ ? base : matched));
  motion_ = Image2(width_, height_);
  confidence_ = Image1(width_, height_);
  source_ = Plane<uint8_t>(width_, height_);
  ForEachPixel(width_, height_, [&](int x, int y) {
    const float b = base(x, y);
    const float m = matched(x, y);
    const bool agreed = agreement_(x, y) >= kLeastAgreement;
    const bool better = agreed && (!has_base_ || m < kFarBetter * b - kBetterBy);
    const float cost = better ? m : b;
    const bool known = better || has_base_;
    const bool leaves = !better && has_base_ && !IsInside(x, y, At(base_, x, y));
    if (!known || (cost > limit && !leaves)) {
      source_(x, y) = kUnknown;
      Set(UnknownMotion(width_, height_), x, y, &motion_);
      return;
    }
    source_(x, y) = better ? kMatched : kBase;
    Set(At(better ? matched_.motion : base_, x, y), x, y, &motion_);
    confidence_(x, y) = std::max(1 - cost / limit, 0.0f) * (better ? agreement_(x, y) : 1.0f);
  });
}

Cutout Estimate::Cut(uint32_t id, const Box& box) const {
  const int width = box.right - box.left + 1;
  const int height = box.bottom - box.top + 1;
  Cutout cutout = {Image1(width, height), Image2(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int px = box.left + x;
      const int py = box.top + y;
      const bool own = g_.id(px, py) == id && IsSurface(g_.depth(px, py));
      const bool sure = own && agreement_(px, py) >= kLeastAgreement &&
                        matched_.structure(px, py) >= kLeastStructure;
      cutout.depth(x, y) = own ? g_.depth(px, py) : 0.0f;
      Set(sure ? At(matched_.motion, px, py) : vec2(std::numeric_limits<float>::quiet_NaN()), x, y,
          &cutout.motion);
    }
  }
  return cutout;
}

/// How an object differs under the motion of its cutout: squared differences between pixels, and
/// distances as everywhere here.
Estimate::Misfit Estimate::MisfitOf(const Cutout& cutout, const Box& box,
                                    const Image2& motion) const {
  Misfit sum;
  for (int y = 0; y < cutout.depth.height(); ++y) {
    for (int x = 0; x < cutout.depth.width(); ++x) {
      if (cutout.depth(x, y) > 0) {
        const int px = box.left + x;
        const int py = box.top + y;
        const vec2 m = At(motion, x, y);
        sum.squares += static_cast<double>(PixelCost(now_.levels[0], before_.levels[0], px, py, m));
        sum.distances += static_cast<double>(DistanceTo(now_.sharp, px, py, before_.sharp,
                                                        static_cast<float>(px) + m.x,
                                                        static_cast<float>(py) + m.y));
      }
    }
  }
  return sum;
}

/// Each point of a rigid object moves like one of a still scene before another camera. Of fits to
/// the matched motion in several sizes, the one under which the object differs least is used, if it
/// explains the object better than the camera does.
void Estimate::MoveObject(uint32_t id, const Box& box) {
  const Cutout cutout = Cut(id, box);
  std::optional<Image2> best;
  Misfit least;
  const auto consider = [&](Image2 motion) {
    const Misfit misfit = MisfitOf(cutout, box, motion);
    if (!best || misfit.squares < least.squares) {
      best = std::move(motion);
      least = misfit;
    }
  };
  for (const int thinning : {1, 2, 4}) {
    const std::optional<io::CameraMotion> fit =
        io::FitCameraMotion(Thinned(cutout.depth, thinning), Thinned(cutout.motion, thinning));
    if (fit) {
      consider(MotionOf(*fit, cutout.depth));
    }
  }
  if (!best) {
    return;
  }
  double base = 0;
  double matched = 0;
  for (int y = 0; y < cutout.depth.height(); ++y) {
    for (int x = 0; x < cutout.depth.width(); ++x) {
      if (cutout.depth(x, y) > 0) {
        base += static_cast<double>(base_distances_(box.left + x, box.top + y));
        matched += static_cast<double>(matched_distances_(box.left + x, box.top + y));
      }
    }
  }
  const double slack = kObjectSlack * box.pixels;
  if (!(least.distances < kObjectBetter * base &&
        least.distances < kObjectWorse * matched + slack)) {
    return;
  }
  const auto cost = static_cast<float>(least.distances / box.pixels);
  for (int y = 0; y < cutout.depth.height(); ++y) {
    for (int x = 0; x < cutout.depth.width(); ++x) {
      if (cutout.depth(x, y) > 0) {
        Set(At(*best, x, y), box.left + x, box.top + y, &motion_);
        source_(box.left + x, box.top + y) = kObject;
        confidence_(box.left + x, box.top + y) = std::clamp(1 - cost / kUnexplained, 0.1f, 1.0f);
      }
    }
  }
}

void Estimate::StandStill(int x, int y) {
  if (source_(x, y) == kMatched || source_(x, y) == kUnknown) {
    source_(x, y) = kBase;
    Set(At(base_, x, y), x, y, &motion_);
    confidence_(x, y) = std::max(1 - base_distances_(x, y) / kMostDistance, 0.0f);
  }
}

/// Single pixels that seem to move by themselves stand still.
void Estimate::RemoveSpecks() {
  Image1 sums(width_, height_);  // of the pixels of a row within the radius
  const auto moves = [&](int x, int y) { return source_(x, y) != kBase; };
  ForEachPixel(width_, height_, [&](int x, int y) {
    for (int u = std::max(x - kStillRadius, 0); u <= std::min(x + kStillRadius, width_ - 1); ++u) {
      sums(x, y) += moves(u, y) ? 1.0f : 0.0f;
    }
  });
  Plane<uint8_t> specks(width_, height_);
  constexpr int kSide = 2 * kStillRadius + 1;
  ForEachPixel(width_, height_, [&](int x, int y) {
    float moving = 0;
    for (int v = std::max(y - kStillRadius, 0); v <= std::min(y + kStillRadius, height_ - 1); ++v) {
      moving += sums(x, v);
    }
    specks(x, y) = moving * kStillPart < static_cast<float>(kSide * kSide);
  });
  ForEachPixel(width_, height_, [&](int x, int y) {
    if (specks(x, y) != 0) {
      StandStill(x, y);
    }
  });
}

/// Objects of which a part moves by itself are likely to move as a whole, plain parts too.
void Estimate::MoveObjects() {
  if (g_.id.empty()) {
    RemoveSpecks();
    return;
  }
  std::map<uint32_t, Box> boxes;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (!IsSurface(g_.depth(x, y)) || g_.id(x, y) == 0) {
        continue;
      }
      Box& box = boxes[g_.id(x, y)];
      box.left = std::min(box.left, x);
      box.right = std::max(box.right, x);
      box.top = std::min(box.top, y);
      box.bottom = std::max(box.bottom, y);
      ++box.pixels;
      box.moving += source_(x, y) != kBase;
    }
  }
  for (const auto& [id, box] : boxes) {
    if (box.pixels >= kLeastPixels &&
        static_cast<double>(box.moving) >= kLeastMoving * static_cast<double>(box.pixels)) {
      MoveObject(id, box);
    }
  }
  ForEachPixel(width_, height_, [&](int x, int y) {
    const auto at = boxes.find(g_.id(x, y));
    if (at != boxes.end() &&
        static_cast<double>(at->second.moving) < kStill * static_cast<double>(at->second.pixels)) {
      StandStill(x, y);
    }
  });
}

void Estimate::ForgetAll() {
  source_.Fill(kUnknown);
  confidence_.Fill(0);
  motion_[0].Fill(UnknownMotion(width_, height_).x);
  motion_[1].Fill(UnknownMotion(width_, height_).y);
}

EstimatedMotion Estimate::Finish() {
  EstimatedMotion result;
  int64_t counts[4] = {};
  int64_t surfaces = 0;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (IsSurface(g_.depth(x, y))) {
        ++surfaces;
        ++counts[source_(x, y)];
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
  Shift(input_.jitter_before - input_.jitter, &motion_);
  result.motion = std::move(motion_);
  result.confidence = std::move(confidence_);
  return result;
}

EstimatedMotion Estimate::Run() {
  if (Explains(base_, base_distances_)) {
    const bool known = has_base_ || ShowsMotion();
    motion_ = std::move(base_);
    confidence_ = Image1(width_, height_);
    source_ = Plane<uint8_t>(width_, height_);
    confidence_.Fill(1);
    source_.Fill(kBase);
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
    MoveObjects();
    return Finish();
  }
  EstimatedMotion result = Finish();
  if (result.unknown > kMostUnknown) {
    motion_ = std::move(result.motion);
    confidence_ = std::move(result.confidence);
    ForgetAll();
    result = Finish();
  }
  return result;
}

}  // namespace

EstimatedMotion EstimateMotion(const EstimateInput& input) {
  return Estimate(input).Run();
}

vec2 UnknownMotion(int width, int height) {
  return {2.0f * static_cast<float>(width), 2.0f * static_cast<float>(height)};
}

}  // namespace stillray::motion
