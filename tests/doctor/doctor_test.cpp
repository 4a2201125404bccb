// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0

// The doctor as a whole: numbers, errors, cures that work, the same report for any threads.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "doctor/sequences.h"

namespace stillray::doctor_test {
namespace {

using ::testing::HasSubstr;
using Names = std::set<std::string>;

TEST(FrameRangesText, JoinsWhatFollows) {
  EXPECT_EQ(FrameRanges({7}), "frame 7");
  EXPECT_EQ(FrameRanges({1, 2, 3, 9, 11, 12}), "frames 1-3, 9, 11-12");
  EXPECT_EQ(FrameRanges({-2, -1, 0}), "frames -2-0");
  std::vector<int64_t> odd;
  for (int i = 1; i < 30; i += 2) {
    odd.push_back(i);
  }
  EXPECT_THAT(FrameRanges(odd), HasSubstr("15 and 7 more ranges"));
}

TEST(FindingTableText, HasEveryNameOnce) {
  std::set<std::string_view> names;
  for (const FindingInfo& info : FindingTable()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(info.meaning.empty());
  }
}

TEST(FindingTableText, IsInTheDocumentation) {
  std::ifstream file(STILLRAY_CHECK_PAGE);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  for (const FindingInfo& info : FindingTable()) {
    std::string name(1, '`');
    name.append(info.name).push_back('`');
    EXPECT_THAT(page, HasSubstr(name));
  }
}

ExrImage Grey(int width, int height) {
  ExrImage image;
  image.width = width;
  image.height = height;
  Image3 colour(width, height);
  for (int c = 0; c < 3; ++c) {
    colour[c].Fill(0.5f);
  }
  image.Add("", PixelType::kHalf, colour);
  return image;
}

TEST(DoctorErrors, NothingToReport) {
  const auto doctor = Doctor::Create({});
  EXPECT_EQ(doctor->Report().status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(doctor->layout(), nullptr);
}

TEST(DoctorErrors, NumbersMustRise) {
  const auto doctor = Doctor::Create({});
  ASSERT_TRUE(doctor->Add(4, "a", Grey(8, 8)).ok());
  const Status status = doctor->Add(4, "b.exr", Grey(8, 8));
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), HasSubstr("b.exr: is frame 4, expected one after 4"));
}

TEST(DoctorErrors, AFileWithoutLight) {
  ExrImage image;
  image.width = 4;
  image.height = 4;
  image.Add("depth.Z", PixelType::kFloat, Image1(4, 4));
  const auto doctor = Doctor::Create({});
  EXPECT_EQ(doctor->Add(1, "a", image).code(), StatusCode::kNotFound);
}

// Every check gets through pictures of a few pixels, of one, and of nothing but damage.
TEST(DoctorErrors, TinyAndBrokenPicturesAreNoCrash) {
  for (const auto& [width, height] : {std::pair(1, 1), {1, 7}, {9, 1}, {3, 2}, {17, 17}}) {
    for (const float value : {0.0f, 1.0f, -1.0f, std::nanf(""), INFINITY, 1e30f}) {
      ExrImage image = Grey(width, height);
      Image3 plane(width, height);
      for (int c = 0; c < 3; ++c) {
        plane[c].Fill(value);
      }
      for (const char* layer : {"direct_diffuse.", "albedo.", "emission.", "background."}) {
        image.Add(layer, PixelType::kFloat, plane);
      }
      image.Add("normal.", PixelType::kFloat, plane, true);
      image.Add("depth.Z", PixelType::kFloat, plane[0]);
      image.Add("motion.X", PixelType::kFloat, plane[0]);
      image.Add("motion.Y", PixelType::kFloat, plane[1]);
      Sequence sequence;
      for (int i = 0; i < 3; ++i) {
        sequence.push_back({i, image});
        ChannelOf(sequence.back().image, "R").values(0, 0) = 0.25f * static_cast<float>(i);
      }
      EXPECT_GT(ReportOf(sequence).measures.size(), 5u);
    }
  }
}

TEST(DoctorThreads, TheSameReport) {
  const Sequence sequence = RenderSequence({});
  const auto text = [&] {
    std::string all;
    for (const Measure& m : ReportOf(sequence).measures) {
      all += m.name + " " + std::to_string(m.value) + " " + std::to_string(m.judged) + "\n";
    }
    return all;
  };
  const std::string many = text();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(text(), many);
}

/// Writes the frames to the test's folder.
std::vector<NumberedFile> FilesOf(const Sequence& sequence) {
  std::vector<NumberedFile> files;
  for (const NumberedImage& frame : sequence) {
    files.push_back({frame.number,
                     ::testing::TempDir() + "/examined_" + std::to_string(frame.number) + ".exr"});
    EXPECT_TRUE(WriteExr(files.back().path, frame.image).ok());
  }
  return files;
}

TEST(ExaminedFiles, GiveTheReportOfTheirFrames) {
  Sequence sequence = RenderSequence({.frames = 2});
  ChannelOf(sequence[1].image, "albedo.G").values(5, 6) = std::nanf("");
  const std::vector<NumberedFile> files = FilesOf(sequence);
  const Result<DoctorReport> report = ExamineFiles(files, {});
  ASSERT_TRUE(report.ok()) << report.status().message();
  EXPECT_EQ(report->frames, (std::vector<int64_t>{1, 2}));
  ASSERT_EQ(report->findings.size(), 1u);
  const std::string line = FindingLine(report->findings[0]);
  EXPECT_TRUE(line.starts_with("not_finite: "));
  EXPECT_THAT(line, HasSubstr("; cure: "));
  EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST(ExaminedFiles, StopWhereTheCallerSaysSo) {
  const std::vector<NumberedFile> files = FilesOf(RenderSequence({.frames = 2}));
  int calls = 0;
  const Result<DoctorReport> report = ExamineFiles(files, {}, [&] { return ++calls < 2; });
  EXPECT_EQ(report.status().code(), StatusCode::kCancelled);
  EXPECT_EQ(calls, 2);
}

TEST(ExaminedFiles, NameTheFileThatCannotBeRead) {
  const std::vector<NumberedFile> files = {{1, "/nonexistent/a.exr"}};
  EXPECT_THAT(ExamineFiles(files, {}).status().message(), HasSubstr("/nonexistent/a.exr"));
}

TEST(Findings, TellTheFrames) {
  Sequence sequence = RenderSequence({});
  ChannelOf(sequence[1].image, "albedo.G").values(5, 6) = std::nanf("");
  const DoctorReport report = ReportOf(sequence);
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].frames, std::vector<int64_t>{2});
  EXPECT_THAT(report.findings[0].what, HasSubstr("albedo.G of frame 2 at x 5, y 6"));
}

