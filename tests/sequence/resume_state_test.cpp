// SPDX-FileCopyrightText: the stillray developers
// SPDX-License-Identifier: Apache-2.0
#include "sequence/resume_state.h"

#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/test_files.h"
#include "stillray/io.h"

namespace stillray::resume_state_test {
namespace {

using ::testing::HasSubstr;

constexpr const char* kKey = "denoise to f.####.exr";

Image3 Picture(float value) {
  Image3 picture(5, 3);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        picture[c](x, y) = value + static_cast<float>(x + 10 * y + 100 * c);
      }
    }
  }
  return picture;
}

ResumeState State() {
  ResumeState state;
  state.key = kKey;
  state.fingerprint = "alpha 0.1\nwindow both\n";
  state.log = "log";
  state.last_frame = -3;
  state.inputs = {{"in.1.exr", 10, 20}, {"in.2.exr", 30, 40}};
  const Image3 layer = Picture(0.25f);
  state.unwritten.push_back({-2, Picture(0.5f), {{"diffuse", {layer[0], layer[1], layer[2]}}}});
  state.history = {1, 2, 3, 255};
  return state;
}

void Save(const std::string& folder, const ResumeState& state) {
  size_t synced = 0;
  const Status saved = SaveResumeState(folder, state, &synced);
  ASSERT_TRUE(saved.ok()) << saved.message();
}

TEST(ResumeState, ComesBackAsItWasSaved) {
  const TempFolder folder;
  Save(folder.Path(""), State());
  const Result<ResumeState> loaded = LoadResumeState(folder.Path(""), kKey);
  ASSERT_TRUE(loaded.ok()) << loaded.status().message();
  const ResumeState saved = State();
  EXPECT_EQ(loaded->fingerprint, saved.fingerprint);
  EXPECT_EQ(loaded->log, saved.log);
  EXPECT_EQ(loaded->last_frame, saved.last_frame);
  EXPECT_EQ(loaded->history, saved.history);
  ASSERT_EQ(loaded->inputs.size(), 2u);
  EXPECT_EQ(loaded->inputs[1].name, "in.2.exr");
  EXPECT_EQ(loaded->inputs[1].bytes, 30u);
  EXPECT_EQ(loaded->inputs[1].checksum, 40u);
  ASSERT_EQ(loaded->unwritten.size(), 1u);
  const UnwrittenFrame& frame = loaded->unwritten[0];
  EXPECT_EQ(frame.frame, -2);
  ASSERT_EQ(frame.images.size(), 1u);
  EXPECT_EQ(frame.images[0].name, "diffuse");
  ASSERT_EQ(frame.images[0].channels.size(), 3u);
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        EXPECT_EQ(frame.colour[c](x, y), Picture(0.5f)[c](x, y));
        EXPECT_EQ(frame.images[0].channels[static_cast<size_t>(c)](x, y), Picture(0.25f)[c](x, y));
      }
    }
  }
}

TEST(ResumeState, RunsOfOtherKeysLieBesideEachOther) {
  const TempFolder folder;
  Save(folder.Path(""), State());
  ResumeState other = State();
  other.key = "render frames from 1";
  other.log = "other";
  Save(folder.Path(""), other);
  EXPECT_EQ(LoadResumeState(folder.Path(""), kKey)->log, "log");
  EXPECT_EQ(LoadResumeState(folder.Path(""), other.key)->log, "other");
  RemoveResumeState(folder.Path(""), kKey);
  EXPECT_EQ(LoadResumeState(folder.Path(""), kKey).status().code(), StatusCode::kNotFound);
  EXPECT_EQ(LoadResumeState(folder.Path(""), other.key)->log, "other");
}

TEST(ResumeState, AnotherVersionIsRefusedByName) {
  const TempFolder folder;
  Save(folder.Path(""), State());
  const std::string path = ResumePath(folder.Path(""), kKey);
  std::string bytes = FileBytes(path);
  const std::string magic = "stillray resume ";
  ASSERT_EQ(bytes.compare(0, magic.size(), magic), 0);
  bytes[magic.size()] = '2';
  ASSERT_TRUE(WriteFileAtomically(path, bytes.data(), bytes.size()).ok());
  const Result<ResumeState> loaded = LoadResumeState(folder.Path(""), kKey);
  EXPECT_EQ(loaded.status().code(), StatusCode::kBadData);
  EXPECT_THAT(loaded.status().message(),
              HasSubstr("resume.stillray was saved by another version of stillray; remove it to "
                        "start again"));
}

TEST(ResumeState, EveryCutIsFound) {
  const TempFolder folder;
  Save(folder.Path(""), State());
  const std::string path = ResumePath(folder.Path(""), kKey);
  const std::string bytes = FileBytes(path);
  for (size_t size = 20; size < bytes.size(); size += 37) {
    ASSERT_TRUE(WriteFileAtomically(path, bytes.data(), size).ok());
    EXPECT_EQ(LoadResumeState(folder.Path(""), kKey).status().code(), StatusCode::kBadData) << size;
  }
}

TEST(ResumeState, NamesTheFirstDifferenceOfFingerprints) {
  EXPECT_EQ(FingerprintDifference("a 1\nb 2\n", "a 1\nb 2\n"), "");
  EXPECT_EQ(FingerprintDifference("a 1\nb 2\n", "a 1\nb 3\n"),
            "it was made with 'b 2', this run has 'b 3'");
  EXPECT_EQ(FingerprintDifference("a 1\nb 2\n", "a 1\nb 2\nb 3\n"),
            "it was made with '', this run has 'b 3'");
}

// As after an update of the program.
TEST(ResumeState, NamesASettingThatOnlyOneOfThemHas) {
  EXPECT_EQ(FingerprintDifference("a 1\n", "a 1\nb 3\n"), "it was made without the setting 'b 3'");
  EXPECT_EQ(FingerprintDifference("a 1\nc 2\n", "a 1\nb 3\nc 2\n"),
            "it was made without the setting 'b 3'");
  EXPECT_EQ(FingerprintDifference("a 1\nb 3\nc 2\n", "a 1\nc 2\n"),
            "it was made with 'b 3', a setting that this run does not have");
}

}  // namespace
}  // namespace stillray::resume_state_test
