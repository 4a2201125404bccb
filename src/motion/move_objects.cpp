// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "motion/move_objects.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "io/camera_fit.h"

namespace stillray::motion {
namespace {

constexpr int kLeastPixels = 64;
/// Minimum fraction of an object's pixels that move for a rigid motion of the object.
constexpr double kLeastMoving = 0.05;
/// Fraction of moving pixels below which the other pixels are static: jagged, repeating textures
/// match elsewhere too.
constexpr double kStill = 0.25;
/// Without ids: this fraction for the pixels within kStillRadius.
constexpr int kStillRadius = 8;
constexpr int kStillPart = 4;
/// Maximum ratio of the cost of a rigid motion to that of the camera's motion.
constexpr double kObjectBetter = 0.7;
/// Maximum ratio of the cost of a rigid motion to that of matching, and slack per pixel.
constexpr double kObjectWorse = 1.25;
constexpr double kObjectSlack = 0.005;

/// The pixels of an object.
struct Box {
  int left = std::numeric_limits<int>::max();
  int top = std::numeric_limits<int>::max();
  int right = -1;
  int bottom = -1;
  int pixels = 0;
  int moving = 0;
};

/// The pixels of an object, in its bounding rectangle.
struct Cutout {
  Image1 depth;   ///< 0 at pixels of other objects
  Image2 motion;  ///< NaN where it is uncertain
};

/// The differences of an object under a motion, summed over its pixels: squared differences with
/// interpolation, and distances as in DistanceTo.
struct Misfit {
  double squares = 0;
  double distances = 0;
};

class Objects {
 public:
  Objects(const MatchedFrames& frames, MotionField* field)
      : frames_(frames),
        g_(frames.guides),
        width_(g_.depth.width()),
        height_(g_.depth.height()),
        field_(field) {}

  void Move();

 private:
  Cutout Cut(uint32_t id, const Box& box) const;
  Misfit MisfitOf(const Cutout& cutout, const Box& box, const Image2& motion) const;
  void MoveObject(uint32_t id, const Box& box);
  void StandStill(int x, int y);
  void RemoveSpecks();

  const MatchedFrames& frames_;
  const Guides& g_;
  int width_;
  int height_;
  MotionField* field_;
};

Cutout Objects::Cut(uint32_t id, const Box& box) const {
  const int width = box.right - box.left + 1;
  const int height = box.bottom - box.top + 1;
  Cutout cutout = {Image1(width, height), Image2(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int px = box.left + x;
      const int py = box.top + y;
      const bool own = g_.id(px, py) == id && IsSurface(g_.depth(px, py));
      const bool sure = own && frames_.agreement(px, py) >= kLeastAgreement &&
                        frames_.matched.structure(px, py) >= kLeastStructure;
      cutout.depth(x, y) = own ? g_.depth(px, py) : 0.0f;
      Set(sure ? At(frames_.matched.motion, px, py) : vec2(std::numeric_limits<float>::quiet_NaN()),
          x, y, &cutout.motion);
    }
  }
  return cutout;
}

Misfit Objects::MisfitOf(const Cutout& cutout, const Box& box, const Image2& motion) const {
  Misfit sum;
  for (int y = 0; y < cutout.depth.height(); ++y) {
    for (int x = 0; x < cutout.depth.width(); ++x) {
      if (cutout.depth(x, y) > 0) {
        const int px = box.left + x;
        const int py = box.top + y;
        const vec2 m = At(motion, x, y);
        sum.squares += static_cast<double>(
            PixelCost(frames_.now.levels[0], frames_.before.levels[0], px, py, m));
        sum.distances += static_cast<double>(
            DistanceTo(frames_.now.sharp, px, py, frames_.before.sharp,
                       static_cast<float>(px) + m.x, static_cast<float>(py) + m.y));
      }
    }
  }
  return sum;
}

/// A rigid object moves like a static scene under another camera. Of fits to the matched motion at
/// several sizes, the one with the smallest difference is used, if it fits the object better than
/// the camera's motion.
void Objects::MoveObject(uint32_t id, const Box& box) {
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
    const std::optional<CameraMotion> fit =
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
        base += static_cast<double>(frames_.base_distances(box.left + x, box.top + y));
        matched += static_cast<double>(frames_.matched_distances(box.left + x, box.top + y));
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
        Set(At(*best, x, y), box.left + x, box.top + y, &field_->motion);
        field_->source(box.left + x, box.top + y) = kObject;
        field_->confidence(box.left + x, box.top + y) =
            std::clamp(1 - cost / kUnexplained, 0.1f, 1.0f);
      }
    }
  }
}

void Objects::StandStill(int x, int y) {
  if (field_->source(x, y) == kMatched || field_->source(x, y) == kUnknown) {
    field_->source(x, y) = kBase;
    Set(At(frames_.base, x, y), x, y, &field_->motion);
    field_->confidence(x, y) = std::max(1 - frames_.base_distances(x, y) / kMostDistance, 0.0f);
  }
}

/// Isolated pixels with independent motion are treated as static.
void Objects::RemoveSpecks() {
  Image1 sums(width_, height_);  // of the pixels of a row within the radius
  const auto moves = [&](int x, int y) { return field_->source(x, y) != kBase; };
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

void Objects::Move() {
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
      box.moving += field_->source(x, y) != kBase;
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

}  // namespace

void MoveObjects(const MatchedFrames& frames, MotionField* field) {
  Objects(frames, field).Move();
}

}  // namespace stillray::motion
