// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Checks that the radiance passes sum to the colour, and if not, finds the explanation.
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/colour_shared.h"
#include "doctor/check.h"
#include "doctor/warp.h"
#include "io/lossy.h"

namespace stillray::doctor {
namespace {

constexpr int64_t kSamples = 60000;
/// Halves differ by 0.1 %; clean Blender frames by 0.12 % in all, DWAA by 1 % or so.
constexpr float kTolerance = 0.04f;
/// Maximum fraction of values with a larger difference.
constexpr double kMayDiffer = 0.03;
constexpr double kMayDifferLossy = 0.2;
/// An explanation must hold for this fraction of the values.
constexpr double kExplains = 0.93;

/// Alternative relations between the colour and the sum of passes.
enum Explanation : size_t {
  kEncoded,
  kToneMapped,
  kAlbedoEncoded,
  kGain,
  kAboveSum,
  kExplanations
};

struct Sums {
  int64_t number = 0;
  int64_t count = 0;
  int64_t differ = 0;
  std::array<int64_t, kExplanations> explained{};  ///< kAboveSum: among those that differ
  double colour = 0;
  double passes = 0;
};

bool Near(float a, float b, float floor) {
  return std::fabs(a - b) <= kTolerance * std::max(std::fabs(a), std::fabs(b)) + floor;
}

/// With a transparent film the environment pass contains sky that is missing in the colour.
bool HidesSky(const Exhibit& now, const Image1& alpha, int x, int y) {
  const Image3& sky = now.frame.background;
  return !alpha.empty() && alpha(x, y) < 0.999f && !sky.empty() &&
         (sky[0](x, y) != 0 || sky[1](x, y) != 0 || sky[2](x, y) != 0 ||
          !std::isfinite(now.frame.guides.depth(x, y)));
}

/// The sum of the passes alone; empty if passes are missing.
Image3 SumOfPasses(const Exhibit& now, const ExrImage& image) {
  AovLayout layout = *now.layout;
  std::erase_if(layout.sources, [](const AovSource& s) { return s.aov == Aov::kColour; });
  const Result<Frame> frame = ImportFrame(image, layout, {0, 0}, now.name);
  return frame.ok() ? SumOfLight(*frame) : Image3();
}

/// The sum if the albedos of the passes are sRGB-encoded and must be decoded.
Image3 SumWithDecodedAlbedo(const Exhibit& now) {
  ExrImage image = *now.image;
  for (const Aov aov : {Aov::kAlbedo, Aov::kSpecularAlbedo, Aov::kTransmissionAlbedo}) {
    const AovSource* source = now.layout->Find(aov);
    for (Channel& channel : image.channels) {
      const bool ours = source != nullptr &&
                        std::find(source->channels.begin(), source->channels.end(), channel.name) !=
                            source->channels.end();
      for (int y = 0; ours && y < channel.values.height(); ++y) {
        for (int x = 0; x < channel.values.width(); ++x) {
          channel.values(x, y) = SrgbDecode(channel.values(x, y));
        }
      }
    }
  }
  return SumOfPasses(now, image);
}

class SumCheck : public Check {
 public:
  void Look(const Exhibit& now, const Exhibit* before) override;
  void Conclude(Verdict* verdict) override;

 private:
  Finding MakeFinding(const std::vector<int64_t>& frames, const Sums& sums) const;
  std::string MissingPasses() const;

