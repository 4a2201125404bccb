// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds missing or wrong motion by block matching: blocks are searched for in the previous frame,
// around the position given by their motion.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "core/median.h"
#include "core/parallel.h"
#include "core/pixels.h"
#include "doctor/check.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int kBlock = 16;
constexpr int kReach = 12;            ///< pixels searched in each direction
constexpr int kCoarse = 2;            ///< step of the search; then by single pixels around the best
constexpr size_t kMostSearches = 96;  ///< blocks searched for per pair of frames
constexpr int kLeastStructured = 12;
/// Mean distance above which a block does not match at the position given by its motion. Clean
/// sequences: 95 % of the blocks below 0.05.
constexpr float kUnexplained = 0.1f;
/// A block matches elsewhere if its distance there is below this fraction.
constexpr float kFound = 0.35f;
/// Fraction of the blocks with structure that match elsewhere. Clean: at most 0.04 measured
/// (jittered, small images); zero or clamped motion: 0.3. Repeating blocks, and large plain ones,
/// match under wrong motion too.
constexpr double kMovedAlthoughZero = 0.1;
constexpr double kMovedElsewhere = 0.15;
constexpr double kAgreement = 0.7;
/// Offsets are a zoom if this fraction of the blocks of all frames lies within this many pixels of
/// the prediction. Repeating textures also match elsewhere: 0.76 to 1 measured in Cycles, 0.73 in
/// checkered rooms.
constexpr double kZoomAgreement = 0.65;
constexpr double kZoomTolerance = 1.5;
constexpr double kLeastZoom = 0.005;
/// Minimum number of blocks: fewer blocks, or blocks on one side only, fit any zoom.
constexpr int kLeastZoomed = 6;

struct Block {
  int x = 0;
  int y = 0;
  float distance = 0;  ///< under its motion
};

/// Mean distance of a block displaced by its pixels' motion plus (dx, dy).
float BlockDistance(const Exhibit& now, const Exhibit& before, const Features& a, const Features& b,
                    const Block& block, int dx, int dy) {
  float sum = 0;
  for (int y = block.y; y < block.y + kBlock; y += 2) {
    for (int x = block.x; x < block.x + kBlock; x += 2) {
      const vec2 m = MotionAt(now.frame, x, y);
      const vec2 finite = std::isfinite(m.x + m.y) ? m : vec2(0.0f);
      const vec2 shifted = finite + vec2(static_cast<float>(dx), static_cast<float>(dy));
      sum += a.DistanceAt(x, y, b, PlaceBefore(now, before, x, y, shifted));
    }
  }
  return sum / ((kBlock / 2) * (kBlock / 2));
}

/// Whether a slightly shifted block differs from itself; otherwise it cannot be located.
bool HasStructure(const Features& f, int x0, int y0) {
  constexpr int kShift = 4;
  float right = 0;
  float down = 0;
  for (int y = y0; y < y0 + kBlock; y += 2) {
    for (int x = x0; x < x0 + kBlock; x += 2) {
      right += f.Distance(x, y, f, std::min(x + kShift, f.width() - 1), y);
      down += f.Distance(x, y, f, x, std::min(y + kShift, f.height() - 1));
    }
  }
  constexpr float kCount = (kBlock / 2) * (kBlock / 2);
  return std::min(right, down) > kUnexplained * kCount;
}

/// The offset of the best match from the position given by the block's motion.
struct Search {
  int dx = 0;
  int dy = 0;
  float distance = 0;

  void Try(int x, int y, float d) {
    if (d < distance) {
      *this = {x, y, d};
    }
  }
};

Search SearchFor(const Exhibit& now, const Exhibit& before, const Features& a, const Features& b,
                 const Block& block) {
  Search best{0, 0, block.distance};
  for (int dy = -kReach; dy <= kReach; dy += kCoarse) {
    for (int dx = -kReach; dx <= kReach; dx += kCoarse) {
      best.Try(dx, dy, BlockDistance(now, before, a, b, block, dx, dy));
    }
  }
  const Search coarse = best;
  for (int dy = coarse.dy - 1; dy <= coarse.dy + 1; ++dy) {
    for (int dx = coarse.dx - 1; dx <= coarse.dx + 1; ++dx) {
      best.Try(dx, dy, BlockDistance(now, before, a, b, block, dx, dy));
    }
  }
  return best;
}

