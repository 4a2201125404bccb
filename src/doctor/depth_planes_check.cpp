// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds depth that is not linear. In a perspective image 1 / z is a linear function of the pixel
// position on every flat surface (the plane n . P = d with P = z (x / f, y / f, 1)). If it bends
// (is not linear), the depth is not z, and the conversion that makes it linear identifies the kind.
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/median.h"
#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 30000;
constexpr size_t kLeastTriples = 300;
constexpr size_t kMostTriples = 4000;
/// The ends of a triple differ by at least this many steps of the number format, so that rounding
/// is not measured as a bend. In renderers all but the last two bits of a float are correct.
constexpr float kSteps = 200;
constexpr float kHalfStep = 0x1p-11f;
constexpr float kFloatStep = 0x1p-22f;
/// Bend: second difference relative to the difference of the ends, of the steepest quarter of the
/// lines. Clean depth of floats measured below 0.0001; other kinds 0.003 and more.
constexpr double kLeastBend = 4e-4;
/// Bend of depth of an unknown kind: to one side everywhere, like a curve and unlike noise.
constexpr double kSurelyBent = 4e-3;
constexpr double kOneSide = 0.9;
/// The bend of the correct kind is below this fraction of the bend of the given kind.
constexpr double kFarLess = 0.2;
/// The limit for kinds with a fitted parameter, which can imitate other curves. Correct kinds:
/// 0.0004 and 0.013.
constexpr double kFarLessFitted = 0.04;
constexpr double kAgreement = 0.7;

/// Stored values at the ends and the middle of a flat line, and their distances from the image
/// centre.
struct Triple {
  std::array<float, 3> stored{};
  std::array<float, 3> depth{};   ///< converted to linear depth
  std::array<float, 3> radius{};  ///< squared, pixels
};

template <typename Function>
double MedianBend(const std::vector<Triple>& triples, const Function& linear) {
  std::vector<double> bends;
  bends.reserve(triples.size());
  for (const Triple& t : triples) {
    const double a = linear(t, 0);
    const double b = linear(t, 1);
    const double c = linear(t, 2);
    const double rise = std::fabs(c - a);
    const double bend = std::fabs(a - 2 * b + c) / rise;
    bends.push_back(std::isfinite(bend) ? bend : 1e3);
  }
  return Median(std::move(bends));
}

/// The parameter for which a kind of depth bends least, searched on a logarithmic grid and then
/// between its neighbours.
struct Fit {
  double parameter = 0;
  double bend = 1e30;
};
template <typename Bend>
Fit LeastBend(double from, double to, const Bend& bend) {
  constexpr int kGrid = 24;
  const double ratio = std::pow(to / from, 1.0 / kGrid);
  Fit best;
  for (int i = 0; i <= kGrid; ++i) {
    const double p = from * std::pow(ratio, i);
    const double b = bend(p);
    if (b < best.bend) {
      best = {p, b};
    }
  }
  double width = ratio;
  for (int i = 0; i < 24; ++i) {
    width = std::sqrt(width);
    for (const double p : {best.parameter / width, best.parameter * width}) {
      const double b = bend(p);
      if (b < best.bend) {
        best = {p, b};
      }
    }
  }
  return best;
}

/// Fraction of the lines that bend to the same side.
double OneSide(const std::vector<Triple>& triples) {
  size_t up = 0;
  for (const Triple& t : triples) {
    up += 1.0 / t.depth[0] - 2.0 / t.depth[1] + 1.0 / t.depth[2] > 0;
  }
  return static_cast<double>(std::max(up, triples.size() - up)) /
         static_cast<double>(triples.size());
}

/// The lines with the largest relative change of depth: there the kinds differ most.
std::vector<Triple> Steepest(std::vector<Triple> triples) {
  const auto steepness = [](const Triple& t) {
    return std::fabs(t.stored[2] - t.stored[0]) / std::fabs(t.stored[1]);
  };
  std::stable_sort(triples.begin(), triples.end(),
                   [&](const Triple& a, const Triple& b) { return steepness(a) > steepness(b); });
  triples.resize(std::clamp(triples.size() / 4, kLeastTriples, kMostTriples));
  return triples;
}

enum class Kind : uint8_t { kGiven, kLinear, kInverse, kRay, kOffset };

struct Judged {
  int64_t number = 0;
  double given = 0;     ///< bend
  double one_side = 0;  ///< fraction of the lines that bend to the same side
  Kind kind = Kind::kGiven;
  double bend = 0;  ///< of `kind`
  double parameter = 0;
  double median = 0;  ///< stored
  double largest = 0;
  double below = 0;  ///< median of stored values in the lower third of the image
  double above = 0;  ///< median of stored values in the upper third
};