TEST(Findings, NameLossyLayersCodecAndCure) {
  ExrImage image = Grey(16, 16);
  image.Add("motion.X", PixelType::kFloat, Image1(16, 16));
  image.Add("motion.Y", PixelType::kFloat, Image1(16, 16));
  image.compression_name = "dwab";
  const DoctorReport report = ReportOf({{1, image}});
  const auto lossy = std::find_if(report.findings.begin(), report.findings.end(),
                                  [](const Finding& f) { return f.name == "lossy_compression"; });
  ASSERT_NE(lossy, report.findings.end());
  EXPECT_THAT(lossy->what,
              HasSubstr("2 layers are compressed with DWAB, which is lossy, in frame 1"));
  EXPECT_THAT(lossy->what, HasSubstr("motion"));
  EXPECT_THAT(lossy->cure, HasSubstr("ZIP"));
}

TEST(Findings, LargeGapsAreNotListedForever) {
  Sequence sequence = RenderSequence({.frames = 2});
  sequence[1].number = int64_t{1} << 60;
  EXPECT_EQ(FindingsOf(sequence), Names{"frames_missing"});
}

struct Cure {
  const char* name;
  std::function<void(Sequence*)> plant;
};
const Cure kCures[] = {
    {"motion_direction",
     [](Sequence* s) { ChangeLayer(s, "motion.", [](float v, int, int) { return -v; }); }},
    {"motion_y_flipped",
     [](Sequence* s) { ChangeChannel(s, "motion.Y", [](float v, int, int) { return -v; }); }},
    {"motion_x_flipped",
     [](Sequence* s) { ChangeChannel(s, "motion.X", [](float v, int, int) { return -v; }); }},
    {"motion_swapped", [](Sequence* s) { SwapChannels(s, "motion.X", "motion.Y"); }},
    {"motion_fraction",
     [](Sequence* s) {
       ChangeChannel(s, "motion.X", [](float v, int, int) { return -v / 192; });
       ChangeChannel(s, "motion.Y", [](float v, int, int) { return v / 108; });
     }},
    {"motion_ndc",
     [](Sequence* s) {
       ChangeChannel(s, "motion.X", [](float v, int, int) { return v / 96; });
       ChangeChannel(s, "motion.Y", [](float v, int, int) { return v / 54; });
     }},
    {"motion_scaled",
     [](Sequence* s) { ChangeLayer(s, "motion.", [](float v, int, int) { return 2 * v; }); }},
    {"normal_encoded",
     [](Sequence* s) {
       ChangeLayer(s, "normal.", [](float v, int, int) { return 0.5f * v + 0.5f; });
     }},
    {"depth_reversed",
     [](Sequence* s) { ChangeLayer(s, "depth.", [](float v, int, int) { return 0.1f / v; }); }},
    {"depth_ray",
     [](Sequence* s) {
       ChangeLayer(s, "depth.", [](float v, int x, int y) {
         const float dx = (static_cast<float>(x) - 95.5f) / 150;
         const float dy = (static_cast<float>(y) - 53.5f) / 150;
         return v * std::sqrt(1 + dx * dx + dy * dy);
       });
     }},
    {"depth_normalised",
     [](Sequence* s) {
       ChangeLayer(s, "depth.", [](float v, int, int) { return (v - 0.5f) / 40; });
     }},
};

class Cures : public ::testing::TestWithParam<Cure> {};

TEST_P(Cures, WorkWhenFollowed) {
  Sequence sequence = RenderSequence({.width = 192, .height = 108});
  GetParam().plant(&sequence);
  const DoctorReport report = ReportOf(sequence);
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].name, GetParam().name);
  EXPECT_THAT(report.findings[0].cure, HasSubstr(report.findings[0].aov));
  ASSERT_FALSE(report.findings[0].aov.empty());
  EXPECT_EQ(FindingsOf(sequence, {"auto", {report.findings[0].aov}}), Names());
}

INSTANTIATE_TEST_SUITE_P(All, Cures, ::testing::ValuesIn(kCures),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace stillray::doctor_test