/// Fits a zoom to the offsets of blocks: offset = rate * position, with the position relative to
/// the image centre.
class ZoomFit {
 public:
  void Add(const Frame& frame, const Block& block, const Search& s) {
    places_.push_back({block.x + 0.5 * kBlock - 0.5 * frame.width,
                       block.y + 0.5 * kBlock - 0.5 * frame.height, static_cast<double>(s.dx),
                       static_cast<double>(s.dy)});
  }
  /// The median over the blocks, as single blocks match at wrong positions.
  double Rate() const {
    std::vector<double> rates;
    for (const Place& p : places_) {
      rates.push_back((p.dx * p.x + p.dy * p.y) / std::max(p.x * p.x + p.y * p.y, 1.0));
    }
    return Median(std::move(rates));
  }
  int places() const { return static_cast<int>(places_.size()); }
  /// Number of blocks near their predicted offset; 0 if they are too few, or all on one side of the
  /// image.
  int Explained() const {
    const double rate = Rate();
    bool quarters[4] = {false, false, false,
                        false};  // of the image, with blocks near their predicted offset
    int agree = 0;
    for (const Place& p : places_) {
      if (std::hypot(p.dx - rate * p.x, p.dy - rate * p.y) < kZoomTolerance) {
        ++agree;
        quarters[(p.x > 0 ? 1 : 0) + (p.y > 0 ? 2 : 0)] = true;
      }
    }
    const bool everywhere = std::count(std::begin(quarters), std::end(quarters), true) >= 3;
    return std::fabs(rate) > kLeastZoom && agree >= kLeastZoomed && everywhere ? agree : 0;
  }

 private:
  struct Place {
    double x;  ///< of the block, from the image centre
    double y;
    double dx;  ///< where it was found
    double dy;
  };
  std::vector<Place> places_;
};

bool IsZero(const Frame& frame) {
  return !AnyPixel(frame.guides.motion, [](float v) { return std::fabs(v) > 1e-3f; });
}

class StillMotionCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Pair {
    int64_t number = 0;
    bool zero = false;
    double moved = 0;   ///< fraction of the blocks with structure
    double length = 0;  ///< mean offset of these blocks, pixels
    int found = 0;      ///< number of blocks that match elsewhere
    int zoomed = 0;     ///< number of these blocks that fit a zoom
    double zoom = 0;    ///< relative growth of the image
  };
  bool IsZoom(double* zoom) const;
  const AovLayout* layout_ = nullptr;
  std::vector<Pair> pairs_;
};

void StillMotionCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  if (before == nullptr || now.frame.guides.motion.empty()) {
    return;
  }
  const Features a(now);
  const Features b(*before);
  if (!a.of_guides() || !b.of_guides()) {
    return;
  }
  std::vector<Block> unexplained;
  int structured = 0;
  for (int y = 0; y + kBlock <= now.frame.height; y += kBlock) {
    for (int x = 0; x + kBlock <= now.frame.width; x += kBlock) {
      if (!HasStructure(a, x, y)) {
        continue;
      }
      ++structured;
      Block block{x, y, 0};
      block.distance = BlockDistance(now, *before, a, b, block, 0, 0);
      if (block.distance > kUnexplained) {
        unexplained.push_back(block);
      }
    }
  }
  if (structured < kLeastStructured) {
    return;
  }
  const size_t stride = (unexplained.size() + kMostSearches - 1) / kMostSearches;
  std::vector<Search> found(stride == 0 ? 0 : (unexplained.size() + stride - 1) / stride);
  ParallelRows(static_cast<int>(found.size()), 1, [&](int i, int) {
    found[static_cast<size_t>(i)] =
        SearchFor(now, *before, a, b, unexplained[static_cast<size_t>(i) * stride]);
  });
  int moved = 0;
  double length = 0;
  ZoomFit fit;
  for (size_t i = 0; i < found.size(); ++i) {
    const Search& s = found[i];
    if (s.distance < kFound * unexplained[i * stride].distance &&
        std::max(std::abs(s.dx), std::abs(s.dy)) >= 2) {
      ++moved;
      length += std::hypot(s.dx, s.dy);
      fit.Add(now.frame, unexplained[i * stride], s);
    }
  }
  pairs_.push_back({now.number, IsZero(now.frame),
                    static_cast<double>(moved) * static_cast<double>(stride) / structured,
                    moved > 0 ? length / moved : 0, fit.places(), fit.Explained(), -fit.Rate()});
}