double MedianOfRows(const Image1& image, int y0, int y1) {
  std::vector<float> values;
  for (int y = y0; y < y1; ++y) {
    for (int x = 0; x < image.width(); ++x) {
      if (std::isfinite(image(x, y))) {
        values.push_back(image(x, y));
      }
    }
  }
  return Median(std::move(values));
}

/// Whether it can be 1 / distance. Without perspective, linear distances are right. 1 / distance
/// seldom exceeds 1, and is larger in the lower part, where the ground is near.
bool MayBeInverse(const Judged& j) {
  return j.largest <= 1 || j.below > 1.1 * j.above;
}

class DepthPlanesCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  void AddTriples(const Exhibit& now, const Image1& stored, float step,
                  std::vector<Triple>* triples) const;
  Finding MakeFinding(Kind kind, const std::vector<int64_t>& frames, const Judged& typical) const;

  const AovLayout* layout_ = nullptr;
  std::vector<Judged> frames_;
};

void DepthPlanesCheck::AddTriples(const Exhibit& now, const Image1& stored, float step,
                                  std::vector<Triple>* triples) const {
  const Frame& f = now.frame;
  const int stride = SampleStep(f.width, f.height, kSamples);
  const float middle_x = 0.5f * static_cast<float>(f.width);
  const float middle_y = 0.5f * static_cast<float>(f.height);
  for (const int reach :
       {std::max(f.width / 12, 6), std::max(f.width / 24, 4), std::max(f.width / 64, 3)}) {
    for (int y = stride / 2; y < f.height; y += stride) {
      for (int x = stride / 2; x < f.width; x += stride) {
        for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1)}) {
          if (!IsFlat(f, x, y, dx, dy, reach)) {
            continue;
          }
          Triple t;
          for (int k = 0; k < 3; ++k) {
            const int px = x + (k - 1) * reach * dx;
            const int py = y + (k - 1) * reach * dy;
            const float rx = static_cast<float>(px) + 0.5f - middle_x;
            const float ry = static_cast<float>(py) + 0.5f - middle_y;
            const auto i = static_cast<size_t>(k);
            t.stored[i] = stored(px, py);
            t.depth[i] = f.guides.depth(px, py);
            t.radius[i] = rx * rx + ry * ry;
          }
          const float size =
              std::fabs(t.stored[0]) + std::fabs(t.stored[1]) + std::fabs(t.stored[2]);
          if (std::isfinite(size) &&
              std::fabs(t.stored[2] - t.stored[0]) > kSteps * step * std::fabs(t.stored[1])) {
            triples->push_back(t);
          }
        }
      }
    }
  }
}

void DepthPlanesCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  const AovSource* source = layout_->Find(Aov::kDepth);
  if (source == nullptr || layout_->Find(Aov::kNormal) == nullptr) {
    return;
  }
  const Image1 stored = StoredPlane(now, Aov::kDepth, 0);
  const Channel* channel = now.image->Find(source->channels[0]);
  const float step = channel->type == PixelType::kHalf ? kHalfStep : kFloatStep;
  std::vector<Triple> all;
  AddTriples(now, stored, step, &all);
  if (all.size() < kLeastTriples) {
    return;
  }
  const std::vector<Triple> triples = Steepest(std::move(all));
  std::vector<float> values;
  for (const Triple& t : triples) {
    values.push_back(t.stored[1]);
  }
  Judged j;
  j.number = now.number;
  std::sort(values.begin(), values.end());
  j.median = values[values.size() / 2];
  j.largest = values.back();
  j.below = MedianOfRows(stored, 2 * now.frame.height / 3, now.frame.height);
  j.above = MedianOfRows(stored, 0, now.frame.height / 3);
  j.given = MedianBend(triples, [](const Triple& t, size_t i) { return 1.0 / t.depth[i]; });
  j.bend = j.given;
  j.one_side = OneSide(triples);
  if (j.given > kLeastBend) {
    const auto consider = [&](Kind kind, double bend, double parameter) {
      const bool fitted = kind == Kind::kRay || kind == Kind::kOffset;
      if (bend < (fitted ? kFarLessFitted : kFarLess) * j.given && bend < j.bend) {
        j.kind = kind;
        j.bend = bend;
        j.parameter = parameter;
      }
    };
    consider(Kind::kLinear,
             MedianBend(triples, [](const Triple& t, size_t i) { return 1.0 / t.stored[i]; }), 0);
    const double itself =
        MedianBend(triples, [](const Triple& t, size_t i) { return double{t.stored[i]}; });
    if (itself < kFarLess * j.given && !MayBeInverse(j)) {
      return;
    }
    consider(Kind::kInverse, itself, 0);
    if (layout_->depth.kind == DepthKind::kLinear && j.kind == Kind::kGiven) {
      const Fit ray = LeastBend(0.3 * now.frame.width, 6.0 * now.frame.width, [&](double focal) {
        return MedianBend(triples, [&](const Triple& t, size_t i) {
          return std::sqrt(1 + t.radius[i] / (focal * focal)) / t.stored[i];
        });
      });
      consider(Kind::kRay, ray.bend, ray.parameter);
      const Fit offset = LeastBend(1e-3 * j.median, 10 * j.median, [&](double c) {
        return MedianBend(triples,
                          [&](const Triple& t, size_t i) { return 1.0 / (t.stored[i] + c); });
      });
      consider(Kind::kOffset, offset.bend, offset.parameter);
    }
  }
  frames_.push_back(j);
}

