// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds layers of virtual images (Cycles' Denoising Data) that belong to another render: on plain
// surfaces, neither mirrors nor glass, they must describe the surface itself.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/guides.h"
#include "core/median.h"
#include "core/pixels.h"
#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"
#include "io/camera_fit.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 40000;
/// Radius in pixels around a plain pixel within which all pixels lie on one plane, by normals and
/// depth.
constexpr int kReach = 2;
/// Maximum relative nonlinearity of 1 / depth on a plane.
constexpr float kBend = 1e-3f;
/// Minimum sum of the diffuse albedo of plain pixels, and its minimum ratio to the transmission
/// albedo: Cycles treats a surface as plain if a quarter of its scattering is not specular.
constexpr float kDiffuse = 0.3f;
constexpr float kOverTransmission = 2;
/// Maximum emission of non-emitters: in halves the colour differs from the sum of the passes.
constexpr float kEmits = 0.05f;
/// Minimum number of plain pixels.
constexpr int64_t kLeastPixels = 200;
/// Tolerances within which guides belong to the surface: relative difference of depths, length of
/// the difference of normals, and absolute and relative difference of albedos.
constexpr double kOtherDepth = 0.02;
constexpr float kOtherNormal = 0.15f;
constexpr float kOtherAlbedo[2] = {0.05f, 0.1f};
/// Fraction of a frame's plain pixels. Clean: 0 measured in Cycles, at 1 to 256 samples, with
/// mirrors, glass, chrome and a pixel filter.
constexpr double kMayDiffer = 0.05;

float SumAt(const Image3& image, int x, int y) {
  return image.empty() ? 0.0f : image[0](x, y) + image[1](x, y) + image[2](x, y);
}

/// Albedos as stored: the import replaces zero transmission albedos by white.
struct Albedos {
  Image3 diffuse;
  Image3 specular;
  Image3 transmission;
};

/// Whether 1 / depth is linear around the pixel, along one direction.
bool IsStraight(const Image1& depth, int x, int y, int dx, int dy) {
  const float z = depth(x, y);
  const float bend = z / depth(x - dx, y - dy) + z / depth(x + dx, y + dy) - 2;
  return std::fabs(bend) < kBend;
}

/// Whether the pixel is on a plane that is neither a mirror nor glass, and emits nothing.
bool IsPlain(const Frame& frame, const Albedos& albedos, int x, int y) {
  const Image1& depth = frame.guides.depth;
  const float diffuse = SumAt(albedos.diffuse, x, y);
  return diffuse > kDiffuse && diffuse > kOverTransmission * SumAt(albedos.transmission, x, y) &&
         !(SumAt(frame.emission, x, y) > kEmits) && IsFlat(frame, x, y, 1, 0, kReach) &&
         IsFlat(frame, x, y, 0, 1, kReach) && IsStraight(depth, x, y, 1, 0) &&
         IsStraight(depth, x, y, 0, 1);
}

std::vector<ivec2> PlainPixels(const Frame& frame, const Albedos& albedos) {
  const int step = SampleStep(frame.width, frame.height, kSamples);
  std::vector<ivec2> pixels;
  for (int y = step / 2; y < frame.height; y += step) {
    for (int x = step / 2; x < frame.width; x += step) {
      if (IsPlain(frame, albedos, x, y)) {
        pixels.emplace_back(x, y);
      }
    }
  }
  return pixels;
}

/// Conversion of path lengths to depth. If most lengths fit no lens, uses the field of view from
/// depth and normals, and the near clipping plane from the median of the plain pixels.
std::optional<io::Lens> LensOf(const Guides& g, const Image1& seen,
                               const std::vector<ivec2>& pixels) {
  if (std::optional<io::Lens> lens = io::FitLens(g.depth, seen)) {
    return lens;
  }
  const std::optional<io::View> view = io::FitView(g.depth, g.normal);
  if (!view) {
    return std::nullopt;
  }
  io::Lens lens;
  lens.k = view->tangent * view->tangent;
  std::vector<double> starts;
  double nearest = HUGE_VAL;
  for (const ivec2& p : pixels) {
    const auto z = static_cast<double>(g.depth(p.x, p.y));
    const auto distance = static_cast<double>(seen(p.x, p.y));
    nearest = std::min(nearest, z);
    if (std::isfinite(distance)) {
      starts.push_back(z - lens.DepthOf(distance, PixelPoint(g.depth, p.x, p.y)));
    }
  }
  lens.start = std::clamp(Median(std::move(starts)), 0.0, nearest);
  return lens;
}

