// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds random first hits: behind a lens, in fog, and on partially transparent surfaces, the guides
// of a pixel belong to a random hit of this frame. Evaluated per block, since often a single object
// is affected.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "doctor/check.h"
#include "doctor/warp.h"
#include "io/aov_samples.h"

namespace stillray::doctor {
namespace {

constexpr int kBlock = 16;
/// Smallest detail that counts: above the rounding of halves. Albedo; relative 1 / depth.
constexpr float kDetail[2] = {0.01f, 0.003f};
/// Clamp of larger differences, so that single edges do not outweigh noise.
constexpr float kLargest = 0.25f;
/// A block of albedo is random if this fraction of its pixels differs from the neighbours in both
/// directions, if the differences do not recur in the previous frame along the motion, and if they
/// are white noise: as large at a distance of one pixel as at two. Measured in Cycles at 1 spp:
/// lens at f/0.3 0.5 to 0.7, correlation below 0.12, ratio 0.95 to 1.02; alpha 0.3 to 0.8 likewise;
/// fog 0.45 to 0.7. Clean: textures and leaves have detail 0.8, but ratio 0.3 to 0.7 or correlation
/// 0.2 and more; joints thinner than a pixel ratio 0.9 and correlation 0, but detail below 0.38.
constexpr double kAlbedoDetail = 0.45;
constexpr double kAlbedoStays = 0.12;
constexpr double kLeastWhite = 0.85;
constexpr double kMostWhite = 1.2;
/// A texture finer than a pixel is equally random if samples are jittered (the floor of
/// builtin:spheres in 10 % of the blocks). But no texture reflects more than 1: if paths pass
/// through a surface at random, their throughput is weighted up, and some albedo, usually the
/// specular one, is above 1 in 10 % of the pixels or more.
constexpr float kAboveOne = 1.02f;
constexpr double kMayBeAbove = 0.01;
/// Smallest fraction of the pixels above 1 that lie in random blocks: a gain of albedo is above 1
/// everywhere.
constexpr double kAboveInside = 0.4;
/// Depth: flat surfaces have none, leaves less than 0.47 with correlation above 0.27.
constexpr double kDepthDetail = 0.3;
constexpr double kDepthStays = 0.15;
/// Fraction of the blocks. Clean: 0 measured.
constexpr double kMayBeRandom = 0.03;
constexpr int64_t kLeastBlocks = 2;
/// If a single guide is random in this many blocks, the guide itself is noisy (radiance in albedo,
/// rounded depth), which is another finding. A random hit affects all guides.
constexpr double kEverywhere = 0.7;
/// Fraction of pixels without a surface in random blocks from which on the cause is a volume or
/// hair.
constexpr double kHoles = 0.03;
/// Samples per pixel from which on random guides cost about 1 dB at most (docs/inputs.md).
constexpr double kManySamples = 16;

using Values = std::array<float, 3>;

/// Whether any albedo of the pixel is above 1.
bool IsAboveOne(const Guides& g, int x, int y) {
  for (const Image3* albedo : {&g.albedo, &g.specular_albedo, &g.transmission_albedo}) {
    for (int c = 0; c < 3 && !albedo->empty(); ++c) {
      if ((*albedo)[c](x, y) > kAboveOne) {
        return true;
      }
    }
  }
  return false;
}

float FiniteOr0(float v) {
  return std::isfinite(v) ? v : 0.0f;
}

/// 1 / depth; 0 where there is no surface.
float Nearness(const Frame& f, int x, int y) {
  const float z = f.guides.depth(x, y);
  return z > 0 ? FiniteOr0(1.0f / z) : 0.0f;
}

/// The difference of pixel (x, y) from the mean of the two pixels at distance (dx, dy).
Values Step(const Frame& f, bool depth, int x, int y, int dx, int dy) {
  Values step{};
  if (depth) {
    const float a = Nearness(f, x - dx, y - dy);
    const float b = Nearness(f, x, y);
    const float c = Nearness(f, x + dx, y + dy);
    const float largest = std::max({a, b, c});
    step[0] = largest > 0 ? (b - 0.5f * (a + c)) / largest : 0.0f;
  } else {
    for (int i = 0; i < 3; ++i) {
      const Image1& p = f.guides.albedo[i];
      step[static_cast<size_t>(i)] =
          FiniteOr0(p(x, y) - 0.5f * (p(x - dx, y - dy) + p(x + dx, y + dy)));
    }
  }
  for (float& s : step) {
    s = std::clamp(s, -kLargest, kLargest);
  }
  return step;
}

/// The smaller of both directions, which is zero along straight edges.
Values Detail(const Frame& f, bool depth, int x, int y) {
  const Values across = Step(f, depth, x, y, 1, 0);
  const Values down = Step(f, depth, x, y, 0, 1);
  Values least{};
  for (size_t i = 0; i < 3; ++i) {
    least[i] = std::fabs(across[i]) < std::fabs(down[i]) ? across[i] : down[i];
  }
  return least;
}

double Square(const Values& v) {
  return static_cast<double>(v[0]) * v[0] + static_cast<double>(v[1]) * v[1] +
         static_cast<double>(v[2]) * v[2];
}

/// Sums over the pixels of a block in all pairs of frames.
struct Sums {
  int64_t count = 0;
  int64_t detailed = 0;
  double ab = 0;
  double aa = 0;
  double bb = 0;
  double near = 0;  ///< squared steps to the next pixels
  double far = 0;   ///< squared steps to those after

