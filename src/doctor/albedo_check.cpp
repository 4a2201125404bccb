// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Finds albedo that is above 1, black at pixels with diffuse radiance, or stored non-linearly.
#include <cmath>

#include <fmt/format.h>

#include "core/colour_shared.h"
#include "doctor/check.h"
#include "doctor/planes.h"
#include "doctor/warp.h"

namespace stillray::doctor {
namespace {

constexpr float kAboveOne = 1.02f;
/// Sums of lobes (coat and base) may exceed 1 slightly.
constexpr float kSpecularAboveOne = 2.0f;
/// Fraction of pixels above 1: a few overlapping closures exceed it. Clean: 0.
constexpr double kMayBeAbove = 0.003;
constexpr float kBlack = 1e-4f;
/// Fraction of the pixels with diffuse radiance whose albedo is black. Clean: 0 measured.
constexpr double kMayBeBlack = 0.02;

/// Where two albedos meet on one surface, radiance is proportional to albedo^exponent: 1 if the
/// albedo is linear, about 2 if it is sRGB-encoded. Clean: 0.8 to 1.2 measured.
constexpr double kLinearExponent = 1.6;
constexpr int kWindow = 8;
constexpr int kLeastInClass = 8;
constexpr float kContrast = 1.25f;
constexpr size_t kLeastWindows = 40;
constexpr double kAgreement = 0.7;
constexpr float kBright = 6.0f;

/// Two albedos in a window, and the mean light of each.
struct Window {
  double albedo[2] = {0, 0};
  double light[2] = {0, 0};
};

/// The exponent b for which light / albedo^b is the same on both sides, summed over all windows.
double ExponentOf(const std::vector<Window>& windows) {
  const auto excess = [&](double b) {
    double sum = 0;
    for (const Window& w : windows) {
      const double ratio = std::pow(w.albedo[1] / w.albedo[0], 0.5 * b);
      sum += w.light[1] / ratio - w.light[0] * ratio;  // decreases with b
    }
    return sum;
  };
  double low = -1;
  double high = 6;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

float Grey(const Image3& image, int x, int y) {
  return Luminance709(image[0](x, y), image[1](x, y), image[2](x, y));
}

class AlbedoCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  struct Part {
    int64_t number = 0;
    double value = 0;
  };
  struct Layer {
    Aov aov = Aov::kAlbedo;
    std::vector<Part> above;
    float largest = 0;
  };
  void LookAbove(const Exhibit& now);
  void LookBlack(const Exhibit& now);
  void LookExponent(const Exhibit& now);
  static std::vector<int64_t> Over(const std::vector<Part>& parts, double limit, double* worst);

  const AovLayout* layout_ = nullptr;
  Layer layers_[3] = {
      {Aov::kAlbedo, {}, 0}, {Aov::kSpecularAlbedo, {}, 0}, {Aov::kTransmissionAlbedo, {}, 0}};
  std::vector<Part> black_;
  std::vector<Part> exponents_;
};

void AlbedoCheck::LookAbove(const Exhibit& now) {
  for (Layer& layer : layers_) {
    if (layout_->Find(layer.aov) == nullptr) {
      continue;
    }
    const Image3 albedo = StoredColour(now, layer.aov);
    int64_t above = 0;
    for (int y = 0; y < now.frame.height; ++y) {
      for (int x = 0; x < now.frame.width; ++x) {
        const float most = std::max({albedo[0](x, y), albedo[1](x, y), albedo[2](x, y)});
        above += most > (layer.aov == Aov::kAlbedo ? kAboveOne : kSpecularAboveOne);
        layer.largest = std::isfinite(most) ? std::max(layer.largest, most) : layer.largest;
      }
    }
    layer.above.push_back(
        {now.number,
         static_cast<double>(above) / (static_cast<double>(now.frame.width) * now.frame.height)});
  }
}

/// Uses diffuse radiance as stored: in files of renderers that divide by albedo, it is nonzero
/// where albedo is zero.
void AlbedoCheck::LookBlack(const Exhibit& now) {
  if (layout_->Find(Aov::kAlbedo) == nullptr || layout_->from_colour) {
    return;
  }
  int64_t lit = 0;
  int64_t black = 0;
  std::vector<Image3> lights;
  for (const Aov aov : {Aov::kDirectDiffuse, Aov::kIndirectDiffuse}) {
    if (layout_->Find(aov) != nullptr) {
      lights.push_back(StoredColour(now, aov));
    }
  }
  const Image3& albedo = now.frame.guides.albedo;
  for (int y = 0; y < now.frame.height; ++y) {
    for (int x = 0; x < now.frame.width; ++x) {
      const bool any = std::any_of(lights.begin(), lights.end(), [&](const Image3& light) {
        return std::max({light[0](x, y), light[1](x, y), light[2](x, y)}) > 1e-4f;
      });
      if (any) {
        ++lit;
        black += std::max({albedo[0](x, y), albedo[1](x, y), albedo[2](x, y)}) < kBlack;
      }
    }
  }
  if (lit > 0) {
    black_.push_back({now.number, static_cast<double>(black) / static_cast<double>(lit)});
  }
}

/// Splits each window between its smallest and largest albedo.
void AlbedoCheck::LookExponent(const Exhibit& now) {
  const Frame& f = now.frame;
  if (layout_->light_is_divided || layout_->from_colour || layout_->Find(Aov::kAlbedo) == nullptr) {
    return;  // the stored radiance does not depend on the albedo
  }
  Image1 light(f.width, f.height);
  double mean = 0;
  for (const Signal& signal : f.signals) {
    if (signal.kind != SignalKind::kDirectDiffuse && signal.kind != SignalKind::kIndirectDiffuse) {
      continue;
    }
    for (int y = 0; y < f.height; ++y) {
      for (int x = 0; x < f.width; ++x) {
        const float v = Grey(signal.radiance, x, y);
        light(x, y) += std::isfinite(v) ? std::max(v, 0.0f) : 0.0f;
        mean += std::isfinite(v) ? std::max(v, 0.0f) : 0.0f;
      }
    }
  }
  mean /= static_cast<double>(f.width) * f.height;
  std::vector<Window> windows;
  for (int y0 = 0; y0 + kWindow <= f.height; y0 += kWindow) {
    for (int x0 = 0; x0 + kWindow <= f.width; x0 += kWindow) {
      float least = 1e30f;
      float most = 0;
      bool flat = std::isfinite(f.guides.depth(x0, y0));
      for (int y = y0; y < y0 + kWindow && flat; ++y) {
        for (int x = x0; x < x0 + kWindow && flat; ++x) {
          flat = SameNormal(f.guides.normal, x0, y0, x, y) &&
                 std::fabs(f.guides.depth(x, y) / f.guides.depth(x0, y0) - 1) < 0.2f;
          const float a = Grey(f.guides.albedo, x, y);
          least = std::min(least, a);
          most = std::max(most, a);
        }
      }
      if (!flat || !(least > 0.01f) || most < kContrast * least) {
        continue;
      }
      const float split = std::sqrt(least * most);
      Window w;
      int count[2] = {0, 0};
      for (int y = y0; y < y0 + kWindow; ++y) {
        for (int x = x0; x < x0 + kWindow; ++x) {
          const float a = Grey(f.guides.albedo, x, y);
          const int side = a > split;
          w.albedo[side] += a;
          w.light[side] += std::min(light(x, y), kBright * static_cast<float>(mean));
          ++count[side];
        }
      }
      if (std::min(count[0], count[1]) >= kLeastInClass) {
        for (int side = 0; side < 2; ++side) {
          w.albedo[side] /= count[side];
          w.light[side] /= count[side];
        }
        windows.push_back(w);
      }
    }
  }
  if (windows.size() >= kLeastWindows) {
    exponents_.push_back({now.number, ExponentOf(windows)});
  }
}

void AlbedoCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  LookAbove(now);
  LookBlack(now);
  LookExponent(now);
}

std::vector<int64_t> AlbedoCheck::Over(const std::vector<Part>& parts, double limit,
                                       double* worst) {
  std::vector<int64_t> frames;
  *worst = 0;
  for (const Part& part : parts) {
    *worst = std::max(*worst, part.value);
    if (part.value > limit) {
      frames.push_back(part.number);
    }
  }
  return frames;
}

void AlbedoCheck::Conclude(Verdict* verdict) {
  double worst = 0;
  std::vector<int64_t> frames;
  for (const Layer& layer : layers_) {
    if (layer.above.empty()) {
      continue;
    }
    frames = Over(layer.above, kMayBeAbove, &worst);
    verdict->Add(Measure{fmt::format("{}_above_one", AovName(layer.aov)), worst, kMayBeAbove,
                         !frames.empty(), static_cast<int64_t>(layer.above.size())});
    // Random alpha weights of single pixels exceed 1 as well.
    if (!frames.empty() && !verdict->Has("albedo_above_one") &&
        !verdict->Exceeds("random_blocks")) {
      verdict->Add(Finding{
          "albedo_above_one", frames,
          fmt::format(
              "albedo in {} is above 1 in up to {:.1f} % of the pixels in {} (largest {:.3g}; "
              "expected at most 1)",
              LayerText(*layout_, layer.aov), 100 * worst, FrameRanges(frames), layer.largest),
          layout_->renderer == "blender"
              ? "Cycles counts subsurface scattering twice in DiffCol, up to 2, which does no harm "
                "where it is even; else write the reflectance alone, and lower the Base Color of "
                "materials that reflect more than they get"
              : "write the reflectance alone, without light or emission, and without a gain; "
                "materials must not reflect more than they get",
          worst, kMayBeAbove, ""});
    }
  }
  if (!black_.empty()) {
    frames = Over(black_, kMayBeBlack, &worst);
    verdict->Add(Measure{"albedo_black", worst, kMayBeBlack, !frames.empty(),
                         static_cast<int64_t>(black_.size())});
    if (!frames.empty()) {
      verdict->Add(Finding{
          "albedo_black", frames,
          fmt::format(
              "albedo in {} is black in up to {:.0f} % of the pixels with diffuse light in {} "
              "(expected below {:.0f} %)",
              LayerText(*layout_, Aov::kAlbedo), 100 * worst, FrameRanges(frames),
              100 * kMayBeBlack),
          "render the albedo pass of these frames again", worst, kMayBeBlack, ""});
    }
  }
  if (!exponents_.empty()) {
    frames = Over(exponents_, kLinearExponent, &worst);
    const bool broken =
        static_cast<double>(frames.size()) >= kAgreement * static_cast<double>(exponents_.size());
    double mean = 0;
    for (const Part& part : exponents_) {
      mean += part.value / static_cast<double>(exponents_.size());
    }
    verdict->Add(Measure{"albedo_exponent", mean, kLinearExponent, broken,
                         static_cast<int64_t>(exponents_.size())});
    if (broken) {
      verdict->Add(Finding{
          "albedo_encoded", frames,
          fmt::format(
              "albedo in {} looks sRGB-encoded: where two albedos meet, light goes with their "
              "ratio to the power of {:.1f} in {} (expected 1, at most {:.1f})",
              LayerText(*layout_, Aov::kAlbedo), mean, FrameRanges(frames), kLinearExponent),
          "write albedo scene-linear, as data (no view transform, no 8-bit format)", mean,
          kLinearExponent, ""});
    }
  }
}

}  // namespace

std::unique_ptr<Check> MakeAlbedoCheck() {
  return std::make_unique<AlbedoCheck>();
}

}  // namespace stillray::doctor