/// \param zoom  [out] mean over the pairs
bool StillMotionCheck::IsZoom(double* zoom) const {
  int64_t pairs = 0;
  int64_t zoomed = 0;
  int64_t found = 0;
  *zoom = 0;
  for (const Pair& pair : pairs_) {
    pairs += pair.zoomed > 0;
    zoomed += pair.zoomed;
    found += pair.found;
    *zoom += pair.zoom / static_cast<double>(pairs_.size());
  }
  return !pairs_.empty() &&
         static_cast<double>(pairs) >= kAgreement * static_cast<double>(pairs_.size()) &&
         static_cast<double>(zoomed) >= kZoomAgreement * static_cast<double>(found);
}

void StillMotionCheck::Conclude(Verdict* verdict) {
  const auto conclude = [&](bool zero, double limit, const char* name, const std::string& what,
                            const std::string& cure) {
    std::vector<int64_t> frames;
    int64_t judged = 0;
    double moved = 0;
    double length = 0;
    for (const Pair& pair : pairs_) {
      if (pair.zero != zero) {
        continue;
      }
      ++judged;
      moved += pair.moved;
      if (pair.moved >= limit) {
        frames.push_back(pair.number);
        length += pair.length;
      }
    }
    if (judged == 0) {
      return;
    }
    moved /= static_cast<double>(judged);
    const bool broken = !frames.empty() && static_cast<double>(frames.size()) >=
                                               kAgreement * static_cast<double>(judged);
    verdict->Add(Measure{std::string(name) + "_blocks", moved, limit, broken, judged});
    if (!broken || verdict->Has("motion_")) {
      return;
    }
    verdict->Add(Finding{
        name, frames,
        fmt::format("motion in {} {} in {}: {:.0f} % of the blocks with structure are found about "
                    "{:.1f} pixels from there (expected below {:.0f} %)",
                    LayerText(*layout_, Aov::kMotion), what, FrameRanges(frames), 100 * moved,
                    length / static_cast<double>(frames.size()), 100 * limit),
        cure, moved, limit, ""});
  };
  if (layout_ == nullptr) {
    return;
  }
  const bool blender = layout_->renderer == "blender";
  const bool own = layout_->renderer == "stillray";
  conclude(
      true, kMovedAlthoughZero, "motion_zero", "is zero everywhere, but the picture moves",
      blender
          ? "stillray denoise derives motion where it is zero (--motion auto; best with the "
            "cameras, --cameras FILE.json, and with Cryptomatte Object or Object Index). Vector "
            "is zero where Render Properties > Motion Blur is on; with few samples edges stay "
            "less noisy without it, and blur can follow (stillray denoise --post motion_blur)"
      : own ? "motion in layers named as stillray's own is used as it is: write the true "
              "motion, or derive it (stillray denoise --motion estimate)"
            : "stillray denoise derives motion where it is zero (--motion auto; best with the "
              "cameras: --cameras FILE.json); or switch on the motion output (in some "
              "renderers: motion blur with an instantaneous shutter)");
  double zoom = 0;
  if (IsZoom(&zoom)) {
    conclude(false, kMovedElsewhere, "motion_zoom",
             fmt::format("leaves out that the picture {} by {:.1f} % a frame (a zoom)",
                         zoom > 0 ? "grows" : "shrinks", 100 * std::fabs(zoom)),
             blender ? "Blender leaves an animated Focal Length out of Vector: move the camera "
                       "instead, or render with one Focal Length and zoom in the compositor; or "
                       "replace motion: stillray denoise with --motion estimate, and --cameras "
                       "FILE.json if possible"
                     : "project motion with the lens of each frame, or zoom after denoising; or "
                       "replace motion: stillray denoise with --motion estimate, and --cameras "
                       "FILE.json if possible");
    return;
  }
  conclude(false, kMovedElsewhere, "motion_wrong", "does not lead to where things were",
           "look at unit, scale and offset of the motion output (its maximum must not be clamped, "
           "nor 0 be stored as 0.5), or replace it: stillray denoise with --motion estimate");
}

}  // namespace

std::unique_ptr<Check> MakeStillMotionCheck() {
  return std::make_unique<StillMotionCheck>();
}

}  // namespace stillray::doctor
