// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// fill_guides: the vector version against the scalar one, and properties of both.
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <hwy/targets.h>

#include "denoise/fill_guides/fill_guides.h"
#include "denoise/sparse_frames.h"

namespace stillray::fill_guides_test {
namespace {

using test::MakeBusyFrame;
using test::MakeSparseFrame;
using test::SparseCase;
using test::SparseCases;

using Fill = decltype(&cpu::FillGuides);

/// The planes of both as bytes: equal bits, equal text.
std::vector<std::string> Bits(const HeldGuides& held) {
  std::vector<std::string> all;
  const auto add = [&](const auto& plane) {
    std::string bytes;
    for (int y = 0; y < plane.height(); ++y) {
      for (int x = 0; x < plane.width(); ++x) {
        auto value = plane(x, y);
        value += 0;  // -0 and 0 are the same
        char text[4];
        std::memcpy(text, &value, 4);
        bytes.append(text, 4);
      }
    }
    all.push_back(bytes);
  };
  VisitHeldPlanes(held, add);
  add(held.guides.id);
  return all;
}

TEST(FillGuides, VectorVersionHasTheBitsOfTheReferenceOnEveryTarget) {
  for (const SparseCase& c : SparseCases()) {
    HeldGuides expected;
    FillGuidesWork expected_work;
    std::vector<Frame> frames;
    std::vector<std::vector<std::string>> expected_bits;
    for (int i = 0; i < 10; ++i) {
      frames.push_back(MakeSparseFrame(c, i));
      reference::FillGuides(frames.back(), &expected, &expected_work);
      expected_bits.push_back(Bits(expected));
    }
    for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      HeldGuides held;
      FillGuidesWork work;
      for (size_t i = 0; i < frames.size(); ++i) {
        cpu::FillGuides(frames[i], &held, &work);
        const std::vector<std::string> bits = Bits(held);
        ASSERT_EQ(bits.size(), expected_bits[i].size());
        for (size_t plane = 0; plane < bits.size(); ++plane) {
          EXPECT_TRUE(bits[plane] == expected_bits[i][plane])
              << c.width << "x" << c.height << " frame " << i << " plane " << plane;
        }
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
}

TEST(FillGuides, ThreadsAndAnInterruptionDoNotChangeBits) {
  // The state that still views keep between frames to save work must not change results.
  const SparseCase c = {200, 120, 40, 0.7f, true};
  HeldGuides one;
  HeldGuides many;
  FillGuidesWork work_one;
  FillGuidesWork work_many;
  for (int i = 0; i < 10; ++i) {
    const Frame f = MakeSparseFrame(c, i);
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      cpu::FillGuides(f, &one, &work_one);
    }
    if (i == 4) {
      many.first_level_valid = many.motionless = false;  // as after saving and restoring
      work_many = FillGuidesWork();
    }
    cpu::FillGuides(f, &many, &work_many);
    EXPECT_TRUE(Bits(one) == Bits(many)) << i;
  }
}

TEST(FillGuides, BlackLightTakesNoRoom) {
  const SparseCase c = {61, 45, 24, 0, false};
  for (const Fill fill : {&cpu::FillGuides, &reference::FillGuides}) {
    HeldGuides held;
    FillGuidesWork work;
    for (int i = 0; i < 6; ++i) {
      fill(MakeSparseFrame(c, i), &held, &work);
      EXPECT_TRUE(held.background.empty()) << i;
      EXPECT_EQ(held.emission.empty(), i < 3) << i;
    }
  }
}

TEST(FillGuides, KnownPixelsKeepWhatTheFrameSays) {
  const SparseCase c = {61, 45, 24, 1.3f, true};
  for (const Fill fill : {&cpu::FillGuides, &reference::FillGuides}) {
    HeldGuides held;
    FillGuidesWork work;
    for (int i = 0; i < 6; ++i) {
      const Frame f = MakeSparseFrame(c, i);
      fill(f, &held, &work);
      for (int y = 0; y < c.height; ++y) {
        for (int x = 0; x < c.width; ++x) {
          EXPECT_GT(held.guides.depth(x, y), 0.0f);
          if (f.samples(x, y) > 0) {
            EXPECT_EQ(held.known(x, y), 1.0f);
            EXPECT_EQ(held.guides.depth(x, y), f.guides.depth(x, y));
            EXPECT_EQ(held.guides.id(x, y), f.guides.id(x, y));
            EXPECT_EQ(held.guides.albedo[2](x, y), f.guides.albedo[2](x, y));
            EXPECT_EQ(held.guides.motion[0](x, y), i == 0 ? 0.0f : f.guides.motion[0](x, y));
          }
        }
      }
    }
  }
}

TEST(FillGuides, BrokenGuidesStayWithinTheirReachAndHarmNothing) {
  // NaN, infinite and negative depth, NaN motion: no crash, and every depth is one that stages
  // take.
  for (const Fill fill : {&cpu::FillGuides, &reference::FillGuides}) {
    HeldGuides held;
    FillGuidesWork work;
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeSparseFrame({61, 45, 10, 0.9f, true}, i);
      f.guides.depth(5, 5) = std::numeric_limits<float>::quiet_NaN();
      f.guides.depth(20, 20) = -3;
      f.guides.motion[0](30, 30) = std::numeric_limits<float>::quiet_NaN();
      f.guides.motion[1](40, 30) = std::numeric_limits<float>::infinity();
      f.guides.depth(30, 30) = f.guides.depth(40, 30) = 4;
      fill(f, &held, &work);
      EXPECT_EQ(held.known(5, 5), 1.0f);
      EXPECT_EQ(held.guides.depth(20, 20), -3.0f);
      int bad = 0;
      for (int y = 0; y < 45; ++y) {
        for (int x = 0; x < 61; ++x) {
          bad += !(held.guides.depth(x, y) > 0);
        }
      }
      EXPECT_LE(bad, 2 * (i + 1));
    }
  }
}

TEST(FillGuides, UnknownIsWithoutDepthAndSample) {
  Frame f = MakeBusyFrame(20, 10, 0);
  f.samples.Fill(1.0f);
  EXPECT_FALSE(HasIncompleteGuides(f));
  f.samples(19, 9) = 0;
  EXPECT_FALSE(HasIncompleteGuides(f));
  f.guides.depth(19, 9) = 0;
  EXPECT_TRUE(HasIncompleteGuides(f));
  f.samples(19, 9) = 1;
  EXPECT_FALSE(HasIncompleteGuides(f));
  f.samples = Image1();
  f.guides.depth(0, 0) = 0;
  EXPECT_FALSE(HasIncompleteGuides(f));
}

}  // namespace
}  // namespace stillray::fill_guides_test
