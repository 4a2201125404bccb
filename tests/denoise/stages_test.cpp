// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Every stage of the vector version against the scalar reference: the pictures between the stages,
// for all kinds of settings, on frames with missing and broken samples, disocclusions and odd
// sizes, on every instruction set of this machine.
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "denoise/every_target.h"
#include "denoise/make_denoiser.h"
#include "denoise/sparse_frames.h"
#include "denoise/stage_parity.h"
#include "denoise/test_frames.h"

namespace stillray::stages_test {
namespace {

using test::MakeBusyFrame;
using test::MakeDenoiser;
using test::SparseCase;
using test::Tolerance;

/// Both versions differ in rounding and in the approximated exponentials (1.5e-5). Twice to three
/// times the differences measured on these frames, for other instruction sets.
constexpr Tolerance kRounding = {1e-6, 0};
constexpr Tolerance kLight = {1e-3, 2e-3};

bool IsSquare(const std::string& name) {
  return name.starts_with("moment_variance") || name.starts_with("limit");
}

/// Larger for values that depend on squared differences, or on lengths that limit_history reduces.
Tolerance ToleranceOf(const std::string& name) {
  return name.starts_with("noisy") ? kRounding : IsSquare(name) ? Tolerance{1e-2, 2e-3} : kLight;
}

/// One pixel whose history is cut by one version alone is a large part of a small picture.
Tolerance ToleranceOfSmall(const std::string& name) {
  return IsSquare(name) ? Tolerance{0.4, 0.04} : ToleranceOf(name);
}

/// Far from samples, sums of weights are about kMinAtrousWeight: one version may fill a pixel that
/// the other leaves, and further levels spread the difference. Pictures before the wavelet are as
/// exact as those of whole frames.
Tolerance ToleranceOfSparse(const std::string& name) {
  for (const char* filtered : {"atrous", "weights", "filtered", "aliased", "colour"}) {
    if (name.starts_with(filtered)) {
      return {0.3, 0.05};
    }
  }
  return IsSquare(name)              ? Tolerance{0.05, 2e-3}
         : name.starts_with("noisy") ? kRounding
                                     : Tolerance{2e-3, 2e-3};
}

void ExpectSame(const Settings& given, int frames, const std::function<Frame(int)>& make_frame,
                const test::ToleranceOfName& tolerance, const std::string& what) {
  const Settings settings = test::WithoutFxaa(given);
  test::OnEveryTarget([&] {
    Denoiser tested = MakeDenoiser(settings);
    test::ExpectReferencePictures(settings, &tested, frames, make_frame, tolerance, what);
  });
}

TEST(Stages, Presets) {
  for (const std::string_view preset : PresetNames()) {
    ExpectSame(
        PresetSettings(preset).value(), 4, [](int i) { return MakeBusyFrame(67, 35, i); },
        ToleranceOf, std::string(preset));
  }
}

TEST(Stages, OtherSettings) {
  int number = 0;
  for (const Settings& settings : test::OtherSettings()) {
    ExpectSame(
        settings, 4, [](int i) { return MakeBusyFrame(45, 51, i); }, ToleranceOf,
        "settings " + std::to_string(number++));
  }
}

TEST(Stages, SmallAndOddSizes) {
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{2, 1}, std::pair{1, 9}, std::pair{17, 3}, std::pair{129, 8}}) {
    for (const char* preset : {"default", "svgf", "psvgf"}) {
      ExpectSame(
          PresetSettings(preset).value(), 3,
          [w = width, h = height](int i) { return MakeBusyFrame(w, h, i); }, ToleranceOfSmall,
          std::string(preset) + " " + std::to_string(width) + "x" + std::to_string(height));
    }
  }
}

TEST(Stages, SparseFrames) {
  for (const SparseCase& c : test::SparseCases()) {
    for (const char* preset : {"default", "psvgf"}) {
      ExpectSame(
          PresetSettings(preset).value(), 5, [&](int i) { return MakeSparseFrame(c, i); },
          ToleranceOfSparse,
          std::string(preset) + " " + std::to_string(c.width) + "x" + std::to_string(c.height) +
              " 1/" + std::to_string(c.one_of));
    }
  }
}

}  // namespace
}  // namespace stillray::stages_test