  const AovLayout* layout_ = nullptr;
  bool lossy_ = false;
  std::vector<Sums> frames_;
};

void SumCheck::Look(const Exhibit& now, const Exhibit* /*before*/) {
  layout_ = now.layout;
  // Other renderers have lobes without a pass.
  const bool complete = layout_->renderer == "blender" || layout_->renderer == "stillray";
  if (!complete || layout_->from_colour || layout_->Find(Aov::kColour) == nullptr) {
    return;
  }
  const Image3 sum = SumOfPasses(now, *now.image);
  if (sum.empty()) {
    return;
  }
  for (const std::string& name : layout_->Find(Aov::kColour)->channels) {
    lossy_ = lossy_ || io::IsLossy(*now.image, *now.image->Find(name));
  }
  const Image3 colour = StoredColour(now, Aov::kColour);
  double mean = 0;
  const int step = SampleStep(now.frame.width, now.frame.height, kSamples);
  const Image1 alpha = StoredPlane(now, Aov::kAlpha, 0);
  Sums s;
  s.number = now.number;
  std::optional<Image3> decoded;
  const auto each = [&](const auto& body) {
    for (int y = step / 2; y < now.frame.height; y += step) {
      for (int x = step / 2; x < now.frame.width; x += step) {
        for (int c = 0; c < 3 && !HidesSky(now, alpha, x, y); ++c) {
          if (std::isfinite(colour[c](x, y)) && std::isfinite(sum[c](x, y))) {
            body(x, y, c, colour[c](x, y), sum[c](x, y));
          }
        }
      }
    }
  };
  each([&](int, int, int, float a, float b) {
    mean += std::max(a, b);
    ++s.count;
  });
  const auto floor =
      static_cast<float>(2e-3 * mean / std::max<double>(1, static_cast<double>(s.count)));
  each([&](int, int, int, float a, float b) { s.differ += !Near(a, b, floor); });
  if (static_cast<double>(s.differ) > kMayDiffer * static_cast<double>(s.count)) {
    decoded = SumWithDecodedAlbedo(now);
    each([&](int, int, int, float a, float b) {
      s.colour += a;
      s.passes += b;
    });
    const auto gain = static_cast<float>(s.colour / std::max(s.passes, 1e-30));
    each([&](int x, int y, int c, float a, float b) {
      s.explained[kGain] += Near(a, gain * b, floor);
      s.explained[kEncoded] += Near(std::min(a, 1.0f), std::min(SrgbEncode(b), 1.0f), floor);
      s.explained[kToneMapped] += Near(a, b / (1 + b), floor);
      s.explained[kAlbedoEncoded] += Near(a, (*decoded)[c](x, y), floor);
      s.explained[kAboveSum] += !Near(a, b, floor) && a > b;
    });
  }
  frames_.push_back(s);
}

/// Blender's passes that are missing in the files.
std::string SumCheck::MissingPasses() const {
  constexpr std::pair<Aov, const char*> kPasses[] = {
      {Aov::kDirectDiffuse, "Diffuse Direct"},
      {Aov::kIndirectDiffuse, "Diffuse Indirect"},
      {Aov::kDirectSpecular, "Glossy Direct"},
      {Aov::kIndirectSpecular, "Glossy Indirect"},
      {Aov::kDirectTransmission, "Transmission Direct"},
      {Aov::kIndirectTransmission, "Transmission Indirect"},
      {Aov::kDirectVolume, "Volume Direct"},
      {Aov::kEmission, "Emission"},
      {Aov::kBackground, "Environment"},
  };
  std::vector<const char*> missing;
  for (const auto& [aov, name] : kPasses) {
    if (layout_->Find(aov) == nullptr) {
      missing.push_back(name);
    }
  }
  return fmt::format("{}", fmt::join(missing, ", "));
}

Finding SumCheck::MakeFinding(const std::vector<int64_t>& frames, const Sums& s) const {
  const auto part = [&](Explanation e) {
    return static_cast<double>(s.explained[e]) / static_cast<double>(s.count);
  };
  Finding f;
  f.frames = frames;
  f.measured = static_cast<double>(s.differ) / static_cast<double>(s.count);
  f.expected = lossy_ ? kMayDifferLossy : kMayDiffer;
  const std::string where = fmt::format(
      "in {}, {:.0f} % of the values of {} differ from the sum of the passes (expected "
      "below {:.0f} %)",
      FrameRanges(frames), 100 * f.measured, LayerText(*layout_, Aov::kColour), 100 * f.expected);
  const std::string without =
      layout_->ignores_colour
          ? "stillray denoise takes the passes alone, as with --aov 'colour=none'"
          : "stillray denoise with --aov 'colour=none' takes the passes alone";
  const std::string missing = MissingPasses();
  if (part(kEncoded) > kExplains) {
    f.name = "light_encoded";
    f.what = "the colour is encoded as sRGB: " + where + ", and are its sRGB encoding";
    f.cure = "write the colour scene-linear (no view transform); or " + without;
    f.aov = "colour=none";
  } else if (part(kToneMapped) > kExplains) {
    f.name = "light_tone_mapped";
    f.what = "the colour is tone-mapped: " + where + ", and are x / (1 + x) of it";
    f.cure = "write the colour scene-linear (no film curve); or " + without;
    f.aov = "colour=none";
  } else if (part(kAlbedoEncoded) > kExplains) {
    f.name = "albedo_encoded";
    f.what = "albedo is encoded as sRGB: " + where +
             ", and agree once the colours of the passes are decoded";
    f.cure = "write the colour passes scene-linear, as data (no view transform)";
  } else if (layout_->renderer == "blender" && !missing.empty() && part(kGain) < kExplains &&
             static_cast<double>(s.explained[kAboveSum]) > 0.95 * static_cast<double>(s.differ)) {
    f.name = "passes_missing";
    f.what =
        fmt::format("the colour holds light that no pass has: {}; the passes have {:.0f} % of it",
                    where, 100 * s.passes / std::max(s.colour, 1e-30));
    f.cure = "switch on the passes that are not there: " + missing;
  } else {
    f.name = "passes_do_not_add_up";
    f.what =
        fmt::format("the passes do not add up to the colour: {}; its mean is {:.3g} times theirs",
                    where, s.colour / std::max(s.passes, 1e-30));
    f.cure =
        "switch off what changes the colour alone (denoising, compositing, exposure, a clamp); "
        "or " +
        without;
    f.aov = "colour=none";
  }
  return f;
}

void SumCheck::Conclude(Verdict* verdict) {
  if (frames_.empty()) {
    return;
  }
  const double limit = lossy_ ? kMayDifferLossy : kMayDiffer;
  std::vector<int64_t> frames;
  double largest = -1;
  Sums all;
  for (const Sums& s : frames_) {
    const double part =
        s.count == 0 ? 0 : static_cast<double>(s.differ) / static_cast<double>(s.count);
    largest = std::max(largest, part);
    if (part > limit) {
      frames.push_back(s.number);
      all.count += s.count;
      all.differ += s.differ;
      all.colour += s.colour;
      all.passes += s.passes;
      for (size_t e = 0; e < kExplanations; ++e) {
        all.explained[e] += s.explained[e];
      }
    }
  }
  verdict->Add(Measure{"sum_differs", largest, limit, !frames.empty(),
                       static_cast<int64_t>(frames_.size())});
  if (!frames.empty()) {
    verdict->Add(MakeFinding(frames, all));
  }
}

}  // namespace

std::unique_ptr<Check> MakeSumCheck() {
  return std::make_unique<SumCheck>();
}

}  // namespace stillray::doctor
