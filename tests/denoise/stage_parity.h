// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

/// Comparison of a denoiser with the scalar reference: every picture between the stages, by name.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/record_largest.h"
#include "stillray/denoise.hpp"

namespace stillray::test {

/// Bounds of the difference to the reference: its root mean square over that of the reference plus
/// 1e-6, and the share of pixels whose difference is above ten times that plus a little. Some
/// pixels may be: where one version accepts a tap and the other just rejects it, the difference is
/// visible.
struct Tolerance {
  double rms;
  double outliers;
};

/// The tolerance of a picture, by its name.
using ToleranceOfName = std::function<Tolerance(const std::string& name)>;

struct Difference {
  double rms = 0;
  double outliers = 0;
};

inline Difference Compare(const Image1& a, const Image1& b, double tolerance) {
  double error = 0;
  double square = 0;
  for (int y = 0; y < b.height(); ++y) {
    for (int x = 0; x < b.width(); ++x) {
      const double d = static_cast<double>(a(x, y)) - static_cast<double>(b(x, y));
      error += std::isfinite(d) ? d * d : 1e30;
      square += static_cast<double>(b(x, y)) * static_cast<double>(b(x, y));
    }
  }
  const double pixels = static_cast<double>(b.width()) * b.height();
  const double scale = std::sqrt(square / pixels);
  Difference result;
  result.rms = std::sqrt(error / pixels) / (scale + 1e-6);
  for (int y = 0; y < b.height(); ++y) {
    for (int x = 0; x < b.width(); ++x) {
      const double d = std::abs(static_cast<double>(a(x, y)) - static_cast<double>(b(x, y)));
      const double room = std::abs(static_cast<double>(b(x, y))) + 0.1 * scale + 1e-6;
      result.outliers += d > 10 * tolerance * room ? 1 / pixels : 0.0;
    }
  }
  return result;
}

inline void ExpectImage(const NamedImage& a, const NamedImage& b, const Tolerance& t,
                        const std::string& what) {
  ASSERT_EQ(a.channels.size(), b.channels.size()) << what << " " << a.name;
  for (size_t c = 0; c < a.channels.size(); ++c) {
    const Difference d = Compare(a.channels[c], b.channels[c], t.rms);
    RecordLargest(a.name + " rms", d.rms, t.rms);
    RecordLargest(a.name + " outliers", d.outliers, t.outliers);
    EXPECT_LE(d.rms, t.rms) << what << " " << a.name << "[" << c << "]";
    EXPECT_LE(d.outliers, t.outliers) << what << " " << a.name << "[" << c << "]";
  }
}

inline Settings With(std::string_view preset,
                     std::initializer_list<std::pair<const char*, const char*>> changes) {
  Settings s = PresetSettings(preset).value();
  for (const auto& [name, value] : changes) {
    EXPECT_TRUE(SetParameter(&s, name, value).ok()) << name;
  }
  return s;
}

/// Settings beside the presets, so that every stage runs in each of its ways.
inline std::vector<Settings> OtherSettings() {
  return {
      With("default", {{"wavelet", "naive"}}),
      With("default", {{"wavelet", "eaw"}, {"steps", "2,1"}}),
      With("default", {{"kernel", "3x3"},
                       {"depth_weight", "gradient"},
                       {"max_slope", "0.01"},
                       {"feedback", "2"}}),
      With("default",
           {{"short_history", "blur"}, {"luminance", "rec601"}, {"luminance_scale", "variance"}}),
      With("default", {{"signals", "single"}, {"demodulate", "off"}, {"firefly", "clamp"}}),
      With("svgf", {{"firefly", "compress"},
                    {"wavelet_id", "on"},
                    {"steps", "4,2,1"},
                    {"prefilter_variance", "off"}}),
      With("default", {{"signals", "diffuse_specular"},
                       {"history_search", "off"},
                       {"max_history", "5"},
                       {"antialias", "taa"},
                       {"taa_tonemapped", "on"},
                       {"exposure", "1"}}),
      With("svgf", {{"antialias", "off"},
                    {"history_id", "off"},
                    {"history_taps", "nearest"},
                    {"feedback", "2"}}),
      With("svgf", {{"depth_weight", "position"}, {"wavelet_id", "on"}, {"antialias", "off"}}),
      With("eaw", {{"depth_weight", "position"}, {"position_sigma", "0.3"}}),
      With("default", {{"depth_weight", "position"}, {"curvature", "0"}, {"sigma_n", "16"}}),
      With("psvgf", {{"signals", "channels"}}),
      With("default", {{"signals", "channels"}, {"antialias", "taa"}, {"firefly", "compress"}}),
      With("default", {{"normals", "octahedral"}}),
      With("svgf", {{"normals", "octahedral"}, {"depth_weight", "position"}}),
      With("eaw", {{"normals", "octahedral"}, {"steps", "1,3,5"}}),
      With("psvgf", {{"prefilter_variance", "once"},
                     {"luminance_epsilon", "0"},
                     {"luminance_floor", "0.05"},
                     {"short_history", "spatial"},
                     {"short_history_window", "5x5"}}),
  };
}

/// Without fxaa: it decides at thresholds, where a rounding changes a pixel; it has its own test.
inline Settings WithoutFxaa(Settings settings) {
  settings.fxaa = Fxaa::kOff;
  return settings;
}

/// Denoises frames with `tested` and with the reference, and compares counts and all pictures.
/// \param tested  made with `settings`, which have no fxaa
inline void ExpectReferencePictures(const Settings& settings, Denoiser* tested, int frames,
                                    const std::function<Frame(int)>& make_frame,
                                    const ToleranceOfName& tolerance, const std::string& what) {
  Result<Denoiser> reference = Denoiser::Create(settings, Backend::kReference);
  ASSERT_TRUE(reference.ok());
  const std::vector<std::string> names = Denoiser::OutputNames(settings);
  ASSERT_TRUE(reference->SetOutputs(names).ok());
  ASSERT_TRUE(tested->SetOutputs(names).ok());
  for (int i = 0; i < frames; ++i) {
    const Frame frame = make_frame(i);
    DenoisedFrame expected;
    DenoisedFrame got;
    ASSERT_TRUE(reference->Denoise(frame, &expected).ok());
    const Status status = tested->Denoise(frame, &got);
    ASSERT_TRUE(status.ok()) << what << ": " << status.message();
    EXPECT_EQ(got.non_finite, expected.non_finite) << what;
    EXPECT_EQ(got.negative, expected.negative) << what;
    EXPECT_EQ(got.bad_guides, expected.bad_guides) << what;
    std::map<std::string, const NamedImage*> images;
    for (const NamedImage& image : got.images) {
      images[image.name] = &image;
    }
    const std::string where = what + " frame " + std::to_string(i);
    for (const NamedImage& image : expected.images) {
      if (settings.wavelet != Wavelet::kSvgf && image.name.find("variance.") == 9) {
        continue;  // filtered_variance is undefined for wavelets without one
      }
      ASSERT_TRUE(images.contains(image.name)) << where << " lacks " << image.name;
      ExpectImage(*images[image.name], image, tolerance(image.name), where);
    }
    const NamedImage colour = {"colour", {got.colour[0], got.colour[1], got.colour[2]}};
    ExpectImage(colour, {"colour", {expected.colour[0], expected.colour[1], expected.colour[2]}},
                tolerance("colour"), where);
  }
}

}  // namespace stillray::test
