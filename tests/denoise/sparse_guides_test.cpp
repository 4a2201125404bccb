// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Completed guides: the vector version against the scalar one, and what both must hold to.
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <hwy/targets.h>

#include "denoise/sparse_guides.h"
#include "denoise/test_frames.h"

namespace stillray {
namespace {

using test::MakeBusyFrame;
using test::Random;

using Complete = decltype(&cpu::CompleteGuides);

/// Forgets everything of the pixels for which `known` is false.
void ForgetUnless(const std::function<bool(int, int)>& known, Frame* f) {
  for (int y = 0; y < f->height; ++y) {
    for (int x = 0; x < f->width; ++x) {
      f->samples(x, y) = known(x, y) ? 1.0f : 0.0f;
      if (known(x, y)) {
        continue;
      }
      f->guides.depth(x, y) = 0;
      f->guides.id(x, y) = 0;
      for (auto* image : {&f->guides.normal, &f->guides.albedo, &f->guides.specular_albedo,
                          &f->emission, &f->background}) {
        for (Image1& plane : image->channel) {
          plane(x, y) = 0;
        }
      }
      for (Image1& plane : f->guides.motion.channel) {
        plane(x, y) = 0;
      }
    }
  }
}

struct Case {
  int width;
  int height;
  int one_of;    ///< pixels of which one is known
  float motion;  ///< of the whole picture, in pixels per frame
  bool sky;
  bool ids = true;
};

/// Frame `index` of a case: some frames move, some are still; the lamp is seen from frame 3 on.
Frame MakeFrame(const Case& c, int index) {
  Frame f = MakeBusyFrame(c.width, c.height, index);
  for (int y = 0; y < c.height; ++y) {
    for (int x = 0; x < c.width; ++x) {
      const bool still = index % 5 >= 3 || c.motion == 0;
      f.guides.motion[0](x, y) = still ? 0.0f : c.motion * (1 + 0.01f * static_cast<float>(y));
      f.guides.motion[1](x, y) = still ? 0.0f : -0.4f * c.motion;
      if (!c.sky && !(f.guides.depth(x, y) < 1e30f)) {
        f.guides.depth(x, y) = 4;
        f.guides.id(x, y) = 9;
        f.guides.normal[1](x, y) = 1;
        for (Image1& plane : f.background.channel) {
          plane(x, y) = 0;
        }
      }
      if (index >= 3 && x > c.width / 2 && y < c.height / 2 && f.guides.depth(x, y) < 1e30f) {
        f.emission[1](x, y) = 3 + static_cast<float>(x);
      }
    }
  }
  ForgetUnless(
      [&](int x, int y) {
        return Random(static_cast<uint32_t>(y * c.width + x), static_cast<uint32_t>(index), 21) *
                   static_cast<float>(c.one_of) <
               1;
      },
      &f);
  if (!c.ids) {
    f.guides.id = Plane<uint32_t>();
  }
  return f;
}

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

const std::vector<Case>& Cases() {
  static const std::vector<Case> cases = {
      {1, 1, 2, 0, true},      {2, 7, 3, 0.3f, true},    {3, 3, 4, 0, false},
      {61, 45, 24, 0, true},   {61, 45, 24, 1.3f, true}, {100, 31, 128, 0, false},
      {81, 30, 10, 7, false},  {100, 50, 2, 0.6f, true}, {131, 40, 60, 0.4f, true, false},
      {64, 9, 50, -1.5f, true}};
  return cases;
}

TEST(SparseGuides, VectorVersionHasTheBitsOfTheReferenceOnEveryTarget) {
  for (const Case& c : Cases()) {
    HeldGuides expected;
    SparseGuidesWork expected_work;
    std::vector<Frame> frames;
    std::vector<std::vector<std::string>> expected_bits;
    for (int i = 0; i < 10; ++i) {
      frames.push_back(MakeFrame(c, i));
      reference::CompleteGuides(frames.back(), &expected, &expected_work);
      expected_bits.push_back(Bits(expected));
    }
    for (int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
      hwy::SetSupportedTargetsForTest(targets & -targets);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      HeldGuides held;
      SparseGuidesWork work;
      for (size_t i = 0; i < frames.size(); ++i) {
        cpu::CompleteGuides(frames[i], &held, &work);
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

TEST(SparseGuides, ThreadsAndAnInterruptionDoNotChangeBits) {
  // What is remembered between frames of a still view to save work must not be needed.
  const Case c = {200, 120, 40, 0.7f, true};
  HeldGuides one;
  HeldGuides many;
  SparseGuidesWork work_one;
  SparseGuidesWork work_many;
  for (int i = 0; i < 10; ++i) {
    const Frame f = MakeFrame(c, i);
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      cpu::CompleteGuides(f, &one, &work_one);
    }
    if (i == 4) {
      many.raised = many.motionless = false;  // as after saving and restoring
      work_many = SparseGuidesWork();
    }
    cpu::CompleteGuides(f, &many, &work_many);
    EXPECT_TRUE(Bits(one) == Bits(many)) << i;
  }
}

TEST(SparseGuides, BlackLightTakesNoRoom) {
  const Case c = {61, 45, 24, 0, false};
  for (const Complete complete : {&cpu::CompleteGuides, &reference::CompleteGuides}) {
    HeldGuides held;
    SparseGuidesWork work;
    for (int i = 0; i < 6; ++i) {
      complete(MakeFrame(c, i), &held, &work);
      EXPECT_TRUE(held.background.empty()) << i;
      EXPECT_EQ(held.emission.empty(), i < 3) << i;
    }
  }
}

TEST(SparseGuides, KnownPixelsKeepWhatTheFrameSays) {
  const Case c = {61, 45, 24, 1.3f, true};
  for (const Complete complete : {&cpu::CompleteGuides, &reference::CompleteGuides}) {
    HeldGuides held;
    SparseGuidesWork work;
    for (int i = 0; i < 6; ++i) {
      const Frame f = MakeFrame(c, i);
      complete(f, &held, &work);
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

TEST(SparseGuides, BrokenGuidesStayWithinTheirReachAndHarmNothing) {
  // NaN, infinite and negative depth, NaN motion: no crash, and every depth is one that stages
  // take.
  for (const Complete complete : {&cpu::CompleteGuides, &reference::CompleteGuides}) {
    HeldGuides held;
    SparseGuidesWork work;
    for (int i = 0; i < 5; ++i) {
      Frame f = MakeFrame({61, 45, 10, 0.9f, true}, i);
      f.guides.depth(5, 5) = std::numeric_limits<float>::quiet_NaN();
      f.guides.depth(20, 20) = -3;
      f.guides.motion[0](30, 30) = std::numeric_limits<float>::quiet_NaN();
      f.guides.motion[1](40, 30) = std::numeric_limits<float>::infinity();
      f.guides.depth(30, 30) = f.guides.depth(40, 30) = 4;
      complete(f, &held, &work);
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

TEST(SparseGuides, UnknownIsWithoutDepthAndSample) {
  Frame f = MakeBusyFrame(20, 10, 0);
  f.samples.Fill(1.0f);
  EXPECT_FALSE(HasUnknownGuides(f));
  f.samples(19, 9) = 0;
  EXPECT_FALSE(HasUnknownGuides(f));
  f.guides.depth(19, 9) = 0;
  EXPECT_TRUE(HasUnknownGuides(f));
  f.samples(19, 9) = 1;
  EXPECT_FALSE(HasUnknownGuides(f));
  f.samples = Image1();
  f.guides.depth(0, 0) = 0;
  EXPECT_FALSE(HasUnknownGuides(f));
}

}  // namespace
}  // namespace stillray