  double Part() const {
    return count == 0 ? 0 : static_cast<double>(detailed) / static_cast<double>(count);
  }
  double Stays() const { return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 1; }
  double White() const { return far > 0 ? near / far : 0; }
};

struct BlockSums {
  Sums albedo;
  Sums depth;
  int64_t pixels = 0;
  int64_t holes = 0;  ///< pixels without a surface
  int64_t above = 0;  ///< pixels with an albedo above 1

  bool RandomAlbedo() const {
    return albedo.Part() > kAlbedoDetail && albedo.Stays() < kAlbedoStays &&
           albedo.White() > kLeastWhite && albedo.White() < kMostWhite;
  }
  /// Noise that cannot be texture.
  bool RandomColour() const {
    return RandomAlbedo() && static_cast<double>(above) > kMayBeAbove * static_cast<double>(pixels);
  }
  bool RandomDepth() const { return depth.Part() > kDepthDetail && depth.Stays() < kDepthStays; }
};

/// The mean number of samples of a pixel; 1 if the file does not state it.
double MeanSamples(const Exhibit& now) {
  const Image1& samples = now.frame.samples;
  if (samples.empty()) {
    return std::max(io::StatedSamples(*now.image), 1);
  }
  double sum = 0;
  for (int y = 0; y < samples.height(); ++y) {
    for (int x = 0; x < samples.width(); ++x) {
      sum += FiniteOr0(samples(x, y));
    }
  }
  return sum / (static_cast<double>(samples.width()) * samples.height());
}

class FirstHitCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  std::string BlenderCure(bool holes, bool albedo_alone) const;
  void LookAtPixel(const Exhibit& now, const Exhibit& before, int x, int y, BlockSums* block) const;
  Finding MakeFinding(double part, double depth_part, double holes, double x, double y) const;

  const AovLayout* layout_ = nullptr;
  bool has_albedo_ = false;
  bool has_depth_ = false;
  double samples_ = 1;  ///< per pixel, of the newest frame
  int columns_ = 0;
  std::vector<BlockSums> blocks_;
  std::vector<int64_t> frames_;
};

void FirstHitCheck::LookAtPixel(const Exhibit& now, const Exhibit& before, int x, int y,
                                BlockSums* block) const {
  const Frame& f = now.frame;
  ++block->pixels;
  block->holes += Nearness(f, x, y) == 0;
  block->above += IsAboveOne(f.guides, x, y);
  int px = 0;
  int py = 0;
  const bool found =
      Nearest(PlaceBefore(now, before, x, y, MotionAt(f, x, y)), f.width, f.height, &px, &py) &&
      px >= 1 && py >= 1 && px + 1 < f.width && py + 1 < f.height;
  for (const bool depth : {false, true}) {
    if (!(depth ? has_depth_ : has_albedo_)) {
      continue;
    }
    Sums& sums = depth ? block->depth : block->albedo;
    const Values a = Detail(f, depth, x, y);
    ++sums.count;
    sums.detailed += std::max({std::fabs(a[0]), std::fabs(a[1]), std::fabs(a[2])}) > kDetail[depth];
    sums.near += Square(Step(f, depth, x, y, 1, 0)) + Square(Step(f, depth, x, y, 0, 1));
    sums.far += Square(Step(f, depth, x, y, 2, 0)) + Square(Step(f, depth, x, y, 0, 2));
    if (found) {
      const Values b = Detail(before.frame, depth, px, py);
      for (size_t i = 0; i < 3; ++i) {
        sums.ab += static_cast<double>(a[i]) * b[i];
      }
      sums.aa += Square(a);
      sums.bb += Square(b);
    }
  }
}

void FirstHitCheck::Look(const Exhibit& now, const Exhibit* before) {
  layout_ = now.layout;
  const Frame& f = now.frame;
  samples_ = MeanSamples(now);
  // Without motion nothing can be matched.
  if (before == nullptr || layout_->Find(Aov::kMotion) == nullptr) {
    return;
  }
  has_depth_ = layout_->Find(Aov::kDepth) != nullptr;
  has_albedo_ =
      layout_->Find(Aov::kAlbedo) != nullptr || layout_->Find(Aov::kFallbackAlbedo) != nullptr;
  columns_ = f.width / kBlock;
  const int rows = f.height / kBlock;
  blocks_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows));
  for (int y = 2; y + 2 < std::min(f.height, rows * kBlock); ++y) {
    for (int x = 2; x + 2 < std::min(f.width, columns_ * kBlock); ++x) {
      LookAtPixel(now, *before, x, y,
                  &blocks_[static_cast<size_t>(y / kBlock) * static_cast<size_t>(columns_) +
                           static_cast<size_t>(x / kBlock)]);
    }
  }
  frames_.push_back(now.number);
}