Finding DepthPlanesCheck::MakeFinding(Kind kind, const std::vector<int64_t>& frames,
                                      const Judged& typical) const {
  Finding f;
  f.frames = frames;
  f.measured = typical.given;
  f.expected = kind == Kind::kGiven ? kSurelyBent : kLeastBend;
  const std::string where = fmt::format(
      "in {}, 1 / depth of {} bends by {:.2g} of its rise on flat surfaces (expected below {:.2g}",
      FrameRanges(frames), LayerText(*layout_, Aov::kDepth), f.measured, f.expected);
  const std::string less = fmt::format("; so read, by {:.2g})", typical.bend);
  const auto map = [&](const std::string& words) {
    f.aov = MappingText(*layout_, Aov::kDepth, words);
    f.cure = MappingCure(f.aov);
  };
  switch (kind) {
    case Kind::kLinear:
      f.name = "depth_not_linear";
      f.what = "depth is linear as it is stored: " + where + less;
      map("linear");
      break;
    case Kind::kInverse:
      if (typical.largest <= 1 && typical.median > 0.5) {
        f.name = "depth_projected";
        f.what = "depth is as a rasteriser stores it, 0 near and 1 far: " + where + less;
        f.cure = MappingCure(MappingText(*layout_, Aov::kDepth, "projected,near=NEAR,far=FAR")) +
                 ", NEAR and FAR being the camera's clip distances";
      } else {
        f.name = "depth_reversed";
        f.what = "depth is large near and small far, 1 / distance: " + where + less;
        map("inverse");
        f.cure += " (reversed,near=NEAR,far=FAR if the far clip distance is close)";
      }
      break;
    case Kind::kRay:
      f.name = "depth_ray";
      f.what = "depth is the length of the ray, not along the viewing axis: " + where + less;
      map(fmt::format("ray,focal={:.5g}", typical.parameter));
      break;
    case Kind::kOffset:
      f.name = typical.largest <= 1.0001 ? "depth_normalised" : "depth_not_linear";
      f.what = (typical.largest <= 1.0001 ? "depth runs from 0 to 1: "
                                          : "depth does not begin at the camera: ") +
               where + less;
      // Only ratios of depths matter: any unit works.
      map(fmt::format("normalised,near={:.4g},far={:.4g}", typical.parameter,
                      1 + typical.parameter));
      break;
    case Kind::kGiven:
      f.name = "depth_not_linear";
      f.what = "depth is not linear: " + where + ")";
      f.cure =
          "write the distance along the viewing axis in scene units as 32-bit floats (no curve, "
          "no range, no display format)";
      break;
  }
  return f;
}

void DepthPlanesCheck::Conclude(Verdict* verdict) {
  if (frames_.empty()) {
    return;
  }
  std::vector<double> bends;
  for (const Judged& j : frames_) {
    bends.push_back(j.given);
  }
  bool broken = false;
  for (const Kind kind : {Kind::kLinear, Kind::kInverse, Kind::kRay, Kind::kOffset, Kind::kGiven}) {
    std::vector<int64_t> frames;
    std::vector<Judged> such;
    for (const Judged& j : frames_) {
      if (j.kind == kind &&
          (kind != Kind::kGiven || (j.given > kSurelyBent && j.one_side > kOneSide))) {
        frames.push_back(j.number);
        such.push_back(j);
      }
    }
    const bool agreed = !such.empty() && static_cast<double>(such.size()) >=
                                             kAgreement * static_cast<double>(frames_.size());
    if (agreed) {
      std::sort(such.begin(), such.end(),
                [](const Judged& a, const Judged& b) { return a.parameter < b.parameter; });
      verdict->Add(MakeFinding(kind, frames, such[such.size() / 2]));
      broken = true;
      break;
    }
  }
  verdict->Add(Measure{"depth_bend", Median(std::move(bends)), kLeastBend, broken,
                       static_cast<int64_t>(frames_.size())});
}

}  // namespace

std::unique_ptr<Check> MakeDepthPlanesCheck() {
  return std::make_unique<DepthPlanesCheck>();
}

}  // namespace stillray::doctor