/// Whether any value of the planes is not zero.
template <typename Image>
bool HasValues(const Image& image) {
  return AnyPixel(image, [](float v) { return v != 0; });
}

/// A kSeen layer, and its deviations at plain surfaces.
struct Layer {
  Aov aov;
  Aov own;  ///< the layer of visible surfaces that it must repeat
  const char* finding;
  std::vector<int64_t> zero = {};                        ///< frames
  std::vector<std::pair<int64_t, double>> differs = {};  ///< fraction of each frame
};

class SeenGuidesCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  /// Tests of the plain pixels. Each records a fraction unless the layer is zero.
  void LookAtDepth(const Exhibit& now, const std::vector<ivec2>& pixels);
  void LookAtNormal(const Exhibit& now, const std::vector<ivec2>& pixels);
  void LookAtAlbedo(const Exhibit& now, const Albedos& albedos, const std::vector<ivec2>& pixels);
  std::string Cure() const;
  void ConcludeZero(Verdict* verdict) const;
  void ConcludeLayer(const Layer& layer, Verdict* verdict) const;

  const AovLayout* layout_ = nullptr;
  Layer depth_ = {Aov::kSeenDepth, Aov::kDepth, "seen_depth_differs"};
  Layer normal_ = {Aov::kSeenNormal, Aov::kNormal, "seen_normal_differs"};
  Layer albedo_ = {Aov::kSeenAlbedo, Aov::kAlbedo, "seen_albedo_differs"};
};

/// The fraction of the pixels for which differs(x, y) is true.
template <typename Differs>
double Part(const std::vector<ivec2>& pixels, const Differs& differs) {
  const auto count = std::count_if(pixels.begin(), pixels.end(),
                                   [&](const ivec2& p) { return differs(p.x, p.y); });
  return static_cast<double>(count) / static_cast<double>(pixels.size());
}

void SeenGuidesCheck::LookAtDepth(const Exhibit& now, const std::vector<ivec2>& pixels) {
  const Guides& g = now.frame.guides;
  const Image1 seen = StoredPlane(now, Aov::kSeenDepth, 0);
  if (!HasValues(seen)) {
    depth_.zero.push_back(now.number);
    return;
  }
  const std::optional<io::Lens> lens = LensOf(g, seen, pixels);
  if (!lens) {
    return;
  }
  depth_.differs.emplace_back(now.number, Part(pixels, [&](int x, int y) {
                                const double depth = lens->DepthOf(static_cast<double>(seen(x, y)),
                                                                   PixelPoint(g.depth, x, y));
                                const double relative = depth / static_cast<double>(g.depth(x, y));
                                return !(std::abs(relative - 1) < kOtherDepth);
                              }));
}

void SeenGuidesCheck::LookAtNormal(const Exhibit& now, const std::vector<ivec2>& pixels) {
  const Image3 seen = StoredColour(now, Aov::kSeenNormal);
  if (!HasValues(seen)) {
    normal_.zero.push_back(now.number);
    return;
  }
  Image3 plain(now.frame.width, now.frame.height);
  for (const ivec2& p : pixels) {
    for (int c = 0; c < 3; ++c) {
      plain[c](p.x, p.y) = now.frame.guides.normal[c](p.x, p.y);
    }
  }
  const mat3 map = io::FitNormalMap(plain, seen);
  normal_.differs.emplace_back(now.number, Part(pixels, [&](int x, int y) {
                                 const vec3 off =
                                     map * VectorAt(plain, x, y) - VectorAt(seen, x, y);
                                 return !(glm::length(off) < kOtherNormal);
                               }));
}

/// Whether an albedo lies between the diffuse albedo and the sum of all albedos, if all are known.
bool IsAlbedoOf(const Albedos& albedos, const Image3& seen, int x, int y) {
  const auto at = [&](const Image1& plane) { return plane.empty() ? 0.0f : plane(x, y); };
  const bool has_all = !albedos.specular.empty();
  for (int c = 0; c < 3; ++c) {
    const float least = albedos.diffuse[c](x, y);
    const float most = least + at(albedos.specular[c]) + at(albedos.transmission[c]);
    const float value = seen[c](x, y);
    const bool enough = value > least * (1 - kOtherAlbedo[1]) - kOtherAlbedo[0];
    const bool too_much = has_all && !(value < most * (1 + kOtherAlbedo[1]) + kOtherAlbedo[0]);
    if (!enough || too_much) {
      return false;
    }
  }
  return true;
}

