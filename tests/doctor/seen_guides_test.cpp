// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// Denoising Data of a room with a mirror and a pane, as they are and as they should not be.
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "doctor/sequences.h"
#include "io/mirror_file.h"
#include "io/mirror_room.h"

namespace stillray::seen_guides_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

RoomPicture PictureOf(int frame, double turned = 0) {
  RoomCamera now;
  now.position.x = 0.1 * frame;
  now.pan = turned;
  RoomCamera before = now;
  before.position.x -= 0.1;
  return Trace(RoomWithMirror(), now, before);
}

/// \param spoil  called for each frame
Sequence Frames(const std::function<void(RoomPicture*, int frame)>& spoil = {}) {
  Sequence sequence;
  for (int frame = 1; frame <= 3; ++frame) {
    RoomPicture picture = PictureOf(frame);
    if (spoil) {
      spoil(&picture, frame);
    }
    sequence.push_back({frame, FileOf(picture)});
  }
  return sequence;
}

/// Those on Denoising Data: light of 1 everywhere is not natural.
std::set<std::string> SeenFindings(const Sequence& sequence) {
  std::set<std::string> names;
  for (const Finding& finding : ReportOf(sequence).findings) {
    if (finding.name.starts_with("seen_") || finding.name == "not_finite") {
      names.insert(finding.name);
    }
  }
  return names;
}

using Names = std::set<std::string>;

TEST(SeenGuides, OfTheSameRenderAreClean) {
  const DoctorReport report = ReportOf(Frames());
  int measures = 0;
  for (const Measure& measure : report.measures) {
    if (measure.name.starts_with("seen_")) {
      ++measures;
      EXPECT_LT(measure.value, 0.002) << measure.name;
      EXPECT_EQ(measure.judged, 3);
    }
  }
  EXPECT_EQ(measures, 3);
  EXPECT_EQ(SeenFindings(Frames()), Names{});
}

TEST(SeenGuides, AHalvedDepthIsNamed) {
  const Sequence sequence = Frames([](RoomPicture* picture, int) {
    for (int y = 0; y < picture->frame.height; ++y) {
      for (int x = 0; x < picture->frame.width; ++x) {
        picture->seen.depth(x, y) *= 0.5f;
      }
    }
  });
  EXPECT_EQ(SeenFindings(sequence), Names{"seen_depth_differs"});
}

TEST(SeenGuides, LayersOfAnotherViewAreNamed) {
  const auto replaced = [](const std::function<void(RoomPicture*, const RoomPicture&)>& replace) {
    return SeenFindings(
        Frames([&](RoomPicture* picture, int frame) { replace(picture, PictureOf(frame, 0.5)); }));
  };
  EXPECT_EQ(replaced([](RoomPicture* p, const RoomPicture& other) { p->seen = other.seen; }),
            Names{"seen_depth_differs"});
  EXPECT_EQ(replaced([](RoomPicture* p, const RoomPicture& other) {
              p->seen.normal = other.seen.normal;
            }),
            Names{"seen_normal_differs"});
  EXPECT_EQ(replaced([](RoomPicture* p, const RoomPicture& other) {
              p->seen.albedo = other.seen.albedo;
            }),
            Names{"seen_albedo_differs"});
}

TEST(SeenGuides, FramePartAndCureAreTold) {
  const Sequence sequence = Frames([](RoomPicture* picture, int frame) {
    if (frame == 2) {
      picture->seen.albedo = PictureOf(frame, 0.5).seen.albedo;
    }
  });
  for (const Finding& finding : ReportOf(sequence).findings) {
    if (finding.name == "seen_albedo_differs") {
      EXPECT_THAT(finding.what,
                  AllOf(HasSubstr("V.Denoising Albedo"), HasSubstr("not that in V.DiffCol"),
                        HasSubstr("in frame 2"), HasSubstr("expected at most 5 %")));
      EXPECT_THAT(finding.cure, AllOf(HasSubstr("Denoising Data of the same view layer"),
                                      HasSubstr("--aov 'seen_depth=none'")));
      EXPECT_GT(finding.measured, 0.3);
      return;
    }
  }
  FAIL() << "no finding";
}

TEST(SeenGuides, ZeroLayersAreNamed) {
  for (int layer = 0; layer < 3; ++layer) {
    const Sequence sequence = Frames([&](RoomPicture* picture, int) {
      io::SeenLayers& seen = picture->seen;
      const int width = seen.depth.width();
      const int height = seen.depth.height();
      if (layer == 0) {
        seen.depth = Image1(width, height);
      } else {
        (layer == 1 ? seen.normal : seen.albedo) = Image3(width, height);
      }
    });
    EXPECT_EQ(SeenFindings(sequence), Names{"seen_zero"}) << layer;
  }
}

TEST(SeenGuides, ValuesThatAreNotFiniteAreNamed) {
  const Sequence sequence = Frames([](RoomPicture* picture, int frame) {
    if (frame == 2) {
      picture->seen.normal[1](40, 30) = std::nanf("");
    }
  });
  EXPECT_EQ(SeenFindings(sequence), Names{"not_finite"});
}

// Without the layer that cures it names, the rest of the file is as it was.
TEST(SeenGuides, TheCureWorks) {
  const Sequence sequence =
      Frames([](RoomPicture* picture, int) { picture->seen = PictureOf(9, 0.5).seen; });
  for (const std::string& name : FindingsOf(sequence, {"auto", {"seen_depth=none"}})) {
    EXPECT_FALSE(name.starts_with("seen_")) << name;
  }
}

}  // namespace
}  // namespace stillray::seen_guides_test