/// \param holes  whether random rays include rays without a surface. For files with volume
///     radiance, the import has filled in the guides of smoke.
std::string FirstHitCheck::BlenderCure(bool holes, bool albedo_alone) const {
  const std::string more =
      fmt::format("Render > Sampling > Max Samples of {:.0f} or more", kManySamples);
  if (holes && layout_->Find(Aov::kDirectVolume) == nullptr &&
      layout_->Find(Aov::kIndirectVolume) == nullptr) {
    return fmt::format(
        "smoke and fog: switch on View Layer > Passes > Light > Volume Direct and Indirect, by "
        "which "
        "stillray denoise completes the guides; hair and leaves: {}",
        more);
  }
  if (holes) {
    return fmt::format("hair, leaves and transparent materials: {}", more);
  }
  if (albedo_alone) {
    return fmt::format(
        "give transparent materials Alpha 1 or a view layer of their own; switch Subsurface of "
        "materials off; or {}",
        more);
  }
  return fmt::format(
      "switch off Camera > Depth of Field and blur afterwards (stillray denoise --post dof, or "
      "Defocus in the compositor, with Depth); give transparent materials Alpha 1 or a view layer "
      "of their own; or {}",
      more);
}

/// \param part        fraction of the image
/// \param depth_part  fraction of the random blocks whose depth is random
/// \param holes       fraction of their pixels without a surface
/// \param x, y        their centre, pixels
Finding FirstHitCheck::MakeFinding(double part, double depth_part, double holes, double x,
                                   double y) const {
  const bool has_holes = holes > kHoles;
  const bool albedo_alone = depth_part == 0;
  Finding f;
  f.name = "first_hits_random";
  f.frames = frames_;
  f.measured = part;
  f.expected = kMayBeRandom;
  f.what = fmt::format(
      "in {:.0f} % of the picture, around x {:.0f}, y {:.0f}, {} differ from pixel to pixel and "
      "from frame to frame (expected below {:.0f} %): what a ray hits first is chance there ({}), "
      "and noise stays",
      100 * part, x, y,
      has_holes      ? "surface and no surface"
      : albedo_alone ? "colours of surfaces"
                     : "surfaces",
      100 * kMayBeRandom,
      has_holes      ? "fog, hair or another volume"
      : albedo_alone ? "transparency or subsurface scattering"
                     : "depth of field, transparency, or a volume");
  f.cure = layout_->renderer == "blender" ? BlenderCure(has_holes, albedo_alone)
           : has_holes ? "volumes: write their light as layers of their own (--aov "
                         "direct_volume=LAYER, indirect_volume=LAYER), by which stillray denoise "
                         "completes the guides of smoke; or render more samples"
                       : "render without lens blur and add it afterwards (stillray denoise --post "
                         "dof), transparency apart, or render more samples";
  return f;
}

void FirstHitCheck::Conclude(Verdict* verdict) {
  // With wrong motion nothing matches; depth of another kind is nonlinear everywhere.
  if (frames_.empty() || blocks_.empty() || verdict->Has("motion_") || verdict->Has("depth_")) {
    return;
  }
  int64_t above = 0;
  int64_t above_inside = 0;
  for (const BlockSums& block : blocks_) {
    above += block.above;
    above_inside += block.RandomColour() ? block.above : 0;
  }
  const bool gain = static_cast<double>(above_inside) < kAboveInside * static_cast<double>(above);
  int64_t random = 0;
  int64_t of_depth = 0;
  int64_t of_albedo = 0;
  int64_t pixels = 0;
  int64_t holes = 0;
  double x = 0;
  double y = 0;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const BlockSums& block = blocks_[i];
    if ((gain || !block.RandomColour()) && !block.RandomDepth()) {
      continue;
    }
    ++random;
    of_depth += block.RandomDepth();
    of_albedo += block.RandomAlbedo();
    pixels += block.pixels;
    holes += block.holes;
    x += (static_cast<double>(i % static_cast<size_t>(columns_)) + 0.5) * kBlock;
    y += (static_cast<double>(i / static_cast<size_t>(columns_)) + 0.5) * kBlock;
  }
  const double part = static_cast<double>(random) / static_cast<double>(blocks_.size());
  const double no_surface =
      pixels == 0 ? 0 : static_cast<double>(holes) / static_cast<double>(pixels);
  const bool one_guide =
      part > kEverywhere && (of_depth == 0 || of_albedo == 0) && no_surface < kHoles;
  const bool broken = part > kMayBeRandom && random >= kLeastBlocks && !one_guide;
  verdict->Add(
      Measure{"random_blocks", part, kMayBeRandom, broken, static_cast<int64_t>(frames_.size())});
  if (broken && samples_ < kManySamples) {
    const auto count = static_cast<double>(random);
    verdict->Add(
        MakeFinding(part, static_cast<double>(of_depth) / count, no_surface, x / count, y / count));
  }
}

}  // namespace

std::unique_ptr<Check> MakeFirstHitCheck() {
  return std::make_unique<FirstHitCheck>();
}

}  // namespace stillray::doctor