void SeenGuidesCheck::LookAtAlbedo(const Exhibit& now, const Albedos& albedos,
                                   const std::vector<ivec2>& pixels) {
  const Image3 seen = StoredColour(now, Aov::kSeenAlbedo);
  if (!HasValues(seen)) {
    albedo_.zero.push_back(now.number);
    return;
  }
  albedo_.differs.emplace_back(
      now.number, Part(pixels, [&](int x, int y) { return !IsAlbedoOf(albedos, seen, x, y); }));
}

void SeenGuidesCheck::Look(const Exhibit& now, const Exhibit*) {
  layout_ = now.layout;
  if (layout_->Find(Aov::kSeenDepth) == nullptr || layout_->Find(Aov::kAlbedo) == nullptr) {
    return;
  }
  const Albedos albedos = {StoredColour(now, Aov::kAlbedo), StoredColour(now, Aov::kSpecularAlbedo),
                           StoredColour(now, Aov::kTransmissionAlbedo)};
  const std::vector<ivec2> pixels = PlainPixels(now.frame, albedos);
  if (static_cast<int64_t>(pixels.size()) < kLeastPixels) {
    return;
  }
  LookAtDepth(now, pixels);
  LookAtNormal(now, pixels);
  LookAtAlbedo(now, albedos, pixels);
}

std::string SeenGuidesCheck::Cure() const {
  const std::string without = MappingCure("seen_depth=none");
  return layout_->renderer == "blender"
             ? "render all passes at once, with View Layer > Passes > Data > Denoising Data of the "
               "same view layer, and neither denoise nor composite it; or do without: " +
                   without
             : "write the layers in the same render as the others, not denoised; or do without: " +
                   without;
}

void SeenGuidesCheck::ConcludeZero(Verdict* verdict) const {
  for (const Layer* layer : {&depth_, &normal_, &albedo_}) {
    if (!layer->zero.empty()) {
      verdict->Add(Finding{"seen_zero", layer->zero,
                           fmt::format("{}, of what mirrors and glass show, is zero everywhere in "
                                       "{} (expected the {} of the surfaces that are neither)",
                                       LayerText(*layout_, layer->aov), FrameRanges(layer->zero),
                                       AovName(layer->own)),
                           Cure(), 1, 0, "seen_depth=none"});
      return;
    }
  }
}

void SeenGuidesCheck::ConcludeLayer(const Layer& layer, Verdict* verdict) const {
  if (layer.differs.empty()) {
    return;
  }
  double worst = 0;
  std::vector<int64_t> frames;
  for (const auto& [number, part] : layer.differs) {
    worst = std::max(worst, part);
    if (part > kMayDiffer) {
      frames.push_back(number);
    }
  }
  verdict->Add(Measure{layer.finding, worst, kMayDiffer, !frames.empty(),
                       static_cast<int64_t>(layer.differs.size())});
  if (frames.empty() || verdict->Has("seen_")) {
    return;
  }
  verdict->Add(Finding{
      layer.finding, frames,
      fmt::format("{}, of what mirrors and glass show, is not that in {} in up to {:.0f} % of the "
                  "flat surfaces that are neither, in {} (expected at most {:.0f} %)",
                  LayerText(*layout_, layer.aov), LayerText(*layout_, layer.own), 100 * worst,
                  FrameRanges(frames), 100 * kMayDiffer),
      Cure(), worst, kMayDiffer, "seen_depth=none"});
}

void SeenGuidesCheck::Conclude(Verdict* verdict) {
  // Wrong layers of visible surfaces cannot be compared with.
  if (layout_ == nullptr || verdict->Has("depth_") || verdict->Has("normal_") ||
      verdict->Has("albedo_encoded") || verdict->Has("albedo_above") ||
      verdict->Exceeds("random_blocks")) {
    return;
  }
  ConcludeZero(verdict);
  for (const Layer* layer : {&depth_, &normal_, &albedo_}) {
    ConcludeLayer(*layer, verdict);
  }
}

}  // namespace

std::unique_ptr<Check> MakeSeenGuidesCheck() {
  return std::make_unique<SeenGuidesCheck>();
}

}  // namespace stillray::doctor
